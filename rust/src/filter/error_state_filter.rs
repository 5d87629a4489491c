//! The error-state filter: an estimate, and the covariance of its errors.

use nalgebra::{Matrix3, Vector3};

use crate::error::NumericalError;
use crate::filter::covariance::Covariance;
use crate::filter::error_state::{Block, ErrorStates, LinearMap};
use crate::filter::initial_covariance::{
    INITIAL_POSITION_STD, MOVING_TILT_STD, MOVING_VELOCITY_STD, attitude_variances, gyro_bias_gain,
    initial_covariance,
};
use crate::filter::observation::{Observation, Update};
use crate::filter::process_noise::ProcessNoise;
use crate::filter::propagation::Propagation;
use crate::filter::recorder::FilterRecorder;
use crate::filter::setup::FilterSetup;
use crate::filter::transition::Transition;
use crate::ins::alignment::Aligned;
use crate::ins::interval::Interval;
use crate::math::rotation_kernels;
use crate::math::simd::{Simd, WithSimd};
use crate::types::nav_state::NavState;
use crate::types::rate::samples;
use crate::types::solution::Estimate;

/// Speed of a person during a gap, m/s.
const WALKING_SPEED: f64 = 1.5;
/// Standard deviation of the heading after a long gap, rad.
const HEADING_STD_AFTER_GAP: f64 = 1.0;

impl Estimate {
    /// Adds estimated errors: full feedback.
    #[inline(always)]
    pub(crate) fn correct(&mut self, simd: impl Simd, errors: &ErrorStates) {
        let ErrorStates([position, velocity, attitude, gyro_bias, accel_bias]) = errors;
        self.nav.position += position;
        self.nav.velocity += velocity;
        self.nav.attitude = rotation_kernels::rotate_in_nav(simd, &self.nav.attitude, attitude);
        self.gyro_bias += gyro_bias;
        self.accel_bias += accel_bias;
    }
}

/// The filter, compiled for an instruction set.
#[derive(Clone, Debug)]
pub(crate) struct ErrorStateFilter<S> {
    /// The estimate.
    pub(crate) estimate: Estimate,
    propagation: Propagation,
    noise: ProcessNoise,
    earth_rate: Vector3<f64>,
    pub(crate) simd: S,
}

impl<S: Simd> ErrorStateFilter<S> {
    /// A filter that starts from an alignment at `time` (s).
    #[must_use]
    pub(crate) fn new(simd: S, setup: &FilterSetup<'_>, aligned: &Aligned, time: f64) -> Self {
        let estimate = Estimate {
            nav: NavState::at_rest(time, aligned.attitude),
            gyro_bias: gyro_bias_gain(setup, aligned) * aligned.gyro_bias,
            accel_bias: Vector3::zeros(),
        };
        let covariance = initial_covariance(simd, setup, aligned);
        Self {
            estimate,
            propagation: Propagation::new(covariance, batch_size(setup)),
            noise: ProcessNoise::new(setup.sensor, setup.filter, setup.strapdown.gravity),
            earth_rate: setup.strapdown.earth_rate,
            simd,
        }
    }

    /// Propagates the covariance over an interval of the mechanization, in which a channel may be
    /// `clipped`; `position_noise` is an additional variance of the position, m².
    ///
    /// An interval that ends without a measurement `may_batch`; the noise of a clipped one is too
    /// large for that.
    #[inline(always)]
    pub(crate) fn predict(
        &mut self,
        interval: &Interval,
        clipped: bool,
        position_noise: f64,
        may_batch: bool,
        recorder: &mut impl FilterRecorder,
    ) {
        let transition = Transition::new(&interval.step, &self.earth_rate);
        let noise = self.noise.over(interval.step.dt, clipped, position_noise);
        self.propagation.step(self.simd, transition, noise, may_batch && !clipped, recorder);
        if interval.gap_duration > 0.0 {
            self.inflate_for_gap(interval.gap_duration, recorder);
        }
    }

    /// Adds the errors of the interpolation over a gap (s).
    fn inflate_for_gap(&mut self, gap: f64, recorder: &mut impl FilterRecorder) {
        let noise = self.noise.over_gap(gap);
        self.inflate(Block::Attitude, noise.attitude, recorder);
        self.inflate(Block::Velocity, noise.velocity, recorder);
        self.inflate(Block::Position, noise.position, recorder);
    }

    /// Adds independent errors of this `variance` to each state of a block.
    pub(crate) fn inflate(
        &mut self,
        block: Block,
        variance: f64,
        recorder: &mut impl FilterRecorder,
    ) {
        self.propagation.flushed(self.simd, recorder).add_variance(block, variance);
        recorder.inflate(block, variance);
    }

    /// Makes the states of a block independent of all others, with these `variances`.
    fn reset_block(
        &mut self,
        block: Block,
        variances: &Vector3<f64>,
        recorder: &mut impl FilterRecorder,
    ) {
        self.propagation.flushed(self.simd, recorder).reset_block(block, variances);
        recorder.reset_block(block, variances);
    }

    /// Restarts after a gap too long to be interpolated: the foot is where it was, or as far away as
    /// a person walks in `elapsed` (s), and may move.
    pub(crate) fn restart(&mut self, time: f64, elapsed: f64, recorder: &mut impl FilterRecorder) {
        self.estimate.nav.time = time;
        self.estimate.nav.velocity = Vector3::zeros();
        let walked = Vector3::repeat((WALKING_SPEED * elapsed).powi(2));
        let position = self.variances(Block::Position, recorder) + walked;
        let velocity = Vector3::repeat(MOVING_VELOCITY_STD.powi(2));
        let attitude = attitude_variances(MOVING_TILT_STD, HEADING_STD_AFTER_GAP);
        self.reset_block(Block::Position, &position, recorder);
        self.reset_block(Block::Velocity, &velocity, recorder);
        self.reset_block(Block::Attitude, &attitude, recorder);
        for bias in [Block::GyroBias, Block::AccelBias] {
            let variances = self.variances(bias, recorder);
            self.reset_block(bias, &variances, recorder);
        }
    }

    fn variances(&mut self, block: Block, recorder: &mut impl FilterRecorder) -> Vector3<f64> {
        self.propagation.flushed(self.simd, recorder).diagonal(block)
    }

    /// Sets the velocity to zero, with a `variance` on each axis and no correlation to other states.
    pub(crate) fn reset_velocity(&mut self, variance: f64, recorder: &mut impl FilterRecorder) {
        self.estimate.nav.velocity = Vector3::zeros();
        self.reset_block(Block::Velocity, &Vector3::repeat(variance), recorder);
    }

    /// Makes the present position the origin.
    pub(crate) fn reset_position(&mut self) {
        self.estimate.nav.position = Vector3::zeros();
        let variances = Vector3::repeat(INITIAL_POSITION_STD.powi(2));
        self.reset_block(Block::Position, &variances, &mut ());
    }

    /// Adds `m` times the accelerometer bias errors to the attitude errors.
    pub(crate) fn couple(&mut self, m: &Matrix3<f64>, recorder: &mut impl FilterRecorder) {
        let covariance = self.propagation.flushed(self.simd, recorder);
        self.simd.vectorize(Couple { covariance, m });
        recorder.couple(self.simd, m);
    }

    /// Observes a block of error states: an `innovation` with the noise covariance `r`, in the unit
    /// of the block and its square.  It is used if its squared Mahalanobis distance is at most
    /// `gate`; the estimated errors are fed back.
    #[inline(always)]
    pub(crate) fn observe(
        &mut self,
        block: Block,
        innovation: &Vector3<f64>,
        r: &Matrix3<f64>,
        gate: f64,
        recorder: &mut impl FilterRecorder,
    ) -> Update {
        let mut used = None;
        let covariance = self.propagation.flushed(self.simd, recorder);
        let update = covariance.observe(self.simd, block, innovation, r, gate, &mut used);
        if let Some(observation) = &used {
            recorder.observation(self.simd, observation);
            self.estimate.correct(self.simd, &observation.errors());
        }
        update
    }

    /// Observes one state of a block, that of an `axis`, with a `variance`; returns the estimated
    /// errors, which are not fed back.
    pub(crate) fn observe_axis(
        &mut self,
        state: (Block, usize),
        innovation: f64,
        variance: f64,
        gate: f64,
        recorder: &mut impl FilterRecorder,
    ) -> Option<ErrorStates> {
        let covariance = self.propagation.flushed(self.simd, recorder);
        let used =
            self.simd.vectorize(ObserveAxis { covariance, state, innovation, variance, gate })?;
        recorder.observation(self.simd, &used);
        Some(used.errors())
    }

    /// Covariance of the error states.
    #[must_use]
    pub(crate) fn covariance(&self) -> Covariance {
        self.propagation.current(self.simd)
    }

    /// Covariance of the error states, unless propagation is pending, as it may be in swing.
    #[must_use]
    pub(crate) fn covariance_if_current(&self) -> Option<&Covariance> {
        self.propagation.if_current()
    }

    /// One-sigma position uncertainty in n, m.
    #[must_use]
    #[inline]
    pub(crate) fn position_std(&self) -> Vector3<f64> {
        self.propagation.position_variances().map(f64::sqrt)
    }

    /// One-sigma uncertainty of roll or pitch, whichever is larger, rad.
    #[must_use]
    pub(crate) fn tilt_std(&self) -> f64 {
        let attitude = self.propagation.last_propagated().diagonal(Block::Attitude);
        attitude.x.max(attitude.y).max(0.0).sqrt()
    }

    /// Checks that the state is finite and every variance positive, after intervals without a
    /// measurement since the last check.
    ///
    /// A prediction reduces no variance, and a number that is not finite, in the state or in its
    /// covariance, reaches the position in the same step.
    ///
    /// # Errors
    /// As [`ErrorStateFilter::check`].
    #[inline(always)]
    pub(crate) fn check_prediction(&self) -> Result<(), NumericalError> {
        let [x, y, z] = self.propagation.last_propagated().diagonal(Block::Position).into();
        let positive = x > 0.0 && y > 0.0 && z > 0.0;
        if positive && (x + y + z + self.estimate.nav.position.sum()).is_finite() {
            Ok(())
        } else {
            self.check()
        }
    }

    /// Checks that the state is finite and every variance positive.
    ///
    /// # Errors
    /// [`NumericalError`] naming the state and its variance.
    #[inline]
    pub(crate) fn check(&self) -> Result<(), NumericalError> {
        let time = self.estimate.nav.time;
        if !self.estimate.nav.is_finite() {
            return Err(NumericalError::StateNotFinite { time });
        }
        match self.propagation.last_propagated().first_not_positive() {
            None => Ok(()),
            Some((state, variance)) => {
                Err(NumericalError::CovarianceNotPositive { time, state, variance })
            }
        }
    }
}

/// See [`ErrorStateFilter::couple`].
struct Couple<'a> {
    covariance: &'a mut Covariance,
    m: &'a Matrix3<f64>,
}

impl WithSimd for Couple<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        self.covariance.add_transformed(simd, Block::Attitude, Block::AccelBias, self.m);
    }
}

/// See [`ErrorStateFilter::observe_axis`].
struct ObserveAxis<'a> {
    covariance: &'a mut Covariance,
    state: (Block, usize),
    innovation: f64,
    variance: f64,
    gate: f64,
}

impl WithSimd for ObserveAxis<'_> {
    type Output = Option<Observation>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { covariance, state, innovation, variance, gate } = self;
        let mut used = None;
        covariance.observe_axis(simd, state, innovation, variance, gate, &mut used);
        used
    }
}

/// Number of intervals over which the covariance is propagated at once in swing.
fn batch_size(setup: &FilterSetup<'_>) -> usize {
    if setup.batches {
        samples(setup.filter.covariance_interval / setup.strapdown.nominal_interval)
    } else {
        1
    }
}
