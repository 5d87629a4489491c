#![doc = include_str!("../../README.md")]
#![cfg_attr(not(test), warn(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod alignment;
pub mod allan;
pub mod batch;
pub mod calibration;
pub mod config;
mod correction;
pub mod detector;
pub mod earth;
pub mod error;
#[expect(clippy::inline_always, reason = "as the lanes")]
pub mod filter;
pub mod gait;
pub mod health;
mod intake;
#[expect(clippy::inline_always, reason = "what is compiled for some instructions must not call what is not")]
mod lanes;
mod limits;
#[expect(clippy::inline_always, reason = "as the lanes")]
pub mod navigator;
#[cfg(feature = "python")]
mod python;
pub mod rotation;
pub mod sample;
pub mod simulation;
mod smoother;
#[expect(clippy::inline_always, reason = "as the lanes")]
pub mod strapdown;
pub mod trajectory;
mod watch;

pub use batch::Batch;
pub use config::Config;
pub use error::{ConfigError, DataError, Error, NumericalError};
pub use gait::Stride;
pub use navigator::{Navigator, Solution};
pub use sample::{ImuSample, MagSample};
pub use trajectory::{Trajectory, track};
