//! Mean and variance of specific force and angular rate over a number of samples.

use nalgebra::Vector3;

use crate::types::sample::ImuSample;

/// Sums of samples and of their squares.
///
/// The mean and the standard deviation of no sample at all are NaN and zero.
#[derive(Clone, Copy, Debug, Default)]
pub struct SampleStatistics {
    count: f64,
    force: Vector3<f64>,
    force_squares: Vector3<f64>,
    rate: Vector3<f64>,
    rate_squares: Vector3<f64>,
}

impl SampleStatistics {
    /// Statistics of some samples.
    #[must_use]
    pub fn of(samples: &[ImuSample]) -> Self {
        let mut statistics = Self::default();
        for sample in samples {
            statistics.add(&sample.specific_force, &sample.angular_rate);
        }
        statistics
    }

    /// Adds a sample, or the mean of a block.
    pub fn add(&mut self, specific_force: &Vector3<f64>, angular_rate: &Vector3<f64>) {
        self.count += 1.0;
        self.force += specific_force;
        self.force_squares += specific_force.component_mul(specific_force);
        self.rate += angular_rate;
        self.rate_squares += angular_rate.component_mul(angular_rate);
    }

    /// Adds all samples of `other`.
    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.force += other.force;
        self.force_squares += other.force_squares;
        self.rate += other.rate;
        self.rate_squares += other.rate_squares;
    }

    /// Number of samples.
    #[must_use]
    pub fn count(&self) -> f64 {
        self.count
    }

    /// Mean specific force, m/s².
    #[must_use]
    pub fn specific_force(&self) -> Vector3<f64> {
        self.force / self.count
    }

    /// Mean angular rate, rad/s.
    #[must_use]
    pub fn angular_rate(&self) -> Vector3<f64> {
        self.rate / self.count
    }

    /// Standard deviation of each axis of the specific force, m/s².
    #[must_use]
    pub fn accel_std(&self) -> Vector3<f64> {
        std(&self.force, &self.force_squares, self.count)
    }

    /// Standard deviation of each axis of the angular rate, rad/s.
    #[must_use]
    pub fn gyro_std(&self) -> Vector3<f64> {
        std(&self.rate, &self.rate_squares, self.count)
    }
}

fn std(sum: &Vector3<f64>, squares: &Vector3<f64>, count: f64) -> Vector3<f64> {
    let mean = sum / count;
    (squares / count - mean.component_mul(&mean)).map(|variance| variance.max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn samples() -> impl Strategy<Value = Vec<ImuSample>> {
        let triad = || prop::array::uniform3(-10.0..10.0);
        prop::collection::vec((triad(), triad()), 1..30).prop_map(|rows| {
            rows.into_iter().map(|(force, rate)| ImuSample::new(0.0, force, rate)).collect()
        })
    }

    proptest! {
        #[test]
        fn merged_statistics_are_those_of_all_samples(first in samples(), second in samples()) {
            let mut merged = SampleStatistics::of(&first);
            merged.merge(&SampleStatistics::of(&second));
            let all = [first, second].concat();
            let whole = SampleStatistics::of(&all);
            let mean = all.iter().map(|s| s.angular_rate).sum::<Vector3<f64>>() / whole.count();
            let squares = all.iter().map(|s| (s.angular_rate - mean).map(|x| x * x));
            let variance = squares.sum::<Vector3<f64>>() / whole.count();
            prop_assert!((merged.angular_rate() - mean).norm() < 1e-12);
            prop_assert!((merged.gyro_std() - variance.map(f64::sqrt)).norm() < 1e-6);
            prop_assert!((merged.accel_std() - whole.accel_std()).norm() < 1e-6);
        }
    }

    #[test]
    fn a_constant_has_no_standard_deviation() {
        let still = vec![ImuSample::new(0.0, [0.1, 0.2, 9.8], [0.01; 3]); 7];
        let statistics = SampleStatistics::of(&still);
        assert!(statistics.accel_std().norm() < 1e-6 && statistics.gyro_std().norm() < 1e-9);
        assert!((statistics.specific_force().z - 9.8).abs() < 1e-12);
    }
}
