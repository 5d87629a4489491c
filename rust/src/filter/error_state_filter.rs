//! The error-state filter: an estimate and the covariance of its errors.

use nalgebra::{Matrix3, Vector3};

use crate::aiding::accelerometer_attitude;
use crate::config::{Config, SmootherKind};
use crate::error::NumericalError;
use crate::filter::covariance::Covariance;
use crate::filter::error_state::{Block, ErrorStates, LinearMap};
use crate::filter::observation::Update;
use crate::filter::propagation::Propagation;
use crate::filter::recorder::FilterRecorder;
use crate::filter::transition::{Noise, Transition};
use crate::ins::alignment::Aligned;
use crate::ins::strapdown::{Step, Strapdown};
use crate::math::rotation_kernels;
use crate::math::simd::{Baseline, Lanes};
use crate::types::nav_state::NavState;
use crate::types::rate::samples;
use crate::types::sample::ImuSample;
use crate::types::solution::Estimate;

impl Estimate {
    /// Adds estimated errors: the feedback.
    pub(crate) fn correct(&mut self, errors: &ErrorStates) {
        self.correct_on::<Baseline>(errors);
    }

    /// The same on the lanes that the caller is compiled for.
    #[inline(always)]
    fn correct_on<L: Lanes>(&mut self, errors: &ErrorStates) {
        let ErrorStates([position, velocity, attitude, gyro_bias, accel_bias]) = errors;
        self.nav.position += position;
        self.nav.velocity += velocity;
        self.nav.attitude = rotation_kernels::turn_after::<L>(&self.nav.attitude, attitude);
        self.gyro_bias += gyro_bias;
        self.accel_bias += accel_bias;
    }
}

/// Noise that the settings describe, as variances per second.
#[derive(Clone, Copy, Debug)]
struct ProcessNoise {
    velocity: f64,
    attitude: f64,
    gyro_bias: f64,
    accel_bias: f64,
}

impl ProcessNoise {
    /// Variances after `motion` (s) of what a foot in motion makes of the sensor's noise, and `dt`
    /// (s) of what its biases do.
    #[inline]
    fn over(&self, motion: f64, dt: f64) -> Noise {
        Noise {
            position: 0.0,
            velocity: self.velocity * motion,
            attitude: self.attitude * motion,
            gyro_bias: self.gyro_bias * dt,
            accel_bias: self.accel_bias * dt,
            position_velocity: 0.0,
        }
    }
}

/// The filter: an estimate and the covariance of its errors.
#[derive(Clone, Debug)]
pub struct ErrorStateFilter {
    /// The estimate.
    pub estimate: Estimate,
    propagation: Propagation,
    noise: ProcessNoise,
    clipped_factor: f64,
    gravity: f64,
    earth_rate: Vector3<f64>,
    gate: f64,
}

/// Standard deviation of the velocity of a foot that is taken up in motion, m/s.
const VELOCITY_STD_IN_MOTION: f64 = 1.0;
/// Standard deviation of roll and pitch levelled on a moving foot, rad.
const TILT_STD_IN_MOTION: f64 = 0.2;
/// Second derivative of a walking foot's angular rate, rad/s³: about 5 rad/s at twice a second.
const RATE_CURVATURE: f64 = 1_000.0;
/// Second derivative of its specific force, m/s⁴: about 15 m/s² at three times a second.
const FORCE_CURVATURE: f64 = 5_000.0;
/// Angular rate of a foot that nobody sees, rad/s.
const FOOT_RATE: f64 = 4.0;
/// Specific force beyond gravity of a foot that nobody sees, m/s².
const FOOT_FORCE: f64 = 10.0;
/// Speed of a person who walks unseen, m/s.
const WALKING_SPEED: f64 = 1.5;
/// Standard deviation of the heading of a person who was not seen for a while, rad.
const HEADING_STD_AFTER_GAP: f64 = 1.0;
/// Squared Mahalanobis distance of an observed heading beyond which it is rejected: what bends a
/// magnetic field is not Gaussian.
const HEADING_GATE: f64 = 9.0;
/// Variance of a state that is known by definition, such as the heading where it only says where n
/// x points: small, but above rounding.
const BY_DEFINITION: f64 = 1.0e-10;
/// Standard deviation of the place of a foot at rest at the start, m: it rocks a little, and
/// nothing tells about which point.
pub(crate) const STANDING_STD: f64 = 2.0e-3;

impl ErrorStateFilter {
    /// A filter that starts from an alignment at `time`, and corrects what `strapdown` makes of the
    /// samples.
    #[must_use]
    pub fn new(config: &Config, aligned: &Aligned, time: f64, strapdown: &Strapdown) -> Self {
        let (sensor, filter) = (&config.sensor, &config.filter);
        let estimate = Estimate {
            nav: NavState::at_rest(time, aligned.attitude),
            gyro_bias: bias_gain(config, aligned) * aligned.gyro_bias,
            accel_bias: Vector3::zeros(),
        };
        let noise = ProcessNoise {
            velocity: sensor.accel_noise_density.powi(2) + filter.specific_force_noise.powi(2),
            attitude: sensor.gyro_noise_density.powi(2) + filter.angular_rate_noise.powi(2),
            gyro_bias: sensor.gyro_bias_walk.powi(2),
            accel_bias: sensor.accel_bias_walk.powi(2),
        };
        Self {
            estimate,
            propagation: Propagation::new(
                initial_covariance(config, aligned),
                steps_at_once(config, strapdown),
            ),
            noise,
            clipped_factor: filter.clipped_noise_factor.powi(2),
            gravity: config.gravity(),
            earth_rate: strapdown.earth_rate,
            gate: filter.chi2_gate,
        }
    }

    /// Carries the covariance over one step of the mechanization, which may have to wait for others
    /// if the foot `swings`; what clips adds too much noise for that.
    ///
    /// `bridged` is the part of the step that no sample speaks for, s; `strayed` is a variance that
    /// the position gains beside it, m².
    #[inline(always)]
    pub(crate) fn predict<L: Lanes>(
        &mut self,
        step: &Step,
        clipped: bool,
        bridged: f64,
        strayed: f64,
        swings: bool,
        recorder: &mut impl FilterRecorder,
    ) {
        let transition = Transition::new(step, &self.earth_rate);
        let motion = if clipped { self.clipped_factor * step.dt } else { step.dt };
        let noise = Noise { position: strayed, ..self.noise.over(motion, step.dt) };
        self.propagation.step::<L>(transition, noise, swings && !clipped, recorder);
        if bridged > 0.0 {
            self.inflate_for_gap(bridged, recorder);
        }
    }

    /// What a straight line across a gap may miss: a twelfth of the curvature times the cube of the
    /// gap, and no more than a foot can do in that time.
    fn inflate_for_gap(&mut self, gap: f64, recorder: &mut impl FilterRecorder) {
        let missed = |curvature: f64, most: f64| (curvature * gap.powi(3) / 12.0).min(most * gap);
        let angle = missed(RATE_CURVATURE, FOOT_RATE);
        let velocity = missed(FORCE_CURVATURE, FOOT_FORCE) + 0.5 * self.gravity * angle * gap;
        self.inflate(Block::Attitude, angle.powi(2), recorder);
        self.inflate(Block::Velocity, velocity.powi(2), recorder);
        self.inflate(Block::Position, (0.5 * gap * velocity).powi(2), recorder);
    }

    /// Adds independent errors of this `variance` to each state of a block.
    pub(crate) fn inflate(
        &mut self,
        block: Block,
        variance: f64,
        recorder: &mut impl FilterRecorder,
    ) {
        self.propagation.flushed(recorder).add_variance(block, variance);
        recorder.inflate(block, variance);
    }

    /// What was known of a block is forgotten; its states have these `variances`.
    fn reset_block(
        &mut self,
        block: Block,
        variances: &Vector3<f64>,
        recorder: &mut impl FilterRecorder,
    ) {
        self.propagation.flushed(recorder).reset_block(block, variances);
        recorder.reset_block(block, variances);
    }

    /// After a gap too long to be bridged: the foot is where it was, or as far away as one walks in
    /// `elapsed` (s), and may move.
    pub(crate) fn resume(&mut self, time: f64, elapsed: f64, recorder: &mut impl FilterRecorder) {
        self.estimate.nav.time = time;
        self.estimate.nav.velocity = Vector3::zeros();
        let walked = Vector3::repeat((WALKING_SPEED * elapsed).powi(2));
        let position = self.propagation.flushed(recorder).diagonal(Block::Position) + walked;
        self.reset_block(Block::Position, &position, recorder);
        self.reset_block(
            Block::Velocity,
            &Vector3::repeat(VELOCITY_STD_IN_MOTION.powi(2)),
            recorder,
        );
        self.reset_block(
            Block::Attitude,
            &attitude_variances(TILT_STD_IN_MOTION, HEADING_STD_AFTER_GAP),
            recorder,
        );
        for bias in [Block::GyroBias, Block::AccelBias] {
            let variances = self.propagation.flushed(recorder).diagonal(bias);
            self.reset_block(bias, &variances, recorder);
        }
    }

    /// Zero-velocity update: the velocity is that of a foot on the ground, zero but for its rolling
    /// (n, m/s), up to a `variance` (m²/s²) on each axis.
    ///
    /// `insist` is for a foot that stands although the innovation test says otherwise: the velocity
    /// is then doubted by as much as it was found to be wrong.
    #[inline(always)]
    pub(crate) fn zero_velocity<L: Lanes>(
        &mut self,
        rolling: &Vector3<f64>,
        variance: f64,
        insist: bool,
        recorder: &mut impl FilterRecorder,
    ) -> Update {
        let innovation = rolling - self.estimate.nav.velocity;
        if insist {
            self.inflate(Block::Velocity, innovation.norm_squared(), recorder);
        }
        self.observe::<L>(Block::Velocity, &innovation, variance, recorder)
    }

    /// Zero-angular-rate update: the foot turns with the Earth alone, up to `std` (rad/s); the rest
    /// of what the gyroscope reads is its bias.
    #[inline(always)]
    pub(crate) fn zero_angular_rate<L: Lanes>(
        &mut self,
        sample: &ImuSample,
        std: f64,
        recorder: &mut impl FilterRecorder,
    ) -> Update {
        let earth_rate = self.estimate.nav.attitude.inverse() * self.earth_rate;
        let innovation = sample.angular_rate - earth_rate - self.estimate.gyro_bias;
        self.observe::<L>(Block::GyroBias, &innovation, std * std, recorder)
    }

    /// Magnitude of the specific force less gravity, m/s².
    #[must_use]
    pub(crate) fn gravity_residual(&self, sample: &ImuSample) -> f64 {
        (sample.specific_force - self.estimate.accel_bias).norm() - self.gravity
    }

    /// Gravity update: at rest the specific force points up, up to `std` (rad).
    ///
    /// The direction that it shows is that of up plus what the accelerometer's bias tilts it by, so
    /// attitude and bias are observed together.
    pub(crate) fn gravity(
        &mut self,
        step: &Step,
        sample: &ImuSample,
        std: f64,
        recorder: &mut impl FilterRecorder,
    ) {
        let force = sample.specific_force - self.estimate.accel_bias;
        let tilt = accelerometer_attitude::observe(&step.attitude, &force).tilt;
        let levelling = levelling(&step.attitude, self.gravity);
        self.couple(&-levelling, recorder);
        let mut errors = self.observe_attitude(tilt.into_iter().enumerate(), std, recorder);
        self.couple(&levelling, recorder);
        errors.add_transformed(Block::Attitude, Block::AccelBias, &levelling);
        self.estimate.correct(&errors);
    }

    /// Accelerometer attitude as published (Wang et al. 2019, eq. 17): roll, pitch and, where the
    /// formula has a value, a heading, each up to `std` (rad).
    ///
    /// The accelerometer's bias is not part of the published observation.
    pub(crate) fn accelerometer_attitude(
        &mut self,
        step: &Step,
        sample: &ImuSample,
        std: f64,
        recorder: &mut impl FilterRecorder,
    ) {
        let force = sample.specific_force - self.estimate.accel_bias;
        let observed = accelerometer_attitude::observe(&step.attitude, &force);
        let axes = observed
            .tilt
            .into_iter()
            .enumerate()
            .chain(observed.heading.map(|heading| (2, heading)));
        let errors = self.observe_attitude(axes, std, recorder);
        self.estimate.correct(&errors);
    }

    /// Heading update: the heading is wrong by `innovation` (rad), up to a `variance` (rad²).
    pub(crate) fn heading(
        &mut self,
        innovation: f64,
        variance: f64,
        recorder: &mut impl FilterRecorder,
    ) -> Update {
        let covariance = self.propagation.flushed(recorder);
        let (update, observation) =
            covariance.observe_axis(Block::Attitude, 2, innovation, variance, HEADING_GATE);
        if let Some(observation) = observation {
            recorder.observation(&observation);
            self.estimate.correct(&observation.errors());
        }
        update
    }

    /// Dead reckoning: the velocity is set to zero and nothing else is learned from it.
    pub(crate) fn reset_velocity(&mut self, variance: f64, recorder: &mut impl FilterRecorder) {
        self.estimate.nav.velocity = Vector3::zeros();
        self.reset_block(Block::Velocity, &Vector3::repeat(variance), recorder);
    }

    /// The walk begins here.
    pub(crate) fn reset_position(&mut self) {
        self.estimate.nav.position = Vector3::zeros();
        self.propagation.flushed(&mut ()).replace(Block::Position, STANDING_STD.powi(2));
    }

    /// Observes attitude errors (rad) about some axes of n, one after the other, and returns the
    /// errors that they tell of.
    fn observe_attitude(
        &mut self,
        axes: impl Iterator<Item = (usize, f64)>,
        std: f64,
        recorder: &mut impl FilterRecorder,
    ) -> ErrorStates {
        let mut errors = ErrorStates::default();
        for (axis, observed) in axes {
            let innovation = observed - errors.block(Block::Attitude)[axis];
            let covariance = self.propagation.flushed(recorder);
            let (_, observation) =
                covariance.observe_axis(Block::Attitude, axis, innovation, std * std, self.gate);
            if let Some(observation) = observation {
                recorder.observation(&observation);
                errors += observation.errors();
            }
        }
        errors
    }

    /// The attitude errors gain `m` times those of the accelerometer's bias.
    fn couple(&mut self, m: &Matrix3<f64>, recorder: &mut impl FilterRecorder) {
        self.propagation.flushed(recorder).add_transformed(Block::Attitude, Block::AccelBias, m);
        recorder.couple(m);
    }

    #[inline(always)]
    fn observe<L: Lanes>(
        &mut self,
        block: Block,
        innovation: &Vector3<f64>,
        variance: f64,
        recorder: &mut impl FilterRecorder,
    ) -> Update {
        let mut used = None;
        let covariance = self.propagation.flushed(recorder);
        let update = covariance.observe_on::<L>(block, innovation, variance, self.gate, &mut used);
        if let Some(observation) = &used {
            recorder.observation(observation);
            self.estimate.correct_on::<L>(&observation.errors());
        }
        update
    }

    /// Covariance of the error states.
    #[must_use]
    pub fn covariance(&self) -> Covariance {
        self.propagation.now()
    }

    /// Covariance of the error states, if it is at hand: in the swing it may have to be carried
    /// over steps that wait.
    #[must_use]
    pub(crate) fn covariance_at_hand(&self) -> Option<&Covariance> {
        self.propagation.if_current()
    }

    /// One-sigma position uncertainty in n, m.
    #[must_use]
    #[inline]
    pub fn position_std(&self) -> Vector3<f64> {
        self.propagation.position_variances().map(f64::sqrt)
    }

    /// One-sigma uncertainty of roll or pitch, whichever is larger, rad.
    #[must_use]
    pub fn tilt_std(&self) -> f64 {
        let attitude = self.propagation.last_propagated().diagonal(Block::Attitude);
        attitude.x.max(attitude.y).max(0.0).sqrt()
    }

    /// Checks that the state is finite and every variance positive, of an estimate that nothing was
    /// observed of since the last check.
    ///
    /// A prediction takes nothing off a variance, and what is not finite, in the state or in its
    /// covariance, is at once in the position's.
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
    pub fn check(&self) -> Result<(), NumericalError> {
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

/// Number of steps that the covariance may be carried over at once; a smoother goes back over each
/// of them.
fn steps_at_once(config: &Config, strapdown: &Strapdown) -> usize {
    match config.smoother.kind {
        SmootherKind::None => {
            samples(config.filter.covariance_interval / strapdown.nominal_interval)
        }
        SmootherKind::Stepwise | SmootherKind::Rts => 1,
    }
}

/// The tilt J δb that a bias of the accelerometer gives an attitude that was levelled with it.
///
/// From `C_true (f - δb) = g z` and `C_est f = g z`: g J = [[0, -1, 0], [1, 0, 0], [0, 0, 0]] C.
fn levelling(attitude: &Matrix3<f64>, gravity: f64) -> Matrix3<f64> {
    Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0) * attitude / gravity
}

/// Covariance after the alignment: roll and pitch are wrong by what the accelerometer's bias tilts
/// the measured vertical, and correlated with it.
fn initial_covariance(config: &Config, aligned: &Aligned) -> Covariance {
    let accel_bias = config.sensor.accel_bias_std.powi(2);
    let settings = &config.alignment;
    let heading_std = settings.heading_std_deg.to_radians();
    let mut p = Covariance::zero();
    p.add_variance(Block::Position, STANDING_STD.powi(2));
    p.add_variance(Block::AccelBias, accel_bias);
    if !aligned.at_rest {
        p.add_variance(Block::Velocity, VELOCITY_STD_IN_MOTION.powi(2));
        p.add_diagonal(Block::Attitude, &attitude_variances(TILT_STD_IN_MOTION, heading_std));
        p.add_variance(Block::GyroBias, config.sensor.gyro_bias_std.powi(2));
        return p;
    }
    let levelling = levelling(aligned.attitude.to_rotation_matrix().matrix(), config.gravity());
    p.add_transformed(Block::Attitude, Block::AccelBias, &levelling);
    p.add_diagonal(Block::Attitude, &attitude_variances(settings.tilt_std, heading_std));
    p.add_variance(Block::Velocity, config.filter.zero_velocity_std.powi(2));
    let averaged =
        settings.gyro_bias_std.powi(2) * settings.duration / aligned.rest.min(settings.duration);
    p.add_variance(Block::GyroBias, averaged + bias_gain(config, aligned) * aligned.sway.powi(2));
    p
}

/// How much of the average angular rate at rest is taken for the gyroscope's bias: all of it when
/// the foot did not sway, little when it swayed by more than biases are.
///
/// The estimate with the least variance of a bias of variance σ² from an average that the sway puts
/// out by s is σ²/(σ² + s²) of the average.
fn bias_gain(config: &Config, aligned: &Aligned) -> f64 {
    let bias = config.sensor.gyro_bias_std.powi(2);
    bias / (bias + aligned.sway.powi(2))
}

/// Variances of the attitude error: roll and pitch, and a heading that may be known by definition.
fn attitude_variances(tilt_std: f64, heading_std: f64) -> Vector3<f64> {
    Vector3::new(tilt_std.powi(2), tilt_std.powi(2), heading_std.powi(2).max(BY_DEFINITION))
}
