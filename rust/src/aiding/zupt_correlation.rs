//! What the zero velocities of a stance have in common, and how far it leads.
//!
//! A foot in stance rolls and sinks in one direction, so the errors of its zero velocities do not
//! average out: it leaves the stance with the velocity that they were wrong by, and keeps it until
//! the next one.  The track is the same; the position is less certain, by that velocity times the
//! time that the foot was away.

/// The zero velocities of the newest stance.
#[derive(Clone, Copy, Default)]
pub(crate) struct Footing {
    /// Number of the stance's zero velocities, and the sum of their inverse variances.
    updates: f64,
    information: f64,
    /// Time since the last of them, s.
    gone_for: f64,
    /// Variance that the position has still to gain, m².
    strayed: f64,
}

impl Footing {
    /// A zero velocity was used.
    pub(crate) fn stand(&mut self, variance: f64) {
        if self.gone_for > 0.0 {
            *self = Self { strayed: self.strayed, ..Self::default() };
        }
        self.updates += 1.0;
        self.information += variance.recip();
    }

    /// The foot goes on for `dt` (s) without one; `shared` is the part of the standard deviation
    /// that all of the stance have in common.
    pub(crate) fn go_on(&mut self, dt: f64, shared: f64) {
        if self.updates == 0.0 {
            return;
        }
        let before = self.gone_for;
        self.gone_for += dt;
        self.strayed += shared.powi(2) * self.updates / self.information
            * (self.gone_for.powi(2) - before.powi(2));
    }

    /// The variance that the position gains with the next prediction, m².
    pub(crate) fn take_strayed(&mut self) -> f64 {
        std::mem::take(&mut self.strayed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_foot_takes_along_what_its_last_stance_was_wrong_by() {
        let mut footing = Footing::default();
        footing.go_on(0.1, 0.5);
        assert!(footing.take_strayed() < f64::MIN_POSITIVE);
        footing.stand(1.0);
        footing.go_on(0.3, 0.0);
        for variance in [0.04, 0.01] {
            footing.stand(variance);
        }
        let strayed: f64 = [0.1, 0.2, 0.5]
            .iter()
            .map(|&dt| {
                footing.go_on(dt, 0.5);
                footing.take_strayed()
            })
            .sum();
        let shared = 0.25 * 2.0 / (1.0 / 0.04 + 1.0 / 0.01);
        assert!((strayed - shared * 0.8_f64.powi(2)).abs() < 1e-15, "{strayed}");
    }
}
