//! Stance detection: zero-velocity detectors.
//!
//! A detector tests a window centred on the sample, so its decision has a latency of `latency`
//! samples.  A sample whose window is not full is never stationary.
//!
//! # References
//! I. Skog, P. Händel, J.-O. Nilsson, J. Rantakokko, "Zero-velocity detection - an algorithm
//! evaluation", IEEE Trans. Biomed. Eng. 57(11), 2010.

pub(crate) mod acceleration_magnitude;
pub(crate) mod adaptive_shoe;
pub(crate) mod angular_rate_energy;
pub(crate) mod debounce;
pub(crate) mod delay;
pub(crate) mod detector;
pub(crate) mod graph_theoretic;
pub(crate) mod latency_counter;
pub(crate) mod magnitude_debounced;
pub(crate) mod magnitude_variance;
pub(crate) mod moving_variance;
pub(crate) mod registry;
pub(crate) mod scripted;
pub(crate) mod shoe;
pub(crate) mod sliding_min_max;
pub(crate) mod sliding_window;
pub(crate) mod three_condition;
pub(crate) mod windowed_detector;
pub(crate) mod windowed_energies;

pub use adaptive_shoe::AdaptiveShoe;
pub use detector::{Decision, Detector};
pub use scripted::Scripted;
pub use shoe::Shoe;
