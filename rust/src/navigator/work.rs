//! What the navigator does on the best lanes of the processor.

use crate::detector::Decision;
use crate::error::Error;
use crate::lanes::{Lanes, Work};
use crate::navigator::{Arrived, Navigator};
use crate::sample::ImuSample;

/// See [`Navigator::advance`].
pub(super) struct Advance<'a> {
    pub(super) navigator: &'a mut Navigator,
    pub(super) raw: &'a ImuSample,
}

impl Work for Advance<'_> {
    type Output = Result<bool, Error>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self { navigator, raw } = self;
        navigator.check_running()?;
        let events = navigator.intake.accept(raw)?;
        navigator.take::<L>(raw, events)
    }
}

/// See [`Navigator::follow`]; the block was found good.
pub(super) struct Follow<'a, F> {
    pub(super) navigator: &'a mut Navigator,
    pub(super) block: &'a [ImuSample],
    pub(super) came_out: F,
}

impl<F: FnMut(&Navigator)> Work for Follow<'_, F> {
    type Output = Result<(), Error>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self { navigator, block, mut came_out } = self;
        for raw in block {
            let events = navigator.intake.admit(raw);
            if navigator.take::<L>(raw, events)? {
                came_out(navigator);
            }
        }
        Ok(())
    }
}

/// See [`Navigator::release`].
pub(super) struct Release<'a> {
    pub(super) navigator: &'a mut Navigator,
    pub(super) decision: &'a Decision,
}

impl Work for Release<'_> {
    type Output = Result<bool, Error>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        self.navigator.release::<L>(self.decision)
    }
}

/// See [`Navigator::solve_in_full`].
///
/// It owns what it needs, so that what is handed to the more frequent case may stay in registers.
pub(super) struct SolveInFull<'a> {
    pub(super) navigator: &'a mut Navigator,
    pub(super) arrived: Arrived,
    pub(super) decision: Decision,
}

impl Work for SolveInFull<'_> {
    type Output = Result<bool, Error>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        self.navigator.solve_in_full::<L>(&self.arrived, &self.decision)
    }
}
