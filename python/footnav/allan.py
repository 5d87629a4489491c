"""Allan deviation of a sensor at rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from footnav import _core
from footnav.errors import ConfigError, DataError, FootnavError
from footnav.noise import NoiseFigures, confidence_limits, fit_axis
from footnav.noise_preconditions import CHANNELS, check_even, check_rest
from footnav.recording import Floats, Recording
from footnav.rest_detection import UNITS

MIN_TAU, MIN_CLUSTERS = 10.0, 10
"""Averaging time, s, that any figure needs, and the least number of clusters of that length."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class AllanDeviation:
    """Overlapping Allan deviation of each channel.

    Attributes
    ----------
    taus : ndarray, shape (k,)
        Averaging times, s: ten per decade, up to a tenth of the recording.
    deviations : ndarray, shape (k, 6)
        Overlapping Allan deviation of each channel, in its unit.
    low, high : ndarray, shape (k, 6)
        Limits of the 95 % confidence interval.
    degrees_of_freedom : ndarray, shape (k, 6)
        Of each deviation (Riley and Howe, NIST SP 1065, table 5), for the noise type that the slope
        indicates.
    channels, units : tuple of 6 str
        "accel_x" ... "gyro_z", and "m/s^2" or "rad/s".
    duration : float
        Length of the rest, s.
    name : str
        Name of the recording.
    """

    taus: Floats
    deviations: Floats
    low: Floats
    high: Floats
    degrees_of_freedom: Floats
    channels: tuple[str, ...] = CHANNELS
    units: tuple[str, ...] = tuple(UNITS[channel[:-2]] for channel in CHANNELS)
    duration: float
    name: str = ""

    def fit(self) -> NoiseFigures:
        """Return the coefficients of white noise and biases; see `footnav.noise.fit_axis`."""
        columns = zip(self.channels, self.deviations.T, self.degrees_of_freedom.T, strict=True)
        axes = tuple(
            fit_axis(channel, self.taus, deviation, freedom)
            for channel, deviation, freedom in columns
        )
        return NoiseFigures(axes, self.name)


def allan(
    recording: Recording,
    span: tuple[float, float] | None = None,
    *,
    progress: Callable[[float], None] | None = None,
) -> AllanDeviation:
    """Measure the noise of a sensor at rest.

    The overlapping estimator of Riley and Howe, NIST SP 1065, eq. 11.

    Parameters
    ----------
    recording : Recording
        100 s of rest or more; two hours show the bias instability of a sensor for a shoe.
    span : tuple of 2 floats, optional
        Stamps between which the sensor rests, s; all of the recording unless given.
    progress : callable, optional
        Called with the share of the work that is done, 0 to 1; an exception of it cancels the work.

    Returns
    -------
    AllanDeviation
        Of accelerometer and gyroscope.

    Raises
    ------
    ConfigError
        The span holds fewer than two samples.
    DataError
        The recording is too short, has gaps, or the sensor moved.

    Warns
    -----
    FootnavWarning
        The temperature moves, or the noise of a channel is below its resolution.

    Examples
    --------
    >>> deviation = allan(simulate_rest(200.0, "mpu6050", seed=1))
    >>> [round(axis.random_walk.value, 4) for axis in deviation.fit().axes[:3]]
    [0.0039, 0.0039, 0.0039]
    """
    try:
        rest = recording if span is None else _cut(recording, span)
        _check_length(rest.duration)
        check_even(rest.t)
        check_rest(rest)
    except FootnavError as error:
        if recording.name:
            error.args = (f"{recording.name}: {error}",)
        raise
    interval = rest.duration / (len(rest) - 1)
    halves = [
        _core.allan(samples, _part(progress, k))
        for k, samples in enumerate((rest.accel, rest.gyro))
    ]
    deviations, freedom = (
        np.hstack([half[key] for half in halves]) for key in ("deviation", "degrees_of_freedom")
    )
    low, high = confidence_limits(deviations, freedom)
    return AllanDeviation(
        taus=interval * halves[0]["factors"],
        deviations=deviations,
        low=low,
        high=high,
        degrees_of_freedom=freedom,
        duration=rest.duration,
        name=recording.name,
    )


def _cut(recording: Recording, span: tuple[float, float]) -> Recording:
    start, end = span
    rows = (recording.t >= start) & (recording.t <= end)
    if rows.sum() < 2:
        raise ConfigError(
            f"span is {start:g} to {end:g} s, but the stamps go from {recording.t[0]:g} to "
            f"{recording.t[-1]:g} s"
        )
    temperature = None if recording.temperature is None else recording.temperature[rows]
    return Recording(
        recording.t[rows], recording.accel[rows], recording.gyro[rows], temperature=temperature
    )


def _check_length(duration: float) -> None:
    if duration < MIN_TAU * MIN_CLUSTERS:
        raise DataError(
            f"{duration:.3g} s of rest are too short: averages over {MIN_TAU:g} s take "
            f"{MIN_CLUSTERS} such intervals, so at least {MIN_TAU * MIN_CLUSTERS:g} s; "
            "two hours show the bias instability"
        )


def _part(progress: Callable[[float], None] | None, done: int) -> Callable[[float], None]:
    """Return a callback that scales the progress of one sensor of two."""
    if progress is None:
        return lambda _: None
    return lambda share: progress((done + share) / 2)
