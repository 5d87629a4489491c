//! What the filter did to the errors, step by step, for a smoother that goes back over it.

use nalgebra::Matrix3;

use super::observation::Observation;
use super::transition::Transition;

/// Takes down the filter's steps in their order.  What is merely added to the covariance is not among them: the way back does not need it.
pub(crate) trait Journal {
    /// The errors moved on.
    fn transition(&mut self, transition: &Transition);

    /// The attitude errors gained `m` times the accelerometer bias errors.
    fn tie(&mut self, m: &Matrix3<f64>);

    /// An observation was used.
    fn observation(&mut self, observation: &Observation);

    /// What was known was forgotten: nothing that comes later tells of what was before.
    fn forget(&mut self);
}

/// No smoother, no journal.
impl Journal for () {
    #[inline]
    fn transition(&mut self, _: &Transition) {}

    #[inline]
    fn tie(&mut self, _: &Matrix3<f64>) {}

    #[inline]
    fn observation(&mut self, _: &Observation) {}

    #[inline]
    fn forget(&mut self) {}
}
