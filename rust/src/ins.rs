//! Inertial navigation without aids: alignment, strapdown mechanization and the Earth.

pub mod alignment;
pub mod earth;
pub(crate) mod integration;
pub(crate) mod interval;
mod inverse;
pub mod mechanization;
pub mod rest;
pub mod sample_statistics;
pub mod strapdown;
