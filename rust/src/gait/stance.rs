//! Samples at rest, joined into stances.

use std::ops::RangeInclusive;

/// Motion from which on two rests are two stances, µs.
const SHORTEST_SWING: f64 = 100_000.0;

/// What a sample means for the stances.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct StanceEvent {
    /// The stance before is over.
    pub(crate) ends: bool,
    /// The sample is the first of a stance.
    pub(crate) begins: bool,
}

/// Joins the samples at rest over the doubts of the detector.
#[derive(Clone, Debug, Default)]
pub(crate) struct StanceMerger {
    /// Stamp of the newest sample at rest of the stance, s.
    rested: Option<f64>,
    rests: bool,
}

impl StanceMerger {
    /// Takes the next sample.
    pub(crate) fn push(&mut self, time: f64, rests: bool) -> StanceEvent {
        let moved = |since: f64| microseconds(time - since) >= SHORTEST_SWING;
        let interrupted = !(rests && self.rests) && self.rested.is_some_and(moved);
        let begins = rests && (interrupted || self.rested.is_none());
        self.rests = rests;
        if rests {
            self.rested = Some(time);
        } else if interrupted {
            self.rested = None;
        }
        StanceEvent { ends: interrupted, begins }
    }
}

/// A limit must not depend on the rounding of large stamps.
pub(crate) fn microseconds(seconds: f64) -> f64 {
    (seconds * 1e6).round_ties_even()
}

/// First and last row of each stance, given the stamps (s) and where the foot rests.
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
