//! Segmentation of a stream of navigation states into strides.

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

/// Length of the window after the start of a stance that contains the arrival, and of the window
/// before its end that contains the departure, µs.
const WINDOW: f64 = 500_000.0;

/// Finds the arrival and the departure of each stance.
///
/// The departure is determined at the end of the stance, but its errors must be cloned at its own
/// epoch.  A rest is therefore divided into intervals of half the window, and the samples of
/// minimum angular rate of the current and of the previous interval are kept; the departure is the
/// one of the lower rate.  In a stance shorter than the window it is also the arrival, so the next
/// stride starts where the previous one ended.
#[derive(Clone, Debug)]
pub(crate) struct Segmenter {
    forward: Vector3<f64>,
    merger: StanceMerger,
    row: usize,
    previous: Option<NavState>,
    /// Departure of the previous stance; none once no stride can start there.
    departure: Option<Anchor>,
    stance: Option<Stance>,
}

/// A row with the covariance of its errors.
struct Sample<'a> {
    row: usize,
    state: &'a NavState,
    /// Measure of the angular rate since the previous row, see [`rate_measure`].
    rate_measure: f64,
    covariance: Option<&'a Covariance>,
}

/// A row at which a stride may start.
#[derive(Clone, Debug)]
struct Anchor {
    row: usize,
    state: NavState,
    rate_measure: f64,
    errors: Option<ClonedErrors>,
}

/// A stride that ends at the sample of minimum angular rate so far.
#[derive(Clone, Debug)]
struct Arrival {
    stride: Stride,
    rate_measure: f64,
}

/// The current stance.
#[derive(Clone, Debug)]
struct Stance {
    /// Stamp of the first sample, s.
    start: f64,
    /// None once the stride has been returned.
    arrival: Option<Arrival>,
    /// Sample of minimum angular rate in the previous interval.
    previous: Option<Anchor>,
    /// Sample of minimum angular rate in the current interval.
    current: Anchor,
    /// Stamp of the first sample of the current interval, s.
    interval_start: f64,
}

impl Segmenter {
    /// The heading is that of the axis `forward` of the sensor frame.
    pub(crate) fn new(forward: Vector3<f64>) -> Self {
        Self {
            forward,
            merger: StanceMerger::default(),
            row: 0,
            previous: None,
            departure: None,
            stance: None,
        }
    }

    /// Processes the next row, with the covariance of its errors if available; returns the stride
    /// that is completed by it.
    pub(crate) fn push(
        &mut self,
        state: &NavState,
        rests: bool,
        covariance: Option<&Covariance>,
    ) -> Option<Stride> {
        let event = self.merger.push(state.time, rests);
        let completed = if event.ends { self.finish() } else { None };
        let rate_measure =
            self.previous.map_or(f64::INFINITY, |previous| rate_measure(&previous, state));
        let sample = Sample { row: self.row, state, rate_measure, covariance };
        self.previous = Some(*state);
        self.row += 1;
        if event.begins {
            self.begin_stance(&sample);
            completed
        } else if rests {
            self.extend_stance(&sample)
        } else {
            completed
        }
    }

    /// Ends the current stance, also at the end of the data; returns the stride that ends in it.
    pub(crate) fn finish(&mut self) -> Option<Stride> {
        let stance = self.stance.take()?;
        self.departure = Some(stance.departure());
        stance.arrival.map(|arrival| arrival.stride)
    }

    /// Starts the covariance of the errors; in the stance up to here the errors were the same.
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
            start: sample.state.time,
            arrival: self
                .departure
                .as_ref()
                .map(|departure| departure.arrive(sample, &self.forward)),
            previous: None,
            current: Anchor::at(sample),
            interval_start: sample.state.time,
        });
    }

    fn extend_stance(&mut self, sample: &Sample<'_>) -> Option<Stride> {
        let stance = self.stance.as_mut()?;
        stance.update_departure(sample);
        if microseconds(sample.state.time - stance.start) >= WINDOW {
            self.departure = None;
            return stance.arrival.take().map(|arrival| arrival.stride);
        }
        if let (Some(departure), Some(arrival)) = (&self.departure, &mut stance.arrival)
            && sample.rate_measure < arrival.rate_measure
        {
            *arrival = departure.arrive(sample, &self.forward);
        }
        None
    }

    fn anchors(&mut self) -> impl Iterator<Item = &mut Anchor> {
        let stance = self.stance.iter_mut();
        self.departure.iter_mut().chain(
            stance.flat_map(|stance| stance.previous.iter_mut().chain([&mut stance.current])),
        )
    }

    fn cloned_errors(&mut self) -> impl Iterator<Item = &mut ClonedErrors> {
        self.anchors().filter_map(|anchor| anchor.errors.as_mut())
    }
}

impl Anchor {
    fn at(sample: &Sample<'_>) -> Self {
        let &Sample { row, state, rate_measure, covariance } = sample;
        Self { row, state: *state, rate_measure, errors: covariance.map(ClonedErrors::of) }
    }

    /// The stride from this anchor to a later sample.
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
        Arrival { stride, rate_measure: there.rate_measure }
    }
}

impl Stance {
    /// Takes `sample` as a candidate for the departure of the next stride.
    fn update_departure(&mut self, sample: &Sample<'_>) {
        let elapsed = microseconds(sample.state.time - self.interval_start);
        if elapsed >= 0.5 * WINDOW {
            let last = std::mem::replace(&mut self.current, Anchor::at(sample));
            self.previous = (elapsed < WINDOW).then_some(last);
            self.interval_start = sample.state.time;
        } else if sample.rate_measure < self.current.rate_measure {
            self.current = Anchor::at(sample);
        }
    }

    /// The anchor of the lower angular rate; the earlier one if they are equal.
    fn departure(&self) -> Anchor {
        let lower = |previous: &&Anchor| previous.rate_measure <= self.current.rate_measure;
        self.previous.as_ref().filter(lower).unwrap_or(&self.current).clone()
    }

    fn touches(&self, row: usize) -> bool {
        self.current.row == row
            || self.previous.as_ref().is_some_and(|anchor| anchor.row == row)
            || self.arrival.as_ref().is_some_and(|arrival| arrival.stride.touches(row))
    }
}

/// Measure of the angular rate between two states: `sin²(angle / 2) / dt²`, 1/s²; infinite where it
/// is undefined.
fn rate_measure(before: &NavState, after: &NavState) -> f64 {
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
