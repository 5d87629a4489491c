"""The rests of a recording from which sensors are calibrated.

The test is that of Tedaldi et al. 2014, section V-A: the variance over a window, against a multiple
of that in the rest at the start.  The gyroscope is tested as well, the windows are consecutive
blocks, and the multiple is fixed: the paper chooses the one with the smallest residual, which
favours multiples that leave few rests.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footnav.errors import DataError
from footnav.recording import Floats, Recording
from footnav.rest_detection import (
    CALIBRATION,
    CALIBRATION_POSES,
    UNITS,
    RestBlocks,
    RestDetector,
    RestLimits,
    detect_rest,
)

MULTIPLE = 4.0
"""Multiple of the standard deviation in the rest at the start beyond which the sensor moves."""

MIN_STD = 0.02
"""Least standard deviation that is multiplied, as a part of that in `CALIBRATION_POSES`: a sensor
without noise still has rounding."""

BLOCK = 0.25
"""Length of the means, s, from which the noise of a mean is estimated: longer than the impulse
response of any low-pass filter."""


@dataclass(frozen=True, slots=True)
class Rests:
    """The rests of one recording, in order; k of them.

    Attributes
    ----------
    start, stop : ndarray, shape (k,)
        First sample of each, and the one after its last.
    accel, gyro : ndarray, shape (k, 3)
        Means, m/s² and rad/s.
    accel_std, gyro_std : ndarray, shape (k,)
        Standard deviation of one component of each mean, m/s² and rad/s.
    temperature : ndarray, shape (k,), optional
        Means, degrees Celsius.
    """

    start: NDArray[np.intp]
    stop: NDArray[np.intp]
    accel: Floats
    gyro: Floats
    accel_std: Floats
    gyro_std: Floats
    temperature: Floats | None

    def __len__(self) -> int:
        """Return the number of rests."""
        return len(self.start)


def find_rests(recording: Recording, initial: float = 2.0) -> Rests:
    """Find the rests of a recording in many poses.

    Parameters
    ----------
    recording : Recording
        Starts at rest.
    initial : float
        Length of the rest at the start, s, from which the limits are scaled.

    Returns
    -------
    Rests
        Each without its first and last block, which may hold the end of a turn.

    Raises
    ------
    DataError
        The recording does not start at rest; the message names the axis, the value and the limit.
    """
    first = int(np.searchsorted(recording.t, recording.t[0] + initial, side="right"))
    check_rest(recording, 0, first)
    limits = _scaled_limits(recording, first)
    blocks = detect_rest(recording, limits)
    starts, stops = [], []
    for rest in blocks.rests():
        rows = blocks.first[rest.start], blocks.last[rest.stop - 1]
        if recording.t[rows[1]] - recording.t[rows[0]] >= limits.min_duration:
            starts.append(blocks.last[rest.start])
            stops.append(blocks.first[rest.stop - 1] + 1)
    return _describe(recording, np.array(starts, dtype=np.intp), np.array(stops, dtype=np.intp))


def _scaled_limits(recording: Recording, stop: int) -> RestLimits:
    """Return `CALIBRATION_POSES` for the noise in the samples before `stop`, which are at rest."""
    blocks = _blocks_of_rest(recording, CALIBRATION_POSES, slice(0, stop))
    limits = {}
    for sensor in UNITS:
        std = float(np.median(np.linalg.norm(getattr(blocks, f"{sensor}_std"), axis=1)))
        limits[f"{sensor}_std"] = MULTIPLE * max(std, MIN_STD * CALIBRATION_POSES.std(sensor))
    return dataclasses.replace(CALIBRATION_POSES, **limits)


def _blocks_of_rest(recording: Recording, limits: RestLimits, rows: slice) -> RestBlocks:
    """Return the blocks of a part of a recording, whose first row is their row 0."""
    detector = RestDetector(limits, recording.rate_hz)
    return detector.push_block(recording.t[rows], recording.accel[rows], recording.gyro[rows])


def check_rest(recording: Recording, start: int = 0, stop: int | None = None) -> None:
    """Raise DataError if a stretch of a recording is not at rest.

    Parameters
    ----------
    recording : Recording
        The recording.
    start, stop : int
        First sample of the stretch, and the one after its last; the end of the recording unless
        given.

    Raises
    ------
    DataError
        The standard deviation of an axis, or the change of its mean, is beyond its limit, or
        samples are missing; the message gives axis, time, value and limit.
    """
    stop = len(recording) if stop is None else stop
    name = recording.name or "the recording"
    needed = round(CALIBRATION.min_duration * recording.rate_hz)
    if stop - start < needed:
        raise DataError(
            f"{name}: {stop - start} samples of rest are too few; {needed}, a second, are needed"
        )
    blocks = _blocks_of_rest(recording, CALIBRATION, slice(start, stop))
    if not blocks.at_rest.all():
        moving = int(blocks.at_rest.argmin())
        motion = _motion(blocks, moving, recording.t[start + blocks.first[moving]])
        raise DataError(
            f"{name}: not at rest: {motion}; lay the sensor down, do not hold it, "
            "and do not touch the table"
        )


def _motion(blocks: RestBlocks, block: int, t: float) -> str:
    """Return the first limit of `CALIBRATION` that the block at time `t` exceeds."""
    for sensor, unit in UNITS.items():
        std, drift = (getattr(blocks, f"{sensor}_{what}")[block] for what in ("std", "drift"))
        for what, values, value, limit in (
            ("scatters by", std, std.max(), CALIBRATION.std(sensor)),
            ("changes by", drift, np.linalg.norm(drift), CALIBRATION.drift(sensor)),
        ):
            if value > limit:
                axis = "xyz"[int(np.abs(values).argmax())]
                return (
                    f"{sensor}_{axis} {what} {value:.2g} {unit} at {t:.2f} s, more than {limit:g}"
                )
    return f"samples are missing at {t:.2f} s"


def pooled(rests: Sequence[Rests]) -> Rests:
    """Join the rests of several recordings; `start` and `stop` are rows of each recording."""
    join = {name: np.concatenate([getattr(each, name) for each in rests]) for name in _ARRAYS}
    celsius = [each.temperature for each in rests]
    known = [column for column in celsius if column is not None]
    return Rests(**join, temperature=np.concatenate(known) if len(known) == len(celsius) else None)


_ARRAYS = ("start", "stop", "accel", "gyro", "accel_std", "gyro_std")


def _describe(recording: Recording, start: NDArray[np.intp], stop: NDArray[np.intp]) -> Rests:
    pieces = [slice(a, b) for a, b in zip(start, stop, strict=True)]
    celsius = recording.temperature
    return Rests(
        start=start,
        stop=stop,
        accel=_means(recording.accel, pieces),
        gyro=_means(recording.gyro, pieces),
        accel_std=_std_of_means(recording, recording.accel, pieces),
        gyro_std=_std_of_means(recording, recording.gyro, pieces),
        temperature=None
        if celsius is None
        else np.array([celsius[piece].mean() for piece in pieces]),
    )


def _means(samples: Floats, pieces: list[slice]) -> Floats:
    return np.array([samples[piece].mean(axis=0) for piece in pieces]).reshape(-1, 3)


def _std_of_means(recording: Recording, samples: Floats, pieces: list[slice]) -> Floats:
    """Return the standard deviation of one component of the mean of each rest, from all blocks."""
    length = max(1, round(BLOCK * recording.rate_hz))
    blocks = [_blocks(samples[piece], length).mean(axis=1) for piece in pieces]
    spare = sum(len(block) - 1 for block in blocks)
    if spare < 1:
        return np.zeros(len(pieces))
    variance = sum(float(np.square(block - block.mean(axis=0)).sum()) for block in blocks) / (
        3 * spare
    )
    return np.sqrt(variance / np.array([len(block) for block in blocks]))


def _blocks(samples: Floats, length: int) -> Floats:
    """Divide samples into blocks of `length`, shape (blocks, length, 3), without the remainder."""
    return samples[: len(samples) // length * length].reshape(-1, length, 3)
