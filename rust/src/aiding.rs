//! What corrects the inertial navigation.

pub(crate) mod accelerometer_attitude;
pub(crate) mod lever_arm;
pub(crate) mod magnetic_heading;
pub(crate) mod magnetometer_settings;
pub(crate) mod zupt_correlation;
