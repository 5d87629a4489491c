//! What is done to a covariance on the best lanes of the processor.

use nalgebra::{Matrix3, Vector3};

use super::Covariance;
use crate::filter::observation::{Observation, Update};
use crate::filter::states::Block;
use crate::filter::transition::{Noise, Transition};
use crate::lanes::{Lanes, Work};

/// See [`Covariance::predict`].
pub(super) struct Predict<'a> {
    pub(super) p: &'a mut Covariance,
    pub(super) transition: &'a Transition,
    pub(super) noise: &'a Noise,
}

impl Work for Predict<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.p.predict_on::<L>(self.transition, self.noise);
    }
}

/// See [`Covariance::predict_on`], where the Earth turns: the noise is added after it turned.
///
/// It owns what it needs, so that what is handed to the more frequent case may stay in registers.
pub(super) struct PredictOnEarth<'a> {
    pub(super) p: &'a mut Covariance,
    pub(super) transition: Transition,
    pub(super) noise: Noise,
}

impl Work for PredictOnEarth<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let Self { p, transition, noise } = self;
        p.shear_all::<L>(&transition, &Noise::default());
        transition.turn_with_earth(p);
        p.add_noise(&noise);
    }
}

/// See [`Covariance::observe_white`].
pub(super) struct Observe<'a> {
    pub(super) p: &'a mut Covariance,
    pub(super) block: Block,
    pub(super) whitener: Option<Matrix3<f64>>,
    pub(super) innovation: &'a Vector3<f64>,
    pub(super) gate: f64,
}

impl Work for Observe<'_> {
    type Output = (Update, Option<Observation>);

    #[inline(always)]
    fn run<L: Lanes>(self) -> Self::Output {
        let Self { p, block, whitener, innovation, gate } = self;
        let mut used = None;
        let update = p.observe_white::<L>(block, whitener, innovation, gate, &mut used);
        (update, used)
    }
}

/// See [`Covariance::observe_again`].
pub(super) struct ObserveAgain<'a> {
    pub(super) p: &'a mut Covariance,
    pub(super) observation: &'a mut Observation,
}

impl Work for ObserveAgain<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.p.reduce::<L>(self.observation);
    }
}
