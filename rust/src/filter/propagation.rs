//! When the covariance is carried over the steps of the mechanization.
//!
//! While the foot swings nothing is observed, so nobody needs the covariance after each step: a few
//! steps wait for each other, and it is carried over all of them at once.  What it is then differs
//! in the second order of the time that they take together, see [`Transition::then`].

use nalgebra::Vector3;

use crate::filter::covariance::Covariance;
use crate::filter::error_state::Block;
use crate::filter::recorder::FilterRecorder;
use crate::filter::transition::{Noise, Transition};
use crate::math::simd::Lanes;

/// The covariance, and the steps that wait until it is carried over them.
#[derive(Clone, Debug)]
pub(crate) struct Propagation {
    covariance: Covariance,
    /// Number of steps that the covariance is carried over at once, at most.
    batch_size: usize,
    waiting: usize,
    /// The steps that wait, as one.
    transition: Transition,
    noise: Noise,
}

impl Propagation {
    pub(crate) fn new(covariance: Covariance, batch_size: usize) -> Self {
        Self {
            covariance,
            batch_size,
            waiting: 0,
            transition: Transition::NONE,
            noise: Noise::default(),
        }
    }

    /// Carries the covariance over one more step, which may have to wait for others if it
    /// `may_wait`.
    #[inline(always)]
    pub(crate) fn step<L: Lanes>(
        &mut self,
        mut transition: Transition,
        mut noise: Noise,
        may_wait: bool,
        recorder: &mut impl FilterRecorder,
    ) {
        if self.waiting > 0 {
            noise = self.noise.then(&noise, transition.dt());
            transition = self.transition.then(&transition);
        }
        if may_wait && self.waiting + 1 < self.batch_size {
            self.waiting += 1;
            (self.transition, self.noise) = (transition, noise);
            return;
        }
        self.waiting = 0;
        recorder.transition(&transition, &noise);
        self.covariance.predict_on::<L>(&transition, &noise);
    }

    /// The covariance, carried over all steps.
    #[inline(always)]
    pub(crate) fn flushed(&mut self, recorder: &mut impl FilterRecorder) -> &mut Covariance {
        if self.waiting > 0 {
            self.catch_up(recorder);
        }
        &mut self.covariance
    }

    #[cold]
    fn catch_up(&mut self, recorder: &mut impl FilterRecorder) {
        self.waiting = 0;
        recorder.transition(&self.transition, &self.noise);
        self.covariance.predict(&self.transition, &self.noise);
    }

    /// What the covariance is after all steps.
    pub(crate) fn now(&self) -> Covariance {
        self.clone().flushed(&mut ()).clone()
    }

    /// The covariance, unless steps wait.
    pub(crate) fn if_current(&self) -> Option<&Covariance> {
        (self.waiting == 0).then_some(&self.covariance)
    }

    /// The covariance before the steps that wait.
    #[inline(always)]
    pub(crate) fn last_propagated(&self) -> &Covariance {
        &self.covariance
    }

    /// Variances of the position, m²: at the end of steps that wait those of a foot that went on at
    /// the velocity of their beginning.
    #[inline]
    pub(crate) fn position_variances(&self) -> Vector3<f64> {
        let before = self.covariance.diagonal(Block::Position);
        if self.waiting == 0 {
            return before;
        }
        let dt = self.transition.dt();
        let together = self.covariance.diagonal_between(Block::Position, Block::Velocity);
        let gain = 2.0 * together + dt * self.covariance.diagonal(Block::Velocity);
        before + dt * gain + Vector3::repeat(self.noise.position)
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, UnitQuaternion};
    use proptest::prelude::*;

    use super::*;
    use crate::ins::strapdown::Step;
    use crate::math::simd::Baseline;

    const DT: f64 = 0.005;

    /// What a recorder is told of.
    #[derive(Default)]
    struct Told(Vec<(Transition, Noise)>);

    impl FilterRecorder for Told {
        fn transition(&mut self, transition: &Transition, noise: &Noise) {
            self.0.push((*transition, *noise));
        }
        fn inflate(&mut self, _: Block, _: f64) {}
        fn couple(&mut self, _: &Matrix3<f64>) {}
        fn observation(&mut self, _: &crate::filter::observation::Observation) {}
        fn reset_block(&mut self, _: Block, _: &Vector3<f64>) {}
    }

    fn steps() -> impl Strategy<Value = Vec<(Transition, Noise)>> {
        let vectors = || [-1.0..1.0, -1.0..1.0, -1.0..1.0].prop_map(Vector3::from);
        let one = (vectors(), vectors(), 0.0..1.0).prop_map(|(force, turn, variance)| {
            let attitude = UnitQuaternion::from_scaled_axis(turn).to_rotation_matrix().into_inner();
            let step = Step { dt: DT, velocity_increment_n: 30.0 * DT * force, attitude };
            let noise =
                Noise { velocity: 1e-4 * variance, attitude: 1e-8 * variance, ..Noise::default() };
            (Transition::new(&step, &Vector3::zeros()), noise)
        });
        prop::collection::vec(one, 1..9)
    }

    /// As uncertain as a foot in the swing.
    fn covariance() -> Covariance {
        let mut p = Covariance::zero();
        for (block, std) in Block::ALL.into_iter().zip([0.1, 0.02, 0.01, 0.002, 0.05]) {
            p.add_variance(block, f64::powi(std, 2));
        }
        p
    }

    /// Carries a covariance over the steps, all of which may wait.
    fn carry(steps: &[(Transition, Noise)], batch_size: usize, recorder: &mut Told) -> Propagation {
        let mut propagation = Propagation::new(covariance(), batch_size);
        for (transition, noise) in steps {
            propagation.step::<Baseline>(*transition, *noise, true, recorder);
        }
        propagation
    }

    proptest! {
        #[test]
        fn the_journal_is_told_what_the_covariance_went_through(steps in steps(), batch_size in 0_usize..6) {
            let mut told = Told::default();
            let mut propagation = carry(&steps, batch_size, &mut told);
            prop_assert_eq!(told.0.len(), steps.len() / batch_size.max(1));
            let now = propagation.now();
            prop_assert_eq!(&now, propagation.flushed(&mut told));
            prop_assert_eq!(told.0.len(), steps.len().div_ceil(batch_size.max(1)));
            prop_assert_eq!(propagation.if_current(), Some(&now));
            let mut p = covariance();
            told.0.iter().for_each(|(transition, noise)| p.predict(transition, noise));
            prop_assert!((p.dense() - now.dense()).norm() < 1e-14);
        }

        #[test]
        fn steps_at_once_are_those_one_after_the_other_but_for_the_square_of_their_time(steps in steps()) {
            let one_by_one = carry(&steps, 1, &mut Told::default()).now().dense();
            let batch_size = carry(&steps, 9, &mut Told::default()).now().dense();
            let std = one_by_one.diagonal().map(f64::sqrt);
            let relative = (batch_size - one_by_one).component_div(&(std * std.transpose()));
            prop_assert!(relative.amax() < 4.0 * steps.iter().map(|(step, _)| step.dt()).sum::<f64>().powi(2), "{}", relative.amax());
        }

        #[test]
        fn the_position_is_as_uncertain_while_steps_wait_as_after_them(steps in steps()) {
            let propagation = carry(&steps, 10, &mut Told::default());
            let now = propagation.now().diagonal(Block::Position);
            prop_assert!(propagation.if_current().is_none());
            prop_assert!((propagation.position_variances() - now).component_div(&now).amax() < 1e-5);
        }

        #[test]
        fn velocity_noise_leads_the_position_on(steps in steps()) {
            let mut p = Covariance::zero();
            let (still, mut together) = (Noise::default(), Noise::default());
            let straight = Step { dt: DT, velocity_increment_n: Vector3::zeros(), attitude: Matrix3::zeros() };
            for (_, noise) in &steps {
                p.predict(&Transition::new(&straight, &Vector3::zeros()), noise);
                together = together.then(noise, DT);
            }
            let mut batch_size = Covariance::zero();
            batch_size.predict(&Transition::NONE, &together);
            prop_assert_eq!(still.then(&together, DT), together);
            prop_assert!((p.dense() - batch_size.dense()).norm() < 1e-18);
        }
    }

    #[test]
    fn a_step_that_must_not_wait_takes_those_along_that_do() {
        let step =
            Step { dt: DT, velocity_increment_n: Vector3::z(), attitude: Matrix3::identity() };
        let transition = Transition::new(&step, &Vector3::zeros());
        let mut told = Told::default();
        let mut propagation = carry(&[(transition, Noise::default()); 2], 9, &mut told);
        propagation.step::<Baseline>(transition, Noise::default(), false, &mut told);
        assert!(propagation.if_current().is_some());
        assert_eq!(told.0, [(transition.then(&transition).then(&transition), Noise::default())]);
    }
}
