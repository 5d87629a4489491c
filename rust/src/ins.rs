//! Inertial navigation without aids: alignment, strapdown mechanization and the Earth.

pub mod alignment;
pub mod earth;
pub(crate) mod interval;
mod inverse;
pub mod mechanization;
pub mod strapdown;
