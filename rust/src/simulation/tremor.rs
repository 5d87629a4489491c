//! Residual motion of the foot: postural sway and tremor.

use std::f64::consts::TAU;

use rand::RngExt;
use rand_chacha::ChaCha8Rng;

use crate::simulation::dual::Dual;

/// Frequency bands, Hz: postural sway, muscle tremor, physiological tremor.
const BANDS: [(f64, f64); 3] = [(0.4, 1.5), (2.0, 5.0), (8.0, 12.0)];

/// Amplitude of a band per root mean square of the total: sqrt(2 / number of bands).
const BAND_SHARE: f64 = 0.816_496_580_927_726;

/// A tremor angle: a sum of one sine wave per band.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tremor {
    waves: [Wave; BANDS.len()],
}

#[derive(Clone, Copy, Debug)]
struct Wave {
    amplitude: f64,
    frequency: f64,
    phase: f64,
}

impl Tremor {
    /// A tremor whose rate has the root mean square `rate` (rad/s), in equal parts over the bands.
    pub(super) fn draw(rate: f64, random: &mut ChaCha8Rng) -> Self {
        let share = BAND_SHARE * rate;
        let waves = BANDS.map(|(low, high)| {
            let frequency = TAU * random.random_range(low..high);
            Wave { amplitude: share / frequency, frequency, phase: random.random_range(0.0..TAU) }
        });
        Self { waves }
    }

    /// The angle at `time` (s), rad.
    pub(super) fn at(&self, time: f64) -> Dual {
        self.waves.iter().fold(Dual::ZERO, |sum, wave| {
            let angle = Dual { value: wave.frequency * time + wave.phase, rate: wave.frequency };
            sum + angle.sin() * wave.amplitude
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulation::draw;

    #[test]
    fn tremor_rate_has_the_configured_rms() {
        let tremor = Tremor::draw(0.02, &mut draw::stream(5, draw::Stream::Gait));
        let count = 20_000;
        let power: f64 = (0..count).map(|k| tremor.at(0.01 * f64::from(k)).rate.powi(2)).sum();
        assert!(((power / f64::from(count)).sqrt() - 0.02).abs() < 2e-4);
    }
}
