//! Correlation of the zero-velocity updates of one stance.
//!
//! A foot in stance rolls and sinks in one direction, so the errors of its zero-velocity updates do
//! not average out: the foot leaves the stance with the common error of its velocity, and keeps it
//! until the next one.  The position gains the variance of that error times the square of the time
//! since the stance, as process noise.

/// The zero-velocity updates of the newest stance.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ZuptCorrelation {
    /// Number of updates in the stance, and the sum of their inverse variances.
    updates: f64,
    information: f64,
    /// Time since the last of them, s.
    time_since_zupt: f64,
    /// Variance that the position has yet to gain, m².
    pending_position_variance: f64,
}

impl ZuptCorrelation {
    /// Counts an update of this `variance` (m²/s²).
    pub(crate) fn record(&mut self, variance: f64) {
        if self.time_since_zupt > 0.0 {
            let pending_position_variance = self.pending_position_variance;
            *self = Self { pending_position_variance, ..Self::default() };
        }
        self.updates += 1.0;
        self.information += variance.recip();
    }

    /// Propagates over an interval of `dt` (s) without an update; `correlation` is the common part of
    /// the standard deviation.
    pub(crate) fn propagate(&mut self, dt: f64, correlation: f64) {
        if self.updates == 0.0 {
            return;
        }
        let before = self.time_since_zupt;
        self.time_since_zupt += dt;
        self.pending_position_variance += correlation.powi(2) * self.updates / self.information
            * (self.time_since_zupt.powi(2) - before.powi(2));
    }

    /// The variance that the position has yet to gain, m²; it counts as gained.
    pub(crate) fn take_position_variance(&mut self) -> f64 {
        std::mem::take(&mut self.pending_position_variance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn position_variance_follows_the_common_error_of_the_last_stance() {
        let mut correlation = ZuptCorrelation::default();
        correlation.propagate(0.1, 0.5);
        assert!(correlation.take_position_variance() < f64::MIN_POSITIVE);
        correlation.record(1.0);
        correlation.propagate(0.3, 0.0);
        for variance in [0.04, 0.01] {
            correlation.record(variance);
        }
        let gained: f64 = [0.1, 0.2, 0.5]
            .iter()
            .map(|&dt| {
                correlation.propagate(dt, 0.5);
                correlation.take_position_variance()
            })
            .sum();
        let common = 0.25 * 2.0 / (1.0 / 0.04 + 1.0 / 0.01);
        assert!((gained - common * 0.8_f64.powi(2)).abs() < 1e-15, "{gained}");
    }
}
