//! Debouncing of a detection: short gaps are filled, then short detections are removed.

use std::collections::VecDeque;

/// Fills short gaps, then removes short detections.
///
/// There is no detection outside the data, so a gap at their start or end is not filled.
#[derive(Clone, Debug)]
pub(crate) struct Debounce {
    gaps: LongRuns,
    detections: LongRuns,
}

impl Debounce {
    /// Fills gaps of up to `longest_gap` samples, then removes detections of fewer than
    /// `shortest_detection` samples.
    pub(crate) fn new(longest_gap: usize, shortest_detection: usize) -> Self {
        Self {
            gaps: LongRuns::new(false, longest_gap + 1),
            detections: LongRuns::new(true, shortest_detection.max(1)),
        }
    }

    /// Latency of the output, samples.
    pub(crate) fn latency(&self) -> usize {
        self.gaps.latency() + self.detections.latency()
    }

    /// Takes the detection of the next sample; returns the debounced one of the sample `latency`
    /// samples earlier, if it exists.
    pub(crate) fn push(&mut self, detected: bool) -> Option<bool> {
        self.gaps.push(detected).and_then(|filled| self.detections.push(filled))
    }

    pub(crate) fn reset(&mut self) {
        self.gaps.reset();
        self.detections.reset();
    }
}

/// Inverts every run of `value` that is shorter than `shortest`.
#[derive(Clone, Debug)]
struct LongRuns {
    value: bool,
    shortest: usize,
    /// Length of the current run of `value`.
    run: usize,
    /// Outputs that the current run can still change.
    pending: VecDeque<bool>,
}

impl LongRuns {
    fn new(value: bool, shortest: usize) -> Self {
        let mut runs = Self { value, shortest, run: 0, pending: VecDeque::with_capacity(shortest) };
        runs.reset();
        runs
    }

    fn latency(&self) -> usize {
        self.shortest - 1
    }

    fn push(&mut self, input: bool) -> Option<bool> {
        let was_long = self.run >= self.shortest;
        self.run = if input == self.value { self.run.saturating_add(1) } else { 0 };
        let long = self.run >= self.shortest;
        if long && !was_long {
            self.pending.iter_mut().for_each(|output| *output = self.value);
        }
        self.pending.push_back(if long { self.value } else { !self.value });
        if self.pending.len() > self.latency() { self.pending.pop_front() } else { None }
    }

    fn reset(&mut self) {
        self.pending.clear();
        self.run = if self.value { 0 } else { self.shortest };
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Reference: inverts the runs of the whole data.
    fn inverted(
        mut values: Vec<bool>,
        value: bool,
        invert: impl Fn(usize, usize) -> bool,
    ) -> Vec<bool> {
        let mut start = 0;
        while start < values.len() {
            let length = values[start..].iter().take_while(|&&v| v == values[start]).count();
            if values[start] == value && invert(start, length) {
                values[start..start + length].fill(!value);
            }
            start += length;
        }
        values
    }

    proptest! {
        #[test]
        fn streamed_debouncing_equals_that_of_the_whole_data(
            values in prop::collection::vec(any::<bool>(), 0..80),
            gap in 0usize..6,
            shortest in 0usize..7,
        ) {
            let end = values.len();
            let inside = |start: usize, length: usize| start > 0 && start + length < end;
            let is_gap = |start: usize, length: usize| inside(start, length) && length <= gap;
            let filled = inverted(values.clone(), false, is_gap);
            let expected = inverted(filled, true, |_, length| length < shortest);
            let mut debounce = Debounce::new(gap, shortest);
            let latency = debounce.latency();
            let padded = values.iter().copied().chain(std::iter::repeat_n(false, latency));
            let output: Vec<bool> = padded.filter_map(|value| debounce.push(value)).collect();
            prop_assert_eq!(output, expected);
        }
    }
}
