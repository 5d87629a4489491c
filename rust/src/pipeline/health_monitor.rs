//! Health of the solution over time: which quality flags hold at a sample.

use crate::config::HealthConfig;
use crate::types::health::{Flags, UpdateCounters};

/// Turns events into [`Flags`] that last as long as they matter.
#[derive(Clone, Debug)]
pub(crate) struct HealthMonitor {
    config: HealthConfig,
    last_event: [(Flags, f64); 3],
    last_of_all: f64,
    last_zero_velocity: f64,
    /// What holds until something ends it: a moving start, rejected updates, being lost.
    latched: Flags,
    pub(crate) updates: UpdateCounters,
}

const MEMORIZED: [Flags; 3] = [Flags::GAP, Flags::CLIPPED, Flags::REFUSED];

impl HealthMonitor {
    pub(crate) fn new(config: HealthConfig) -> Self {
        Self {
            config,
            last_event: MEMORIZED.map(|reason| (reason, f64::NEG_INFINITY)),
            last_of_all: f64::NEG_INFINITY,
            last_zero_velocity: f64::NEG_INFINITY,
            latched: Flags::empty(),
            updates: UpdateCounters::default(),
        }
    }

    pub(crate) fn aligned(&mut self, time: f64, at_rest: bool) {
        self.last_zero_velocity = time;
        self.latched.set(Flags::MOVING_START, !at_rest);
    }

    pub(crate) fn zero_velocity(&mut self, time: f64, accepted: bool) {
        self.latched.set(Flags::UPDATES_REJECTED, !accepted);
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
    pub(crate) fn record(&mut self, time: f64, events: Flags) {
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
    pub(crate) fn mark_lost(&mut self) {
        self.latched.insert(Flags::LOST);
    }

    /// The events of the last while.
    #[inline]
    fn remembered(&self, time: f64) -> Flags {
        let mut flags = Flags::empty();
        if time - self.last_of_all <= self.config.memory {
            for (reason, last) in self.last_event {
                flags.set(reason, time - last <= self.config.memory);
            }
        }
        flags
    }

    /// Flags that hold at `time`, given the `events` of the sample and the tilt uncertainty (rad)
    /// of the filter, which is asked for only after a moving start.
    #[inline]
    pub(crate) fn assess(
        &mut self,
        time: f64,
        events: Flags,
        tilt_std: impl FnOnce() -> f64,
    ) -> Flags {
        self.record(time, events);
        if self.latched.contains(Flags::MOVING_START) {
            self.latched.set(Flags::MOVING_START, tilt_std() > self.config.tilt_limit);
        }
        let unaided = time - self.last_zero_velocity;
        let missing = if unaided > self.config.degraded_after {
            self.on_zupt_timeout(unaided)
        } else {
            Flags::empty()
        };
        self.latched | missing | self.remembered(time)
    }

    /// What a long time without a zero velocity means.
    #[cold]
    fn on_zupt_timeout(&mut self, unaided: f64) -> Flags {
        if unaided > self.config.invalid_after {
            self.mark_lost();
        }
        Flags::NO_ZERO_VELOCITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::types::health::Status;

    fn monitor() -> HealthMonitor {
        let mut monitor = HealthMonitor::new(HealthConfig::default());
        monitor.aligned(0.0, true);
        monitor
    }

    #[test]
    fn time_without_zero_velocity_degrades_and_then_invalidates() {
        let mut monitor = monitor();
        assert_eq!(monitor.assess(2.9, Flags::empty(), || 0.0).status(), Status::Ok);
        assert_eq!(monitor.assess(3.1, Flags::empty(), || 0.0), Flags::NO_ZERO_VELOCITY);
        assert_eq!(monitor.assess(15.1, Flags::empty(), || 0.0).status(), Status::Invalid);
        monitor.zero_velocity(15.2, true);
        assert_eq!(monitor.assess(15.2, Flags::empty(), || 0.0), Flags::LOST);
    }

    #[test]
    fn a_gap_is_remembered_for_a_second() {
        let mut monitor = monitor();
        assert_eq!(monitor.assess(1.0, Flags::GAP, || 0.0), Flags::GAP);
        assert_eq!(monitor.assess(1.9, Flags::empty(), || 0.0), Flags::GAP);
        assert_eq!(monitor.assess(2.1, Flags::empty(), || 0.0), Flags::empty());
    }

    #[test]
    fn a_moving_start_is_over_once_the_tilt_has_settled() {
        let mut monitor = HealthMonitor::new(HealthConfig::default());
        monitor.aligned(0.0, false);
        assert_eq!(monitor.assess(0.1, Flags::empty(), || 0.2), Flags::MOVING_START);
        assert_eq!(monitor.assess(0.2, Flags::empty(), || 0.01), Flags::empty());
        assert_eq!(monitor.assess(0.3, Flags::empty(), || 0.2), Flags::empty());
    }
}
