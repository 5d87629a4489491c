//! Bookkeeping of the latency of a detector.

/// Counts the samples whose decision is pending.
#[derive(Clone, Debug)]
pub(crate) struct LatencyCounter {
    latency: usize,
    /// Samples missing until the first decision is due.
    missing: usize,
    /// Samples without a decision.
    pending: usize,
}

impl LatencyCounter {
    /// A counter for decisions with a latency of `latency` samples.
    pub(crate) fn new(latency: usize) -> Self {
        Self { latency, missing: latency, pending: 0 }
    }

    pub(crate) fn latency(&self) -> usize {
        self.latency
    }

    /// Counts a sample; returns whether the decision about the sample `latency` samples earlier is
    /// due.
    pub(crate) fn push(&mut self) -> bool {
        if self.missing == 0 {
            return true;
        }
        self.missing -= 1;
        self.pending += 1;
        false
    }

    /// Number of samples beyond the end of the data that the next decision needs; none when no
    /// decision is pending.
    pub(crate) fn drain(&mut self) -> Option<usize> {
        self.pending = self.pending.checked_sub(1)?;
        Some(std::mem::take(&mut self.missing) + 1)
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
        fn every_sample_has_one_decision_at_the_latency(
            latency in 0usize..6, samples in 0usize..12,
        ) {
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
