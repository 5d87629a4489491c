//! Input validation: only finite samples in the order of time pass; missing, repeated and clipped
//! ones are flagged and counted.

use nalgebra::Vector3;

use crate::config::Config;
use crate::error::DataError;
use crate::pipeline::health_monitor::Counters;
use crate::types::health::Flags;
use crate::types::sample::ImuSample;

/// Share of the full scale from which a reading counts as clipped: converters saturate a little
/// below their nominal range.
const FULL_SCALE_SHARE: f64 = 0.995;

/// Validates one sample after the other.
#[derive(Clone, Debug)]
pub(crate) struct InputValidator {
    longest_interval: f64,
    accel_limit: f64,
    gyro_limit: f64,
    /// Stamp of the newest sample; NaN before the first.
    previous_time: f64,
    refused_since: bool,
    pub(crate) counters: Counters,
}

impl InputValidator {
    pub(crate) fn new(config: &Config, nominal_interval: f64) -> Self {
        let limit = |range: Option<f64>| range.map_or(f64::INFINITY, |r| FULL_SCALE_SHARE * r);
        Self {
            longest_interval: config.health.gap_intervals * nominal_interval,
            accel_limit: limit(config.sensor.accel_range),
            gyro_limit: limit(config.sensor.gyro_range),
            previous_time: f64::NAN,
            refused_since: false,
            counters: Counters::default(),
        }
    }

    /// Validates a raw sample and returns its flags.
    ///
    /// # Errors
    /// [`DataError`] for a sample that is not finite or goes back in time.  It is counted and
    /// discarded: the next valid sample continues after a gap.
    #[inline]
    pub(crate) fn ingest(&mut self, raw: &ImuSample) -> Result<Flags, DataError> {
        if self.is_nominal(raw) {
            return Ok(self.count(raw, Flags::empty()));
        }
        self.refuse_invalid(raw)?;
        Ok(self.ingest_checked(raw))
    }

    /// Returns the flags of a raw sample that passed [`InputValidator::check_block`].
    #[inline]
    pub(crate) fn ingest_checked(&mut self, raw: &ImuSample) -> Flags {
        let flags = if self.is_nominal(raw) { Flags::empty() } else { self.flag(raw) };
        self.count(raw, flags)
    }

    /// Checks a block of samples without counting them.
    pub(crate) fn check_block(&self, block: &[ImuSample]) -> Result<(), DataError> {
        let mut previous_time = self.previous_time;
        for (index, raw) in (self.next_index()..).zip(block) {
            check(raw, index, previous_time)?;
            previous_time = raw.time;
        }
        Ok(())
    }

    fn next_index(&self) -> u64 {
        self.counters.samples + self.counters.refused
    }

    /// Whether a sample is valid and has no flag.  A sample with no axis at full scale, but with a
    /// magnitude beyond it, has no flag and is not nominal either.
    ///
    /// A number that is not finite makes a comparison false.
    #[inline]
    fn is_nominal(&self, raw: &ImuSample) -> bool {
        let interval = raw.time - self.previous_time;
        let in_order = interval > 0.0 && interval <= self.longest_interval && !self.refused_since;
        let in_range = |v: &Vector3<f64>, limit: f64| v.norm_squared() < limit * limit;
        in_order
            && in_range(&raw.specific_force, self.accel_limit)
            && in_range(&raw.angular_rate, self.gyro_limit)
    }

    #[inline]
    fn count(&mut self, raw: &ImuSample, flags: Flags) -> Flags {
        self.counters.samples += 1;
        self.previous_time = raw.time;
        flags
    }

    #[cold]
    fn refuse_invalid(&mut self, raw: &ImuSample) -> Result<(), DataError> {
        let checked = check(raw, self.next_index(), self.previous_time);
        if checked.is_err() {
            self.counters.refused += 1;
            self.refused_since = true;
        }
        checked
    }

    /// The flags of a valid sample, counted.
    #[cold]
    fn flag(&mut self, raw: &ImuSample) -> Flags {
        let interval = raw.time - self.previous_time;
        let mut flags = Flags::empty();
        flags.set(Flags::REFUSED, std::mem::take(&mut self.refused_since));
        flags.set(Flags::CLIPPED, self.is_clipped(raw));
        flags.set(Flags::GAP, interval > self.longest_interval);
        self.counters.repeated += u64::from(interval == 0.0);
        self.counters.gaps += u64::from(flags.contains(Flags::GAP));
        self.counters.clipped += u64::from(flags.contains(Flags::CLIPPED));
        flags
    }

    fn is_clipped(&self, raw: &ImuSample) -> bool {
        let reached =
            |v: &Vector3<f64>, limit: f64| v.iter().any(|component| component.abs() >= limit);
        reached(&raw.specific_force, self.accel_limit)
            || reached(&raw.angular_rate, self.gyro_limit)
    }
}

/// Finite, and not older than the sample before, if there is one.
#[inline]
fn check(raw: &ImuSample, index: u64, previous: f64) -> Result<(), DataError> {
    raw.check_finite(index)?;
    if raw.time < previous {
        return Err(DataError::TimeReversed { index, time: raw.time, previous });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const INTERVAL: f64 = 0.01;
    const ACCEL_RANGE: f64 = 100.0;
    const GYRO_RANGE: f64 = 30.0;

    fn validator(ranges: bool) -> InputValidator {
        let mut config = Config::default();
        config.sensor.accel_range = ranges.then_some(ACCEL_RANGE);
        config.sensor.gyro_range = ranges.then_some(GYRO_RANGE);
        InputValidator::new(&config, INTERVAL)
    }

    fn reading(range: f64) -> impl Strategy<Value = [f64; 3]> {
        let odd = prop_oneof![
            Just(range),
            Just(-range),
            Just(1e200),
            Just(f64::NAN),
            Just(f64::INFINITY)
        ];
        prop::array::uniform3(prop_oneof![60 => -range..range, 1 => odd])
    }

    /// Samples a few intervals apart, some of which have a stamp that is repeated, old or not
    /// finite.
    fn samples() -> impl Strategy<Value = Vec<ImuSample>> {
        let steps = prop_oneof![
            12 => Just(1.0),
            1 => 1.0..3.0,
            1 => Just(0.0),
            1 => Just(-2.5),
            1 => Just(f64::NAN),
        ];
        prop::collection::vec((steps, reading(ACCEL_RANGE), reading(GYRO_RANGE)), 1..40).prop_map(
            |rows| {
                let mut time = 5.0;
                let sample = |(step, force, rate): (f64, [f64; 3], [f64; 3])| {
                    let stamp = time + step * INTERVAL;
                    time = if stamp > time { stamp } else { time };
                    ImuSample::new(stamp, force, rate)
                };
                rows.into_iter().map(sample).collect()
            },
        )
    }

    /// The flags of a sample by their documentation, one after the other; none for a
    /// sample to refuse.
    fn judged(
        raw: &ImuSample,
        previous: Option<&ImuSample>,
        refused_since: bool,
        ranges: bool,
    ) -> Option<Flags> {
        let finite = raw.time.is_finite()
            && raw.specific_force.iter().chain(&raw.angular_rate).all(|x| x.is_finite());
        if !finite || previous.is_some_and(|previous| raw.time < previous.time) {
            return None;
        }
        let reaches = |x: f64, range: f64| ranges && x.abs() >= FULL_SCALE_SHARE * range;
        let clipped = raw.specific_force.iter().any(|&x| reaches(x, ACCEL_RANGE))
            || raw.angular_rate.iter().any(|&x| reaches(x, GYRO_RANGE));
        let longest = Config::default().health.gap_intervals * INTERVAL;
        let mut events = Flags::empty();
        events.set(Flags::CLIPPED, clipped);
        events.set(Flags::REFUSED, refused_since);
        events.set(Flags::GAP, previous.is_some_and(|previous| raw.time - previous.time > longest));
        Some(events)
    }

    proptest! {
        #[test]
        fn every_sample_is_judged_by_each_rule(samples in samples(), ranges: bool) {
            let mut validator = validator(ranges);
            let (mut previous, mut refused, mut repeated): (Option<&ImuSample>, _, _) = (None, 0, 0);
            let mut refused_since = false;
            for raw in &samples {
                let expected = judged(raw, previous, refused_since, ranges);
                prop_assert_eq!(validator.check_block(std::slice::from_ref(raw)).is_ok(), expected.is_some());
                prop_assert_eq!(validator.ingest(raw).ok(), expected);
                refused_since = expected.is_none();
                refused += u64::from(refused_since);
                if !refused_since {
                    repeated += u64::from(previous.is_some_and(|previous| raw.time - previous.time == 0.0));
                    previous = Some(raw);
                }
            }
            prop_assert_eq!((validator.counters.refused, validator.counters.repeated), (refused, repeated));
            prop_assert_eq!(validator.counters.samples + refused, samples.len() as u64);
        }
    }
}
