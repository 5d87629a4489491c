//! The path of a sample from the sensor to the track.

pub(crate) mod aided_ins;
pub(crate) mod batch;
pub(crate) mod considered_scale;
pub(crate) mod delay_line;
pub(crate) mod detection;
pub(crate) mod fine_levelling;
pub mod health_monitor;
pub(crate) mod navigator;
pub(crate) mod run;
pub(crate) mod stages;
pub(crate) mod start_up;
pub(crate) mod validation;
