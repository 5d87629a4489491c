"""Preconditions of a noise measurement: samples evenly spaced, at rest, with stationary noise."""

from __future__ import annotations

import warnings

import numpy as np

from footnav.errors import DataError, FootnavWarning
from footnav.recording import Floats, Recording
from footnav.rest_detection import ALLAN, UNITS, RestBlocks, RestDetector, longest_run

CHANNELS = tuple(f"{sensor}_{axis}" for sensor in UNITS for axis in "xyz")
"""Channels of the accelerometer and the gyroscope."""

UNEVEN = 0.8
"""Part of the median interval by which one may differ; stamps in whole ms vary by less."""

STD_FACTOR, STEP_FACTOR = 3.0, 15.0
"""Multiples of the median standard deviation of a block, and of the median step between the means
of neighbouring blocks, that stationary noise does not reach."""

MAX_TEMPERATURE_CHANGE = 2.0
"""K; more of a change counts as bias walk."""

_RESOLUTION_SAMPLES = 100_000
"""Number of samples from which the resolution is taken."""


def check_even(t: Floats) -> None:
    """Refuse samples that are not evenly spaced.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Stamps, s.

    Raises
    ------
    DataError
        An interval is far from the median one; the message names the first such interval and the
        longest stretch without any.
    """
    intervals = np.diff(t)
    median = float(np.median(intervals[intervals > 0]))
    uneven = np.abs(intervals - median) > UNEVEN * median
    if uneven.any():
        row = int(uneven.argmax())
        even = longest_run(~uneven)
        raise DataError(
            f"the stamps {t[row]:.3f} s and {t[row + 1]:.3f} s are {intervals[row]:.4g} s apart, "
            f"where {median:.4g} s are usual; {int(uneven.sum())} such interval(s) in all: the "
            "samples must be evenly spaced, so record without losses, or take the longest stretch "
            f"without one, span=({t[even.start]:.3f}, {t[even.stop]:.3f})"
        )


def check_rest(recording: Recording) -> None:
    """Refuse a recording in which the sensor moves, or its noise is not stationary.

    Parameters
    ----------
    recording : Recording
        Evenly spaced samples, a second or more.

    Raises
    ------
    DataError
        The standard deviation of a channel, or a step of its mean, is beyond its limit, or a
        channel never changes; the message gives the time of the first motion and the longest rest.

    Warns
    -----
    FootnavWarning
        The temperature changes, or the noise of a channel is below its resolution.
    """
    detector = RestDetector(ALLAN, recording.rate_hz)
    complete = detector.push_block(recording.t, recording.accel, recording.gyro)
    blocks = complete + detector.finish()
    findings: dict[int, str] = {}
    for channel in CHANNELS:
        findings = _motion(recording, channel, blocks, len(complete)) | findings
    if findings:
        raise DataError(_motion_text(recording.t, blocks, findings))
    _warn_of_temperature(recording, blocks)


def _motion_text(t: Floats, blocks: RestBlocks, findings: dict[int, str]) -> str:
    """Return when the sensor moves first, and its longest rest."""
    at_rest = np.ones(len(blocks), dtype=bool)
    at_rest[list(findings)] = False
    first, rest = min(findings), longest_run(at_rest)
    cure = "leave it alone"
    if at_rest.any():
        start, end = t[blocks.first[rest.start]], t[blocks.last[rest.stop - 1]]
        cure += f", or take its longest rest, span=({start:.3f}, {end:.3f})"
    return (
        f"{findings[first]} at {t[blocks.first[first]]:.1f} s: the sensor was moved or touched, "
        f"in {len(findings)} of {len(blocks)} s; {cure}"
    )


def _motion(
    recording: Recording, channel: str, blocks: RestBlocks, complete: int
) -> dict[int, str]:
    """Return a sentence for each block in which a channel shows motion.

    The incomplete block at the end has too few samples to compare its mean.
    """
    sensor, axis = channel.split("_")
    column = "xyz".index(axis)
    unit, resolution = UNITS[sensor], _resolution(recording, channel)
    std, means = getattr(blocks, f"{sensor}_std")[:, column], getattr(blocks, sensor)[:, column]
    step = np.abs(np.diff(means[:complete], prepend=means[0]))
    usual = float(np.median(std[:complete]))
    if usual < resolution / 2:
        _warn(
            recording.name,
            f"{channel} scatters by {usual:.2g} {unit}, less than half of its "
            f"resolution of {resolution:.2g}: its figures are those of the rounding; "
            "choose a finer range",
        )
    std_limit = min(ALLAN.std(sensor), STD_FACTOR * max(usual, resolution))
    step_limit = STEP_FACTOR * max(float(np.median(step)), resolution)
    steps = {
        int(k): _over(channel, "jumps by", step[k], unit, step_limit)
        for k in np.flatnonzero(step > step_limit)
    }
    return steps | {
        int(k): _over(channel, "scatters by", std[k], unit, std_limit)
        for k in np.flatnonzero(std > std_limit)
    }


def _over(channel: str, what: str, value: float, unit: str, limit: float) -> str:
    return f"{channel} {what} {value:.3g} {unit}, more than {limit:.3g},"


def _resolution(recording: Recording, channel: str) -> float:
    """Return the smallest difference between two values of a channel, in its unit."""
    sensor, axis = channel.split("_")
    samples = getattr(recording, sensor)[:, "xyz".index(axis)]
    values = np.unique(samples[:_RESOLUTION_SAMPLES])
    if len(values) == 1 and np.ptp(samples) == 0:
        raise DataError(
            f"{channel} reads {values[0]:.6g} {UNITS[sensor]} in every sample: "
            "there is no noise to measure; choose a finer range, or check the wiring"
        )
    return float(np.diff(values).min()) if len(values) > 1 else 0.0


def _warn_of_temperature(recording: Recording, blocks: RestBlocks) -> None:
    if recording.temperature is None:
        return
    sums = np.add.reduceat(recording.temperature, blocks.first)
    means = sums / np.diff(np.append(blocks.first, len(recording)))
    low, high = float(means.min()), float(means.max())
    if high - low > MAX_TEMPERATURE_CHANGE:
        _warn(
            recording.name,
            f"the temperature moves from {low:.1f} to {high:.1f} degrees Celsius: the drift that "
            "follows it counts as bias walk; let the sensor warm up for half an hour, and keep "
            "draughts and sun away",
        )


def _warn(name: str, text: str) -> None:
    """Warn the caller of `footnav.allan`."""
    warnings.warn(f"{name}: {text}" if name else text, FootnavWarning, stacklevel=5)
