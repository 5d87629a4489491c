//! Delay line: samples that wait for the decision of the detector.

use crate::types::health::Flags;
use crate::types::sample::ImuSample;

/// A calibrated sample and its flags.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PendingSample {
    pub(crate) sample: ImuSample,
    pub(crate) flags: Flags,
}

/// The samples that wait, in the order of their arrival.
///
/// Each is copied once, to where it is read in the end; a queue of the standard library takes it by
/// way of the stack, and what has just been stored there in other pieces must be waited for.
#[derive(Clone, Debug)]
pub(crate) struct DelayLine {
    /// A ring.
    places: Vec<Option<PendingSample>>,
    /// Where the next one comes.
    next: usize,
    count: usize,
}

impl DelayLine {
    /// With room for `samples`; there will be more if they have to wait for longer.
    pub(crate) fn with_capacity(samples: usize) -> Self {
        Self { places: vec![None; samples + 1], next: 0, count: 0 }
    }

    #[inline]
    pub(crate) fn push(&mut self, sample: &ImuSample, flags: Flags) {
        if self.count == self.places.len() {
            self.grow();
        }
        self.places[self.next] = Some(PendingSample { sample: *sample, flags });
        self.next = if self.next + 1 == self.places.len() { 0 } else { self.next + 1 };
        self.count += 1;
    }

    /// The one that has waited for longest.
    #[inline]
    pub(crate) fn oldest(&self) -> Option<&PendingSample> {
        if self.count == 0 {
            return None;
        }
        let before = if self.next < self.count { self.places.len() } else { 0 };
        self.places[self.next + before - self.count].as_ref()
    }

    /// The oldest waits no longer.
    #[inline]
    pub(crate) fn release(&mut self) {
        self.count = self.count.saturating_sub(1);
    }

    /// The newest sample, whether it waits or not.
    pub(crate) fn newest(&self) -> Option<&ImuSample> {
        self.last(1).next().map(|pending| &pending.sample)
    }

    /// Those that wait, the oldest first.
    pub(crate) fn iter(&self) -> impl Iterator<Item = &PendingSample> {
        self.last(self.count)
    }

    pub(crate) fn len(&self) -> usize {
        self.count
    }

    fn last(&self, count: usize) -> impl Iterator<Item = &PendingSample> {
        let (later, earlier) = self.places.split_at(self.next);
        earlier.iter().chain(later).skip(self.places.len() - count).flatten()
    }

    #[cold]
    fn grow(&mut self) {
        self.places.rotate_left(self.next);
        self.next = self.places.len();
        self.places.resize(2 * self.places.len(), None);
    }
}

#[cfg(test)]
mod tests {
    use std::collections::VecDeque;

    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn samples_leave_in_the_order_in_which_they_came(
            room in 0usize..4,
            pushes in prop::collection::vec(any::<bool>(), 0..40),
        ) {
            let mut waiting = DelayLine::with_capacity(room);
            let (mut expected, mut newest) = (VecDeque::new(), None);
            for (k, push) in (0_u16..).zip(pushes) {
                if push {
                    let number = f64::from(k);
                    let pending = PendingSample {
                        sample: ImuSample::new(number, [number; 3], [-number; 3]),
                        flags: Flags::from_bits_truncate(k),
                    };
                    waiting.push(&pending.sample, pending.flags);
                    expected.push_back(pending);
                    newest = Some(pending.sample);
                } else {
                    prop_assert_eq!(waiting.oldest().copied(), expected.pop_front());
                    waiting.release();
                }
                prop_assert_eq!(waiting.len(), expected.len());
                prop_assert!(waiting.iter().eq(&expected));
                prop_assert_eq!(waiting.newest().copied(), newest);
            }
        }
    }
}
