//! Fixed-interval smoothing: each state of a walk estimated from what came later, too.
//!
//! The forward pass keeps, for each sample, its estimate and the steps that led there, and the
//! covariance of one sample in 64.  The backward pass finds the covariances and gains of such a
//! window again, by the same steps from the one that was kept, and carries the costate λ and the
//! information Λ of everything that came later back over them,
//!
//! ```text
//! over a transition     λ <- Fᵀ λ                        Λ <- Fᵀ Λ F
//! over an observation   λ <- (I - K H)ᵀ λ - Hᵀ S⁻¹ y     Λ <- (I - K H)ᵀ Λ (I - K H) + Hᵀ S⁻¹ H
//! ```
//!
//! and at each sample the smoothed errors are -P λ and their covariance P - P Λ P.  For a linear
//! model this is the solution of Rauch, Tung and Striebel, in the form of Bryson and Frazier, which
//! needs no inverse of a covariance: a covariance of states that are known by definition, as the
//! origin is, has none that is worth computing.
//!
//! A sample that waits takes 168 bytes for its solution, 184 for its transition, 184 for each
//! observation, and 30 for its share of a covariance and the count of its steps: 382 bytes in the
//! swing, 566 in the stance.
//!
//! # References
//! - H. E. Rauch, F. Tung, C. T. Striebel, "Maximum Likelihood Estimates of LinearMap Dynamic
//!   Systems", AIAA J. 3(8), 1965.
//! - G. J. Bierman, "Fixed Interval Smoothing with Discrete Measurements", Int. J. Control 18(1),
//!   1973: the modified Bryson-Frazier form.
//! - D. S. Colomar, J.-O. Nilsson, P. Händel, "Smoothing for ZUPT-aided INSs", IPIN 2012: smoothing
//!   step by step.

pub(crate) mod backward_state;
pub(crate) mod fixed_interval;
pub(crate) mod fixed_lag;
pub(crate) mod segment;
pub(crate) mod settings;
pub(crate) mod smoother;
