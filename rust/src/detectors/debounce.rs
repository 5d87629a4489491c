//! Short gaps in a detection are filled, then short detections dropped.

use std::collections::VecDeque;

/// Believes no gap between detections and no detection that is too short.
///
/// Outside the data nothing is detected, so a gap at their start or end stays one.
#[derive(Clone, Debug)]
pub(crate) struct Debounce {
    gaps: LongRuns,
    detections: LongRuns,
}

impl Debounce {
    /// Gaps of up to `longest_gap` samples are filled; what is shorter than `shortest_detection`
    /// samples then is dropped.
    pub(crate) fn new(longest_gap: usize, shortest_detection: usize) -> Self {
        Self {
            gaps: LongRuns::new(false, longest_gap + 1),
            detections: LongRuns::new(true, shortest_detection.max(1)),
        }
    }

    /// Number of samples by which an answer comes late.
    pub(crate) fn latency(&self) -> usize {
        self.gaps.latency() + self.detections.latency()
    }

    /// Takes the next sample's detection; answers for the sample `latency` before it, once there is
    /// such a one.
    pub(crate) fn push(&mut self, detected: bool) -> Option<bool> {
        self.gaps.push(detected).and_then(|filled| self.detections.push(filled))
    }

    pub(crate) fn reset(&mut self) {
        self.gaps.reset();
        self.detections.reset();
    }
}

/// Turns every run of `value` over that is shorter than `shortest`.
#[derive(Clone, Debug)]
struct LongRuns {
    value: bool,
    shortest: usize,
    /// Length of the run of `value` that the newest sample ends.
    run: usize,
    /// Answers that a run which grows long enough would still change.
    waiting: VecDeque<bool>,
}

impl LongRuns {
    fn new(value: bool, shortest: usize) -> Self {
        let mut runs = Self { value, shortest, run: 0, waiting: VecDeque::with_capacity(shortest) };
        runs.reset();
        runs
    }

    fn latency(&self) -> usize {
        self.shortest - 1
    }

    fn push(&mut self, input: bool) -> Option<bool> {
        let long_before = self.run >= self.shortest;
        self.run = if input == self.value { self.run.saturating_add(1) } else { 0 };
        let long = self.run >= self.shortest;
        if long && !long_before {
            self.waiting.iter_mut().for_each(|answer| *answer = self.value);
        }
        self.waiting.push_back(if long { self.value } else { !self.value });
        if self.waiting.len() > self.latency() { self.waiting.pop_front() } else { None }
    }

    fn reset(&mut self) {
        self.waiting.clear();
        self.run = if self.value { 0 } else { self.shortest };
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// The same by the definition: runs are found and turned over in the whole data.
    fn turned(
        mut values: Vec<bool>,
        value: bool,
        turn: impl Fn(usize, usize) -> bool,
    ) -> Vec<bool> {
        let mut start = 0;
        while start < values.len() {
            let length = values[start..].iter().take_while(|&&v| v == values[start]).count();
            if values[start] == value && turn(start, length) {
                values[start..start + length].fill(!value);
            }
            start += length;
        }
        values
    }

    proptest! {
        #[test]
        fn it_is_what_the_definition_says(values in prop::collection::vec(any::<bool>(), 0..80), gap in 0usize..6, shortest in 0usize..7) {
            let end = values.len();
            let inside = |start: usize, length: usize| start > 0 && start + length < end;
            let filled = turned(values.clone(), false, |start, length| inside(start, length) && length <= gap);
            let expected = turned(filled, true, |_, length| length < shortest);
            let mut debounce = Debounce::new(gap, shortest);
            let latency = debounce.latency();
            let padded = values.iter().copied().chain(std::iter::repeat_n(false, latency));
            let answers: Vec<bool> = padded.filter_map(|value| debounce.push(value)).collect();
            prop_assert_eq!(answers, expected);
        }
    }
}
