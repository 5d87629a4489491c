//! Aids: sources of measurements that correct the inertial navigation.

pub(crate) mod accelerometer_attitude;
pub(crate) mod aid;
pub mod aids;
pub(crate) mod gravity_tilt;
pub(crate) mod iaa;
pub(crate) mod lever_arm;
pub(crate) mod magnetic_heading;
pub(crate) mod magnetometer_settings;
pub(crate) mod zero_angular_rate;
pub(crate) mod zero_velocity;
pub(crate) mod zupt_correlation;
