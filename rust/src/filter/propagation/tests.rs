use nalgebra::{Matrix3, UnitQuaternion};
use proptest::prelude::*;

use super::*;
use crate::filter::observation::Observation;
use crate::ins::strapdown::StrapdownStep;
use crate::math::simd::Baseline;

const DT: f64 = 0.005;

/// The transitions in their order.
#[derive(Default)]
struct Recorded(Vec<(Transition, Noise)>);

impl FilterRecorder for Recorded {
    fn transition(&mut self, _: impl Simd, transition: &Transition, noise: &Noise) {
        self.0.push((*transition, *noise));
    }
    fn inflate(&mut self, _: Block, _: f64) {}
    fn couple(&mut self, _: impl Simd, _: &Matrix3<f64>) {}
    fn observation(&mut self, _: impl Simd, _: &Observation) {}
    fn reset_block(&mut self, _: Block, _: &Vector3<f64>) {}
}

fn steps() -> impl Strategy<Value = Vec<(Transition, Noise)>> {
    let vectors = || [-1.0..1.0, -1.0..1.0, -1.0..1.0].prop_map(Vector3::from);
    let one = (vectors(), vectors(), 0.0..1.0).prop_map(|(force, turn, variance)| {
        let attitude = UnitQuaternion::from_scaled_axis(turn).to_rotation_matrix().into_inner();
        let step = StrapdownStep { dt: DT, velocity_increment_n: 30.0 * DT * force, attitude };
        let noise =
            Noise { velocity: 1e-4 * variance, attitude: 1e-8 * variance, ..Noise::default() };
        (Transition::new(&step, &Vector3::zeros()), noise)
    });
    prop::collection::vec(one, 1..9)
}

/// Typical of a foot in swing.
fn covariance() -> Covariance {
    let mut p = Covariance::zero();
    for (block, std) in Block::ALL.into_iter().zip([0.1, 0.02, 0.01, 0.002, 0.05]) {
        p.add_variance(block, f64::powi(std, 2));
    }
    p
}

/// Propagates a covariance over the steps, all of which may be batched.
fn propagate(
    steps: &[(Transition, Noise)],
    batch_size: usize,
    recorder: &mut Recorded,
) -> Propagation {
    let mut propagation = Propagation::new(covariance(), batch_size);
    for (transition, noise) in steps {
        propagation.step(Baseline, *transition, *noise, true, recorder);
    }
    propagation
}

proptest! {
    #[test]
    fn the_recorder_gets_the_transitions_of_the_covariance(steps in steps(), batch_size in 0_usize..6) {
        let mut recorded = Recorded::default();
        let mut propagation = propagate(&steps, batch_size, &mut recorded);
        prop_assert_eq!(recorded.0.len(), steps.len() / batch_size.max(1));
        let now = propagation.current(Baseline);
        prop_assert_eq!(&now, propagation.flushed(Baseline, &mut recorded));
        prop_assert_eq!(recorded.0.len(), steps.len().div_ceil(batch_size.max(1)));
        prop_assert_eq!(propagation.if_current(), Some(&now));
        let mut p = covariance();
        recorded.0.iter().for_each(|(transition, noise)| p.predict(Baseline, transition, noise));
        prop_assert!((p.dense() - now.dense()).norm() < 1e-14);
    }

    #[test]
    fn a_batch_differs_from_single_steps_in_the_second_order_of_its_time(steps in steps()) {
        let one_by_one = propagate(&steps, 1, &mut Recorded::default()).current(Baseline).dense();
        let batched = propagate(&steps, 9, &mut Recorded::default()).current(Baseline).dense();
        let std = one_by_one.diagonal().map(f64::sqrt);
        let relative = (batched - one_by_one).component_div(&(std * std.transpose()));
        prop_assert!(
            relative.amax() < 4.0 * steps.iter().map(|(step, _)| step.dt()).sum::<f64>().powi(2),
            "{}",
            relative.amax()
        );
    }

    #[test]
    fn position_variances_with_and_without_pending_steps_agree(steps in steps()) {
        let propagation = propagate(&steps, 10, &mut Recorded::default());
        let now = propagation.current(Baseline).diagonal(Block::Position);
        prop_assert!(propagation.if_current().is_none());
        prop_assert!((propagation.position_variances() - now).component_div(&now).amax() < 1e-5);
    }

    #[test]
    fn velocity_noise_is_integrated_to_position(steps in steps()) {
        let mut p = Covariance::zero();
        let (still, mut together) = (Noise::default(), Noise::default());
        let straight =
            StrapdownStep { dt: DT, velocity_increment_n: Vector3::zeros(), attitude: Matrix3::zeros() };
        for (_, noise) in &steps {
            p.predict(Baseline, &Transition::new(&straight, &Vector3::zeros()), noise);
            together = together.compose(noise, DT);
        }
        let mut batched = Covariance::zero();
        batched.predict(Baseline, &Transition::NONE, &together);
        prop_assert_eq!(still.compose(&together, DT), together);
        prop_assert!((p.dense() - batched.dense()).norm() < 1e-18);
    }
}

#[test]
fn a_step_outside_a_batch_flushes_the_batch() {
    let step =
        StrapdownStep { dt: DT, velocity_increment_n: Vector3::z(), attitude: Matrix3::identity() };
    let transition = Transition::new(&step, &Vector3::zeros());
    let mut recorded = Recorded::default();
    let mut propagation = propagate(&[(transition, Noise::default()); 2], 9, &mut recorded);
    propagation.step(Baseline, transition, Noise::default(), false, &mut recorded);
    assert!(propagation.if_current().is_some());
    assert_eq!(
        recorded.0,
        [(transition.compose(&transition).compose(&transition), Noise::default())]
    );
}
