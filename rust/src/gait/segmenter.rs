//! Finds strides row by row, in the order in which the rows come.

use nalgebra::{Matrix3, Vector3};

use crate::filter::cloning::{ClonedErrors, pose_covariance};
use crate::filter::covariance::Covariance;
use crate::filter::error_state::Block;
use crate::filter::observation::Observation;
use crate::filter::process_noise::Noise;
use crate::filter::recorder::FilterRecorder;
use crate::filter::transition::Transition;
use crate::gait::stance::{StanceMerger, microseconds};
use crate::gait::stride::Stride;
use crate::math::simd::Simd;
use crate::types::nav_state::NavState;

/// Time after the first sample of a stance within which a stride arrives, and before the last one
/// within which the next departs, µs.
const WINDOW: f64 = 500_000.0;

/// Finds where the foot arrives and departs.
///
/// Which sample a stride departs from is known when the stance is over, but its errors must be
/// cloned when they are there.  So a rest is cut into pieces of half the window, and the flattest
/// samples of the running piece and of the one before are kept: the departure is the flatter of the
/// two.  In a stance shorter than the window it is the sample of the arrival, so that one stride
/// starts where the one before ended.
#[derive(Clone, Debug)]
pub(crate) struct Segmenter {
    forward: Vector3<f64>,
    merger: StanceMerger,
    row: usize,
    before: Option<NavState>,
    /// Where the stance before was left; gone when no stride can start there any more.
    departure: Option<Anchor>,
    stance: Option<Stance>,
}

/// A row, and how well it is known.
struct Sample<'a> {
    row: usize,
    state: &'a NavState,
    /// Measure of the turn since the row before.
    turning: f64,
    covariance: Option<&'a Covariance>,
}

/// A row at which a stride may start.
#[derive(Clone, Debug)]
struct Anchor {
    row: usize,
    state: NavState,
    turning: f64,
    errors: Option<ClonedErrors>,
}

/// A stride that ends at the flattest sample so far.
#[derive(Clone, Debug)]
struct Arrival {
    stride: Stride,
    turning: f64,
}

/// A stance that is not over.
#[derive(Clone, Debug)]
struct Stance {
    /// Stamp of the first sample, s.
    began: f64,
    /// Gone when it was handed out.
    arrival: Option<Arrival>,
    /// Flattest sample of the piece before.
    if_current: Option<Anchor>,
    /// Flattest sample of the running piece.
    newest: Anchor,
    /// Stamp of the first sample of the running piece, s.
    piece_began: f64,
}

impl Segmenter {
    /// Headings are those of the axis `forward` of the sensor frame.
    pub(crate) fn new(forward: Vector3<f64>) -> Self {
        Self {
            forward,
            merger: StanceMerger::default(),
            row: 0,
            before: None,
            departure: None,
            stance: None,
        }
    }

    /// Takes the next row, with the covariance of its errors if there is one; returns the stride
    /// that is known by now.
    pub(crate) fn push(
        &mut self,
        state: &NavState,
        rests: bool,
        covariance: Option<&Covariance>,
    ) -> Option<Stride> {
        let event = self.merger.push(state.time, rests);
        let left = if event.ends { self.finish() } else { None };
        let turning = self.before.map_or(f64::INFINITY, |before| turning(&before, state));
        let sample = Sample { row: self.row, state, turning, covariance };
        self.before = Some(*state);
        self.row += 1;
        if event.begins {
            self.begin_stance(&sample);
            left
        } else if rests {
            self.extend_stance(&sample)
        } else {
            left
        }
    }

    /// Ends the stance, or the data; returns the stride that ended in it.
    pub(crate) fn finish(&mut self) -> Option<Stride> {
        let stance = self.stance.take()?;
        self.departure = Some(stance.departure());
        stance.arrival.map(|arrival| arrival.stride)
    }

    /// The errors are known from here on; where the foot stood until now they were the same.
    pub(crate) fn begin(&mut self, covariance: &Covariance) {
        self.anchors().for_each(|anchor| anchor.errors = Some(ClonedErrors::of(covariance)));
    }

    /// Whether a stride may still start or end in `row`.
    pub(crate) fn touches(&self, row: usize) -> bool {
        self.departure.as_ref().is_some_and(|anchor| anchor.row == row)
            || self.stance.as_ref().is_some_and(|stance| stance.touches(row))
    }

    fn begin_stance(&mut self, sample: &Sample<'_>) {
        self.stance = Some(Stance {
            began: sample.state.time,
            arrival: self
                .departure
                .as_ref()
                .map(|departure| departure.arrive(sample, &self.forward)),
            if_current: None,
            newest: Anchor::at(sample),
            piece_began: sample.state.time,
        });
    }

    fn extend_stance(&mut self, sample: &Sample<'_>) -> Option<Stride> {
        let stance = self.stance.as_mut()?;
        stance.depart(sample);
        if microseconds(sample.state.time - stance.began) >= WINDOW {
            self.departure = None;
            return stance.arrival.take().map(|arrival| arrival.stride);
        }
        if let (Some(departure), Some(arrival)) = (&self.departure, &mut stance.arrival)
            && sample.turning < arrival.turning
        {
            *arrival = departure.arrive(sample, &self.forward);
        }
        None
    }

    fn anchors(&mut self) -> impl Iterator<Item = &mut Anchor> {
        let stance = self.stance.iter_mut();
        self.departure.iter_mut().chain(
            stance.flat_map(|stance| stance.if_current.iter_mut().chain([&mut stance.newest])),
        )
    }

    fn cloned_errors(&mut self) -> impl Iterator<Item = &mut ClonedErrors> {
        self.anchors().filter_map(|anchor| anchor.errors.as_mut())
    }
}

impl Anchor {
    fn at(sample: &Sample<'_>) -> Self {
        let &Sample { row, state, turning, covariance } = sample;
        Self { row, state: *state, turning, errors: covariance.map(ClonedErrors::of) }
    }

    /// The stride from here to a later sample.
    fn arrive(&self, there: &Sample<'_>, forward: &Vector3<f64>) -> Arrival {
        let stride = Stride::between((self.row, there.row), &self.state, there.state, forward);
        let stride = match (&self.errors, there.covariance) {
            (Some(errors), Some(covariance)) => stride.with_covariance(
                errors.own(),
                &pose_covariance(covariance),
                &errors.with_now(),
            ),
            _ => stride,
        };
        Arrival { stride, turning: there.turning }
    }
}

impl Stance {
    /// The next stride may depart from `sample`.
    fn depart(&mut self, sample: &Sample<'_>) {
        let elapsed = microseconds(sample.state.time - self.piece_began);
        if elapsed >= 0.5 * WINDOW {
            let before = std::mem::replace(&mut self.newest, Anchor::at(sample));
            self.if_current = (elapsed < WINDOW).then_some(before);
            self.piece_began = sample.state.time;
        } else if sample.turning < self.newest.turning {
            self.newest = Anchor::at(sample);
        }
    }

    /// The flatter of the two; the earlier one if they are alike.
    fn departure(&self) -> Anchor {
        let flattest = |if_current: &&Anchor| if_current.turning <= self.newest.turning;
        self.if_current.as_ref().filter(flattest).unwrap_or(&self.newest).clone()
    }

    fn touches(&self, row: usize) -> bool {
        self.newest.row == row
            || self.if_current.as_ref().is_some_and(|anchor| anchor.row == row)
            || self.arrival.as_ref().is_some_and(|arrival| arrival.stride.touches(row))
    }
}

/// How fast the foot turned between two states: the square of the sine of half the angle over the
/// time, 1/s²; infinite where it cannot be told.
fn turning(before: &NavState, after: &NavState) -> f64 {
    let dt = after.time - before.time;
    let turn = before.attitude.inverse() * after.attitude;
    let squared = turn.imag().norm_squared() / (dt * dt);
    if dt > 0.0 && !squared.is_nan() { squared } else { f64::INFINITY }
}

impl FilterRecorder for Segmenter {
    #[inline]
    fn transition(&mut self, simd: impl Simd, transition: &Transition, noise: &Noise) {
        self.cloned_errors().for_each(|errors| errors.transition(simd, transition, noise));
    }

    #[inline]
    fn inflate(&mut self, block: Block, variance: f64) {
        self.cloned_errors().for_each(|errors| errors.inflate(block, variance));
    }

    #[inline]
    fn couple(&mut self, simd: impl Simd, m: &Matrix3<f64>) {
        self.cloned_errors().for_each(|errors| errors.couple(simd, m));
    }

    #[inline]
    fn observation(&mut self, simd: impl Simd, observation: &Observation) {
        self.cloned_errors().for_each(|errors| errors.observation(simd, observation));
    }

    #[inline]
    fn reset_block(&mut self, block: Block, variances: &Vector3<f64>) {
        self.cloned_errors().for_each(|errors| errors.reset_block(block, variances));
    }
}
