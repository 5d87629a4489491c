//! Scale errors, which the filter considers and does not estimate.
//!
//! Zero-velocity updates hardly observe them.  An accelerometer that reads s too much makes every
//! stride s too long, so the position error is s times the distance from the start; a gyroscope that
//! reads s too much rotates the track s times too far.  Neither averages out as noise does, so they
//! are consider states (Maybeck, Stochastic Models, Estimation, and Control, vol. 1, 1979, sec. 6.8):
//! the sensitivity of the position to each is propagated, and inflates the standard deviations of the
//! output.

use nalgebra::Vector3;

use crate::types::nav_state::NavState;
use crate::types::sensor::SensorConfig;
use crate::types::solution::Solution;

/// Scale errors and misalignments of both sensors, and the sensitivity of the position to them.
#[derive(Clone, Debug)]
pub(crate) struct ConsideredScale {
    gyro_variance: f64,
    accel_variance: f64,
    /// Rotation about the vertical since the start, rad.
    heading_change: f64,
    /// Derivative of the position by the scale of the gyroscope, m.
    position_sensitivity: Vector3<f64>,
    previous: Option<NavState>,
}

impl ConsideredScale {
    /// Those of a sensor; none if it is calibrated.
    pub(crate) fn new(sensor: &SensorConfig) -> Option<Self> {
        let gyro_variance = sensor.gyro_scale_std.powi(2);
        let accel_variance = sensor.accel_scale_std.powi(2);
        let any = gyro_variance > 0.0 || accel_variance > 0.0;
        any.then_some(Self {
            gyro_variance,
            accel_variance,
            heading_change: 0.0,
            position_sensitivity: Vector3::zeros(),
            previous: None,
        })
    }

    /// Inflates the position uncertainty of the next solution.
    pub(crate) fn inflate(&mut self, solution: &mut Solution) {
        let nav = solution.estimate.nav;
        if let Some(previous) = self.previous.replace(nav) {
            let rotation = nav.attitude * previous.attitude.inverse();
            self.heading_change += rotation.scaled_axis().z;
            let moved = nav.position - previous.position;
            self.position_sensitivity += self.heading_change * Vector3::z().cross(&moved);
        }
        let length = Vector3::repeat(self.accel_variance * nav.position.norm_squared());
        let sensitivity = &self.position_sensitivity;
        let rotation = self.gyro_variance * sensitivity.component_mul(sensitivity);
        let std = &mut solution.position_std;
        *std = (std.component_mul(std) + length + rotation).map(f64::sqrt);
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::math::rotation::about_up;
    use crate::types::health::Flags;
    use crate::types::solution::Estimate;

    const STD: f64 = 0.3;

    /// The standard deviations at the end of a way through points, each with the heading there.
    fn end(sensor: &SensorConfig, way: &[(f64, Vector3<f64>)]) -> Vector3<f64> {
        let mut scale = ConsideredScale::new(sensor).unwrap();
        let mut std = Vector3::zeros();
        for &(heading, position) in way {
            let attitude = about_up(heading);
            let nav = NavState { time: 0.0, position, velocity: Vector3::zeros(), attitude };
            let estimate =
                Estimate { nav, gyro_bias: Vector3::zeros(), accel_bias: Vector3::zeros() };
            let position_std = Vector3::repeat(STD);
            let mut solution =
                Solution { estimate, position_std, zero_velocity: false, flags: Flags::empty() };
            scale.inflate(&mut solution);
            std = solution.position_std;
        }
        std
    }

    #[test]
    fn a_gyroscope_of_the_wrong_scale_turns_the_way_too_far() {
        let sensor = SensorConfig { gyro_scale_std: 0.1, ..SensorConfig::default() };
        let corner = Vector3::new(5.0, 0.0, 0.0);
        let way = [
            (0.0, Vector3::zeros()),
            (0.0, corner),
            (FRAC_PI_2, corner),
            (FRAC_PI_2, Vector3::new(5.0, 3.0, 0.0)),
        ];
        let expected = Vector3::new(STD.hypot(0.1 * FRAC_PI_2 * 3.0), STD, STD);
        assert!((end(&sensor, &way) - expected).norm() < 1e-12);
    }

    #[test]
    fn an_accelerometer_of_the_wrong_scale_stretches_the_way_until_the_foot_is_back() {
        let sensor = SensorConfig { accel_scale_std: 0.02, ..SensorConfig::default() };
        let way =
            [(0.0, Vector3::zeros()), (0.0, Vector3::new(6.0, 8.0, 0.0)), (0.0, Vector3::zeros())];
        assert!((end(&sensor, &way[..2]) - Vector3::repeat(STD.hypot(0.2))).norm() < 1e-12);
        assert!((end(&sensor, &way) - Vector3::repeat(STD)).norm() < 1e-12);
    }

    #[test]
    fn a_calibrated_sensor_has_none() {
        assert!(ConsideredScale::new(&SensorConfig::default()).is_none());
    }
}
