//! Health of the solution: the quality flags at each sample, and counters of events and updates.

use crate::aiding::UpdateCounters;
use crate::aiding::aid::Outcome;
use crate::types::health::Flags;
use crate::types::health_settings::HealthConfig;

/// Events and updates since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Samples that passed the input validation.
    pub samples: u64,
    /// Samples with the stamp of the one before.
    pub repeated: u64,
    /// Intervals in which samples are missing.
    pub gaps: u64,
    /// Samples with a channel at its full scale.
    pub clipped: u64,
    /// Samples refused as not finite or out of order.
    pub refused: u64,
    /// Updates of the filter by each aid.
    pub updates: UpdateCounters,
}

/// Quality of the newest solution, and the counters.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Health {
    /// Quality flags.
    pub flags: Flags,
    /// Events and updates since the start.
    pub counters: Counters,
    /// One-sigma horizontal position uncertainty, m (root of the sum of both variances).
    pub horizontal_std: f64,
    /// One-sigma vertical position uncertainty, m.
    pub vertical_std: f64,
}

/// Flags that are held for a while after their event.
const HELD: [Flags; 3] = [Flags::GAP, Flags::CLIPPED, Flags::REFUSED];

/// Derives the flags at each sample from events and updates.
#[derive(Clone, Debug)]
pub(crate) struct HealthMonitor {
    config: HealthConfig,
    /// Time of the last event of each held flag, s.
    last_event: [(Flags, f64); 3],
    last_of_all: f64,
    last_zero_velocity: f64,
    /// Flags that stay until an update clears them, or for good.
    latched: Flags,
}

impl HealthMonitor {
    pub(crate) fn new(config: HealthConfig) -> Self {
        Self {
            config,
            last_event: HELD.map(|flag| (flag, f64::NEG_INFINITY)),
            last_of_all: f64::NEG_INFINITY,
            last_zero_velocity: f64::NEG_INFINITY,
            latched: Flags::empty(),
        }
    }

    /// The alignment ended, at rest or in motion.
    pub(crate) fn aligned(&mut self, time: f64, at_rest: bool) {
        self.last_zero_velocity = time;
        self.latched.set(Flags::MOVING_START, !at_rest);
    }

    /// Takes the outcome of the zero-velocity update at one sample.
    #[inline]
    pub(crate) fn record_zero_velocity(&mut self, time: f64, outcome: Outcome) {
        match outcome {
            Outcome::None => {}
            Outcome::Accepted => {
                self.latched.remove(Flags::UPDATES_REJECTED);
                self.last_zero_velocity = time;
            }
            Outcome::Rejected => self.latched.insert(Flags::UPDATES_REJECTED),
        }
    }

    /// Records the flags of a sample.
    #[inline]
    pub(crate) fn record(&mut self, time: f64, events: Flags) {
        if events.is_empty() {
            return;
        }
        self.last_of_all = time;
        for (flag, last) in &mut self.last_event {
            if events.contains(*flag) {
                *last = time;
            }
        }
    }

    /// Longest gap that is interpolated, s.
    pub(crate) fn longest_gap(&self) -> f64 {
        self.config.longest_gap
    }

    /// The position is lost until the next start.
    pub(crate) fn mark_lost(&mut self) {
        self.latched.insert(Flags::LOST);
    }

    /// The flags of recent events.
    #[inline]
    fn held(&self, time: f64) -> Flags {
        let mut flags = Flags::empty();
        if time - self.last_of_all <= self.config.memory {
            for (flag, last) in self.last_event {
                flags.set(flag, time - last <= self.config.memory);
            }
        }
        flags
    }

    /// Flags at `time`, given the `events` of the sample and the tilt uncertainty (rad) of the
    /// filter, which is evaluated only after a moving start.
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
        let time_since_zupt = time - self.last_zero_velocity;
        let timeout = if time_since_zupt > self.config.degraded_after {
            self.on_zupt_timeout(time_since_zupt)
        } else {
            Flags::empty()
        };
        self.latched | timeout | self.held(time)
    }

    /// After a long time without an accepted zero-velocity update.
    #[cold]
    fn on_zupt_timeout(&mut self, time_since_zupt: f64) -> Flags {
        if time_since_zupt > self.config.invalid_after {
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
        monitor.record_zero_velocity(15.2, Outcome::Accepted);
        assert_eq!(monitor.assess(15.2, Flags::empty(), || 0.0), Flags::LOST);
    }

    #[test]
    fn a_gap_is_held_for_a_second() {
        let mut monitor = monitor();
        assert_eq!(monitor.assess(1.0, Flags::GAP, || 0.0), Flags::GAP);
        assert_eq!(monitor.assess(1.9, Flags::empty(), || 0.0), Flags::GAP);
        assert_eq!(monitor.assess(2.1, Flags::empty(), || 0.0), Flags::empty());
    }

    #[test]
    fn a_moving_start_ends_with_small_tilt_uncertainty() {
        let mut monitor = HealthMonitor::new(HealthConfig::default());
        monitor.aligned(0.0, false);
        assert_eq!(monitor.assess(0.1, Flags::empty(), || 0.2), Flags::MOVING_START);
        assert_eq!(monitor.assess(0.2, Flags::empty(), || 0.01), Flags::empty());
        assert_eq!(monitor.assess(0.3, Flags::empty(), || 0.2), Flags::empty());
    }
}
