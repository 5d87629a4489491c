//! The covariance after the alignment.

use nalgebra::{Matrix3, Vector3};

use crate::filter::covariance::Covariance;
use crate::filter::error_state::{Block, LinearMap};
use crate::filter::setup::FilterSetup;
use crate::ins::alignment::Aligned;
use crate::math::simd::Simd;

/// Standard deviation of the velocity after a start in motion, m/s.
pub(crate) const MOVING_VELOCITY_STD: f64 = 1.0;
/// Standard deviation of roll and pitch levelled in motion, rad.
pub(crate) const MOVING_TILT_STD: f64 = 0.2;
/// Variance of a state that is known by definition, such as the heading where it only defines n x:
/// small, but above rounding.
const DEFINED_VARIANCE: f64 = 1.0e-10;
/// Standard deviation of the position of a foot at rest at the start, m: it rocks a little about a
/// point that is not known.
pub(crate) const INITIAL_POSITION_STD: f64 = 2.0e-3;

/// Covariance after the alignment.  Roll and pitch are wrong by the tilt that the accelerometer bias
/// causes, and correlated with it.
pub(crate) fn initial_covariance(
    simd: impl Simd,
    setup: &FilterSetup<'_>,
    aligned: &Aligned,
) -> Covariance {
    let accel_bias = setup.sensor.accel_bias_std.powi(2);
    let settings = setup.alignment;
    let heading_std = settings.heading_std_deg.to_radians();
    let mut p = Covariance::zero();
    p.add_variance(Block::Position, INITIAL_POSITION_STD.powi(2));
    p.add_variance(Block::AccelBias, accel_bias);
    if !aligned.at_rest {
        p.add_variance(Block::Velocity, MOVING_VELOCITY_STD.powi(2));
        p.add_diagonal(Block::Attitude, &attitude_variances(MOVING_TILT_STD, heading_std));
        p.add_variance(Block::GyroBias, setup.sensor.gyro_bias_std.powi(2));
        return p;
    }
    let tilt =
        tilt_of_accel_bias(aligned.attitude.to_rotation_matrix().matrix(), setup.strapdown.gravity);
    p.add_transformed(simd, Block::Attitude, Block::AccelBias, &tilt);
    p.add_diagonal(Block::Attitude, &attitude_variances(settings.tilt_std, heading_std));
    p.add_variance(Block::Velocity, setup.filter.zero_velocity_std.powi(2));
    let averaged =
        settings.gyro_bias_std.powi(2) * settings.duration / aligned.rest.min(settings.duration);
    p.add_variance(
        Block::GyroBias,
        averaged + gyro_bias_gain(setup, aligned) * aligned.sway.powi(2),
    );
    p
}

/// Share of the mean angular rate at rest that is taken for the gyroscope bias: all of it without
/// sway, little when the sway exceeds the bias.
///
/// For a bias of variance σ² and a mean that the sway disturbs by s, the linear estimate of least
/// variance is σ²/(σ² + s²) of the mean.
pub(crate) fn gyro_bias_gain(setup: &FilterSetup<'_>, aligned: &Aligned) -> f64 {
    let bias = setup.sensor.gyro_bias_std.powi(2);
    bias / (bias + aligned.sway.powi(2))
}

/// Variances of the attitude error: roll and pitch, and a heading that may be known by definition.
pub(crate) fn attitude_variances(tilt_std: f64, heading_std: f64) -> Vector3<f64> {
    Vector3::new(tilt_std.powi(2), tilt_std.powi(2), heading_std.powi(2).max(DEFINED_VARIANCE))
}

/// The tilt J δb that an accelerometer bias causes in an attitude that was levelled with it.
///
/// From `C_true (f - δb) = g z` and `C_est f = g z`: g J = [[0, -1, 0], [1, 0, 0], [0, 0, 0]] C.
pub(crate) fn tilt_of_accel_bias(attitude: &Matrix3<f64>, gravity: f64) -> Matrix3<f64> {
    Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0) * attitude / gravity
}
