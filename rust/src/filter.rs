//! Error-state Kalman filter with full feedback.
//!
//! The errors are truth minus estimate, in n for position, velocity and attitude: `C_true = (I +
//! [φ×]) C_est`.  With this sign
//!
//! ```text
//! δp' = δv
//! δv' = -[C f ×] φ - C δb_a - 2 ω_ie × δv
//! φ'  = -ω_ie × φ - C δb_g
//! ```
//!
//! and every estimated error is added to the estimate and forgotten.  The covariance is propagated
//! and reduced as 3x3 blocks, and in swing in batches of a few intervals.
//!
//! # References
//! - Wu, Lu, Chen, "Research on Foot-Mounted Personal Navigation Algorithm based on MEMS Inertial
//!   Sensors": eq. 3 (error model), eq. 6 (zero-velocity update).
//! - P. D. Groves, "Principles of GNSS, Inertial, and Multisensor Integrated Navigation Systems",
//!   2nd ed., 2013: ch. 14 (error-state integration).

#[doc(hidden)]
pub mod bench;
pub(crate) mod cloning;
pub(crate) mod covariance;
pub(crate) mod error_state;
pub(crate) mod error_state_filter;
pub(crate) mod initial_covariance;
pub(crate) mod kernels;
pub(crate) mod observation;
pub(crate) mod process_noise;
pub(crate) mod propagation;
pub(crate) mod recorder;
pub(crate) mod settings;
pub(crate) mod setup;
pub(crate) mod transition;

pub use covariance::Covariance;
pub use error_state::{Block, STATES};
