//! What the navigator does on the best lanes of the processor.

use crate::detectors::detector::Decision;
use crate::error::Error;
use crate::math::simd::{Lanes, Work};
use crate::pipeline::delay_line::PendingSample;
use crate::pipeline::navigator::Navigator;
use crate::types::sample::ImuSample;

/// See [`Navigator::advance`].
pub(crate) struct Advance<'a> {
    pub(crate) navigator: &'a mut Navigator,
    pub(crate) raw: &'a ImuSample,
}

impl Work for Advance<'_> {
    type Output = Result<bool, Error>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self { navigator, raw } = self;
        navigator.check_running()?;
        let events = navigator.validator.ingest(raw)?;
        navigator.take::<L>(raw, events)
    }
}

/// See [`Navigator::process_block`]; the block was found good.
pub(crate) struct Follow<'a, F> {
    pub(crate) navigator: &'a mut Navigator,
    pub(crate) block: &'a [ImuSample],
    pub(crate) output: F,
}

impl<F: FnMut(&Navigator)> Work for Follow<'_, F> {
    type Output = Result<(), Error>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self { navigator, block, mut output } = self;
        for raw in block {
            let events = navigator.validator.ingest_checked(raw);
            if navigator.take::<L>(raw, events)? {
                output(navigator);
            }
        }
        Ok(())
    }
}

/// See [`Navigator::release`].
pub(crate) struct Release<'a> {
    pub(crate) navigator: &'a mut Navigator,
    pub(crate) decision: &'a Decision,
}

impl Work for Release<'_> {
    type Output = Result<bool, Error>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        self.navigator.release::<L>(self.decision)
    }
}

/// See [`Navigator::update_general`].
///
/// It owns what it needs, so that what is handed to the more frequent case may stay in registers.
pub(crate) struct SolveInFull<'a> {
    pub(crate) navigator: &'a mut Navigator,
    pub(crate) pending: PendingSample,
    pub(crate) decision: Decision,
}

impl Work for SolveInFull<'_> {
    type Output = Result<bool, Error>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        self.navigator.update_general::<L>(&self.pending, &self.decision)
    }
}
