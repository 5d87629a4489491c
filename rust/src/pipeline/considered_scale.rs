//! Scale errors that the filter does not estimate: how far they may have led it astray.
//!
//! Zero velocities hardly show them.  An accelerometer that reads s too much makes every stride s
//! too long, so that a foot which has got a distance away is s times that from where the filter
//! believes it to be; a gyroscope that reads s too much turns the walk s times too far.  Neither
//! averages out like noise, so they are considered rather than filtered (Maybeck, Stochastic
//! Models, Estimation, and Control, vol. 1, 1979, sec. 6.8): what the position owes to each is
//! carried along and widens the standard deviations that come out.

use nalgebra::Vector3;

use crate::config::SensorConfig;
use crate::types::nav_state::NavState;
use crate::types::solution::Solution;

/// Scale errors and misalignments of both sensors, and what they have done since the start.
#[derive(Clone, Debug)]
pub(crate) struct ScaleErrors {
    gyro_variance: f64,
    accel_variance: f64,
    /// Turn about the vertical, rad.
    turned: f64,
    /// Derivative of the position by the gyroscope's scale: what the way turns with the heading, m.
    swept: Vector3<f64>,
    previous: Option<NavState>,
}

impl ScaleErrors {
    /// Those of a sensor; none if it is calibrated.
    pub(crate) fn new(sensor: &SensorConfig) -> Option<Self> {
        let (gyro_variance, accel_variance) =
            (sensor.gyro_scale_std.powi(2), sensor.accel_scale_std.powi(2));
        let any = gyro_variance > 0.0 || accel_variance > 0.0;
        any.then_some(Self {
            gyro_variance,
            accel_variance,
            turned: 0.0,
            swept: Vector3::zeros(),
            previous: None,
        })
    }

    /// Widens the uncertainty of the next solution.
    pub(crate) fn widen(&mut self, solution: &mut Solution) {
        let nav = solution.estimate.nav;
        if let Some(previous) = self.previous.replace(nav) {
            self.turned += (nav.attitude * previous.attitude.inverse()).scaled_axis().z;
            self.swept += self.turned * Vector3::z().cross(&(nav.position - previous.position));
        }
        let stretched = Vector3::repeat(self.accel_variance * nav.position.norm_squared());
        let turned = self.gyro_variance * self.swept.component_mul(&self.swept);
        let std = &mut solution.position_std;
        *std = (std.component_mul(std) + stretched + turned).map(f64::sqrt);
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
        let mut scale = ScaleErrors::new(sensor).unwrap();
        let mut std = Vector3::zeros();
        for &(heading, position) in way {
            let attitude = about_up(heading);
            let nav = NavState { time: 0.0, position, velocity: Vector3::zeros(), attitude };
            let estimate =
                Estimate { nav, gyro_bias: Vector3::zeros(), accel_bias: Vector3::zeros() };
            let position_std = Vector3::repeat(STD);
            let mut solution =
                Solution { estimate, position_std, zero_velocity: false, flags: Flags::empty() };
            scale.widen(&mut solution);
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
        assert!(ScaleErrors::new(&SensorConfig::default()).is_none());
    }
}
