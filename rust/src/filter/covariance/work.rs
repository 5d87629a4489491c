//! What is done to a covariance on the best lanes of the processor.

use nalgebra::{Matrix3, Vector3};

use crate::filter::covariance::Covariance;
use crate::filter::error_state::Block;
use crate::filter::observation::{Observation, Update};
use crate::filter::transition::{Noise, Transition};
use crate::math::simd::{Lanes, Work};

/// See [`Covariance::predict`].
pub(crate) struct Predict<'a> {
    pub(crate) p: &'a mut Covariance,
    pub(crate) transition: &'a Transition,
    pub(crate) noise: &'a Noise,
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
pub(crate) struct PredictOnEarth<'a> {
    pub(crate) p: &'a mut Covariance,
    pub(crate) transition: Transition,
    pub(crate) noise: Noise,
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
pub(crate) struct Observe<'a> {
    pub(crate) p: &'a mut Covariance,
    pub(crate) block: Block,
    pub(crate) whitener: Option<Matrix3<f64>>,
    pub(crate) innovation: &'a Vector3<f64>,
    pub(crate) gate: f64,
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

/// See [`Covariance::replay`].
pub(crate) struct ObserveAgain<'a> {
    pub(crate) p: &'a mut Covariance,
    pub(crate) observation: &'a mut Observation,
}

impl Work for ObserveAgain<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        self.p.reduce::<L>(self.observation);
    }
}
