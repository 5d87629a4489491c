//! Merging of samples at rest into stances.

use std::ops::RangeInclusive;

/// Minimum duration of a motion that separates two stances, µs.
const MIN_SWING: f64 = 100_000.0;

/// Changes of stance at a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StanceEvent {
    /// The previous stance is over.
    pub(crate) ends: bool,
    /// The sample is the first of a stance.
    pub(crate) begins: bool,
}

/// Merges samples at rest into stances across short interruptions of the detection.
#[derive(Clone, Debug, Default)]
pub(crate) struct StanceMerger {
    /// Stamp of the last sample at rest in the stance, s.
    last_at_rest: Option<f64>,
    rests: bool,
}

impl StanceMerger {
    /// Processes the next sample.
    pub(crate) fn push(&mut self, time: f64, rests: bool) -> StanceEvent {
        let moved = |since: f64| microseconds(time - since) >= MIN_SWING;
        let interrupted = !(rests && self.rests) && self.last_at_rest.is_some_and(moved);
        let begins = rests && (interrupted || self.last_at_rest.is_none());
        self.rests = rests;
        if rests {
            self.last_at_rest = Some(time);
        } else if interrupted {
            self.last_at_rest = None;
        }
        StanceEvent { ends: interrupted, begins }
    }
}

/// Rounds to microseconds, so that limits do not depend on the rounding of large stamps.
pub(crate) fn microseconds(seconds: f64) -> f64 {
    (seconds * 1e6).round_ties_even()
}

/// First and last row of each stance, from the stamp (s) and the detection of each row.
pub fn stances(rows: impl IntoIterator<Item = (f64, bool)>) -> Vec<RangeInclusive<usize>> {
    let mut merger = StanceMerger::default();
    let mut found: Vec<RangeInclusive<usize>> = Vec::new();
    for (row, (time, rests)) in rows.into_iter().enumerate() {
        let begins = merger.push(time, rests).begins;
        match found.last_mut() {
            Some(stance) if rests && !begins => *stance = *stance.start()..=row,
            _ if rests => found.push(row..=row),
            _ => {}
        }
    }
    found
}
