//! Strides of the foot that carries the sensor: from stance to stance, with the covariance of the
//! way between.
//!
//! A stance is entered at its *arrival* and left at its *departure*, each a sample at which the
//! foot turns least: the ends of a detected stance reach into heel strike and push-off.  A stride
//! goes from the departure of one stance to the arrival in the next, `Δ = p_e - p_s` in n, and is
//! known as soon as the stance that it ends in is over, or has lasted for half a second.
//!
//! In the frame of the stride, n turned about the up axis by the heading ψ of its start, with R =
//! `R_z(-ψ)` and J the turn by a quarter, the errors (truth minus estimate) of the displacement `R
//! Δ` and of the change of heading are
//!
//! ```text
//! e = G_e [δp_e, φ_e] - G_s [δp_s, φ_s]        G_e = [R 0]    G_s = [R  R J Δ]
//!                                                    [0 1]          [0    1  ]
//! ```
//!
//! where φ is the attitude error about the up axis.  With the covariances `P_s` and `P_e` of these
//! errors at both ends and their cross-covariance `X = E[e_e e_sᵀ]`, which the filter carries along
//! from the start (see `filter::cloned`), the covariance of the stride is
//!
//! ```text
//! G_e P_e G_eᵀ + G_s P_s G_sᵀ - G_e X G_sᵀ - G_s Xᵀ G_eᵀ
//! ```
//!
//! What it rests on (28 recordings under motion capture, from walking and running to shuffling and
//! crawling, with the SHOE statistic at three thresholds within a decade):
//!
//! - A swing takes about 0.4 s in walking.  Of the motions shorter than 0.1 s between two rests, at
//!   most one in a hundred carried the foot 0.05 m: they are doubts of the detector within one
//!   stance.
//! - A stance may be as short as one sample: of a running foot's, the default detector believes no
//!   more.
//! - Of a long rest only the half second next to the stride is looked at, so that standing still
//!   makes no slow stride.
//! - A stride that ends within 0.05 m of where it began, both horizontally and in height, is a
//!   shuffle on the spot and is not counted.
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
