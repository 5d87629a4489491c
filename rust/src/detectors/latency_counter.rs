//! Which samples wait for their decision.

/// Counts the samples without a decision, of a detector whose decisions come late.
#[derive(Clone, Debug)]
pub(crate) struct LatencyCounter {
    latency: usize,
    /// Samples that have to come before the first decision is due.
    early: usize,
    waiting: usize,
}

impl LatencyCounter {
    /// Of decisions that come `latency` samples late.
    pub(crate) fn new(latency: usize) -> Self {
        Self { latency, early: latency, waiting: 0 }
    }

    pub(crate) fn latency(&self) -> usize {
        self.latency
    }

    /// One more sample came: whether a decision is due, about the one `latency` before it.
    pub(crate) fn push(&mut self) -> bool {
        if self.early == 0 {
            return true;
        }
        self.early -= 1;
        self.waiting += 1;
        false
    }

    /// After the last sample: how many samples would still have to come for the next decision; none
    /// when nothing waits.
    pub(crate) fn drain(&mut self) -> Option<usize> {
        self.waiting = self.waiting.checked_sub(1)?;
        Some(std::mem::take(&mut self.early) + 1)
    }

    pub(crate) fn reset(&mut self) {
        *self = Self::new(self.latency);
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn every_sample_gets_one_decision_when_as_many_came_after_it(latency in 0usize..6, samples in 0usize..12) {
            let mut latency_counter = LatencyCounter::new(latency);
            let mut decided = (0..samples).filter(|_| latency_counter.push()).count();
            prop_assert_eq!(decided, samples.saturating_sub(latency));
            let mut after = samples;
            while let Some(steps) = latency_counter.drain() {
                after += steps;
                prop_assert_eq!(after, decided + latency + 1);
                decided += 1;
            }
            prop_assert_eq!(decided, samples);
            latency_counter.reset();
            prop_assert_eq!((0..=latency).filter(|_| latency_counter.push()).count(), 1);
        }
    }
}
