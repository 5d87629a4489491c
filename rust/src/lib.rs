#![doc = include_str!("../../README.md")]
#![cfg_attr(not(test), warn(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

#[expect(clippy::inline_always, reason = "as math::simd")]
pub mod aiding;
pub mod allan;
pub mod calibration;
pub mod config;
pub mod detectors;
pub mod error;
#[expect(clippy::inline_always, reason = "as math::simd")]
pub mod filter;
pub mod gait;
#[expect(clippy::inline_always, reason = "as math::simd")]
pub mod ins;
pub mod limits;
#[expect(
    clippy::inline_always,
    reason = "code compiled for an instruction set must not call code that is not"
)]
pub mod math;
#[expect(clippy::inline_always, reason = "as math::simd")]
pub mod pipeline;
mod progress;
#[cfg(feature = "python")]
mod python;
pub mod settings;
pub mod simulation;
#[expect(clippy::inline_always, reason = "as math::simd")]
mod smoother;
pub mod types;

pub use aiding::Reading;
pub use config::Config;
pub use error::{ConfigError, DataError, Error, NumericalError};
pub use gait::Stride;
pub use pipeline::batch::{Batch, track};
pub use pipeline::detection::{decide_all, decide_all_with};
pub use pipeline::health_monitor::Health;
pub use pipeline::navigator::Navigator;
pub use types::sample::{ImuSample, MagSample};
pub use types::solution::Solution;
pub use types::trajectory::Trajectory;
