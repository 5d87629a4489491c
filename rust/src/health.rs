//! Whether the solution can be trusted, and why not.

use bitflags::bitflags;

use crate::config::HealthConfig;

bitflags! {
    /// Reasons not to trust a solution fully.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
    pub struct Reasons: u16 {
        /// The start is still being aligned.
        const ALIGNING = 1;
        /// The recording started in motion and the tilt is not settled yet.
        const MOVING_START = 2;
        /// No zero velocity for too long.
        const NO_ZERO_VELOCITY = 4;
        /// The latest zero velocities contradicted the prediction.
        const UPDATES_REJECTED = 8;
        /// Samples are missing.
        const GAP = 16;
        /// A channel was at its full scale.
        const CLIPPED = 32;
        /// A sample was refused because it was not finite or older than the one before.
        const REFUSED = 64;
        /// No zero velocity, or no sample, for so long that the position means nothing until the next start; or the filter cannot go on.
        const LOST = 128;
    }
}

/// Trust in a solution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Status {
    /// Nothing speaks against it.
    Ok,
    /// Something does; see the [`Reasons`].
    Degraded,
    /// It is not aligned, or was without a zero velocity for so long that it means nothing.
    #[default]
    Invalid,
}

impl Reasons {
    /// The status that these reasons amount to.
    #[must_use]
    pub fn status(self) -> Status {
        if self.intersects(Self::ALIGNING | Self::LOST) {
            Status::Invalid
        } else if self.is_empty() {
            Status::Ok
        } else {
            Status::Degraded
        }
    }
}

/// What was counted since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Samples taken in.
    pub samples: u64,
    /// Samples with the stamp of the one before.
    pub repeated: u64,
    /// Intervals in which samples are missing.
    pub gaps: u64,
    /// Samples with a channel at its full scale.
    pub clipped: u64,
    /// Samples refused as not finite or out of order.
    pub refused: u64,
    /// What the filter was told.
    pub updates: UpdateCounters,
}

/// Observations since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct UpdateCounters {
    /// Zero velocities used.
    pub zero_velocity: u64,
    /// Zero velocities rejected by the innovation test.
    pub zero_velocity_rejected: u64,
    /// Zero angular rates used.
    pub zero_angular_rate: u64,
    /// Stances whose magnetic field corrected the heading.
    pub magnetic: u64,
    /// Stances whose magnetic field disagreed with that at the start.
    pub magnetic_rejected: u64,
}

/// What speaks against the newest solution, and what was counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Health {
    /// What speaks against it.
    pub reasons: Reasons,
    /// What was counted since the start.
    pub counters: Counters,
    /// One-sigma horizontal position uncertainty, m (root of the sum of both variances).
    pub horizontal_std: f64,
    /// One-sigma vertical position uncertainty, m.
    pub vertical_std: f64,
}

/// Turns events into [`Reasons`] that last as long as they matter.
#[derive(Clone, Debug)]
pub(crate) struct HealthMonitor {
    config: HealthConfig,
    last_event: [(Reasons, f64); 3],
    last_of_all: f64,
    last_zero_velocity: f64,
    /// What holds until something ends it: a moving start, rejected updates, being lost.
    standing: Reasons,
    pub(crate) updates: UpdateCounters,
}

const MEMORIZED: [Reasons; 3] = [Reasons::GAP, Reasons::CLIPPED, Reasons::REFUSED];

impl HealthMonitor {
    pub(crate) fn new(config: HealthConfig) -> Self {
        Self {
            config,
            last_event: MEMORIZED.map(|reason| (reason, f64::NEG_INFINITY)),
            last_of_all: f64::NEG_INFINITY,
            last_zero_velocity: f64::NEG_INFINITY,
            standing: Reasons::empty(),
            updates: UpdateCounters::default(),
        }
    }

    pub(crate) fn aligned(&mut self, time: f64, at_rest: bool) {
        self.last_zero_velocity = time;
        self.standing.set(Reasons::MOVING_START, !at_rest);
    }

    pub(crate) fn zero_velocity(&mut self, time: f64, accepted: bool) {
        self.standing.set(Reasons::UPDATES_REJECTED, !accepted);
        self.updates.zero_velocity += u64::from(accepted);
        self.updates.zero_velocity_rejected += u64::from(!accepted);
        if accepted {
            self.last_zero_velocity = time;
        }
    }

    pub(crate) fn zero_angular_rate(&mut self, accepted: bool) {
        self.updates.zero_angular_rate += u64::from(accepted);
    }

    pub(crate) fn magnetic(&mut self, accepted: bool) {
        self.updates.magnetic += u64::from(accepted);
        self.updates.magnetic_rejected += u64::from(!accepted);
    }

    /// Remembers what is held against a sample.
    #[inline]
    pub(crate) fn note(&mut self, time: f64, events: Reasons) {
        if events.is_empty() {
            return;
        }
        self.last_of_all = time;
        for (reason, last) in &mut self.last_event {
            if events.contains(*reason) {
                *last = time;
            }
        }
    }

    /// Longest gap that is bridged, s.
    pub(crate) fn longest_gap(&self) -> f64 {
        self.config.longest_gap
    }

    /// The foot was not seen for too long.
    pub(crate) fn lose(&mut self) {
        self.standing.insert(Reasons::LOST);
    }

    /// The events of the last while.
    #[inline]
    fn remembered(&self, time: f64) -> Reasons {
        let mut reasons = Reasons::empty();
        if time - self.last_of_all <= self.config.memory {
            for (reason, last) in self.last_event {
                reasons.set(reason, time - last <= self.config.memory);
            }
        }
        reasons
    }

    /// Reasons that hold at `time`, given the `events` of the sample and the tilt uncertainty (rad) of the filter, which is asked for only after a moving start.
    #[inline]
    pub(crate) fn assess(&mut self, time: f64, events: Reasons, tilt_std: impl FnOnce() -> f64) -> Reasons {
        self.note(time, events);
        if self.standing.contains(Reasons::MOVING_START) {
            self.standing.set(Reasons::MOVING_START, tilt_std() > self.config.tilt_limit);
        }
        let unaided = time - self.last_zero_velocity;
        let missing = if unaided > self.config.degraded_after { self.miss(unaided) } else { Reasons::empty() };
        self.standing | missing | self.remembered(time)
    }

    /// What a long time without a zero velocity means.
    #[cold]
    fn miss(&mut self, unaided: f64) -> Reasons {
        if unaided > self.config.invalid_after {
            self.lose();
        }
        Reasons::NO_ZERO_VELOCITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn monitor() -> HealthMonitor {
        let mut monitor = HealthMonitor::new(HealthConfig::default());
        monitor.aligned(0.0, true);
        monitor
    }

    #[test]
    fn time_without_zero_velocity_degrades_and_then_invalidates() {
        let mut monitor = monitor();
        assert_eq!(monitor.assess(2.9, Reasons::empty(), || 0.0).status(), Status::Ok);
        assert_eq!(monitor.assess(3.1, Reasons::empty(), || 0.0), Reasons::NO_ZERO_VELOCITY);
        assert_eq!(monitor.assess(15.1, Reasons::empty(), || 0.0).status(), Status::Invalid);
        monitor.zero_velocity(15.2, true);
        assert_eq!(monitor.assess(15.2, Reasons::empty(), || 0.0), Reasons::LOST);
    }

    #[test]
    fn a_gap_is_remembered_for_a_second() {
        let mut monitor = monitor();
        assert_eq!(monitor.assess(1.0, Reasons::GAP, || 0.0), Reasons::GAP);
        assert_eq!(monitor.assess(1.9, Reasons::empty(), || 0.0), Reasons::GAP);
        assert_eq!(monitor.assess(2.1, Reasons::empty(), || 0.0), Reasons::empty());
    }

    #[test]
    fn a_moving_start_is_over_once_the_tilt_has_settled() {
        let mut monitor = HealthMonitor::new(HealthConfig::default());
        monitor.aligned(0.0, false);
        assert_eq!(monitor.assess(0.1, Reasons::empty(), || 0.2), Reasons::MOVING_START);
        assert_eq!(monitor.assess(0.2, Reasons::empty(), || 0.01), Reasons::empty());
        assert_eq!(monitor.assess(0.3, Reasons::empty(), || 0.2), Reasons::empty());
    }
}
