//! Strides of the instrumented foot: displacement and heading change from stance to stance, with
//! their covariance.
//!
//! The *arrival* and the *departure* of a stance are samples of minimum angular rate, because the
//! ends of a detected stance extend into heel strike and push-off.  A stride is the
//! displacement `Δ = p_e - p_s` in n from the departure of one stance to the arrival of the next.
//! It is available when the stance in which it ends is over or has lasted half a second.
//!
//! The stride frame is n rotated about the up axis by the heading ψ at its start.  With R =
//! `R_z(-ψ)` and J the rotation by 90 degrees, the errors (truth minus estimate) of the
//! displacement `R Δ` and of the heading change are
//!
//! ```text
//! e = G_e [δp_e, φ_e] - G_s [δp_s, φ_s]        G_e = [R 0]    G_s = [R  R J Δ]
//!                                                    [0 1]          [0    1  ]
//! ```
//!
//! where φ is the attitude error about the up axis.  With the covariances `P_s` and `P_e` of the
//! errors at both ends and their cross-covariance `X = E[e_e e_sᵀ]`, which stochastic cloning
//! propagates from the start (see `filter::cloning`), the covariance of the stride is
//!
//! ```text
//! G_e P_e G_eᵀ + G_s P_s G_sᵀ - G_e X G_sᵀ - G_s Xᵀ G_eᵀ
//! ```
//!
//! Rules, from 28 recordings with motion capture (walking, running, shuffling, crawling; SHOE
//! statistic at three thresholds within a decade):
//!
//! - Motion of less than 0.1 s between two rests does not separate stances.  A walking swing takes
//!   about 0.4 s; at most one in a hundred of the shorter motions displaced the foot by 0.05 m, so
//!   they are missed detections within one stance.
//! - A stance may be a single sample: in running the default detector may find no more.
//! - In a long rest only the half second next to the stride is used, so that standing still does
//!   not produce a slow stride.
//! - A stride that ends within 0.05 m of its start, both horizontally and in height, is a shuffle
//!   in place and is not counted.
//!
//! # References
//! - J.-O. Nilsson, A. K. Gupta, P. Händel, "Foot-mounted inertial navigation made easy", IPIN
//!   2014: sec. III, step-wise dead reckoning from displacement, heading change and their
//!   covariance.
//! - S. I. Roumeliotis, J. W. Burdick, "Stochastic Cloning: A Generalized Framework for Processing
//!   Relative State Measurements", ICRA 2002.

pub(crate) mod correction;
pub(crate) mod segmenter;
pub(crate) mod stance;
pub(crate) mod stride;
pub(crate) mod stride_tracker;
pub(crate) mod strides;

pub use stance::stances;
pub use stride::Stride;
pub use strides::strides;
