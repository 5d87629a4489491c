"""Rests in a recording.

The detector is that of Tedaldi et al. 2014, section V-A: the variance over a sliding window,
against a multiple of that in the rest at the start.  Here the gyroscope is tested, too, and the
multiple is fixed: the paper's choice by the smallest residual favours multiples with few rests.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footnav.errors import DataError
from footnav.recording import Floats, Recording

WINDOW = 0.5
"""Window of the variance, s: a turn of the sensor lasts longer."""

MULTIPLE = 4.0
"""Multiple of the standard deviation in the rest at the start beyond which the sensor moves."""

SHORTEST = 1.0
"""Minimum duration of a rest, s: the mean of a shorter one is too noisy."""

BLOCK = 0.25
"""Length of the block means, s, whose scatter gives the noise of a mean: longer than any low-pass
filter.
"""

LIMITS = {"accel": (0.15, 0.10), "gyro": (0.03, 0.01)}
"""Limits of a rest, m/s² and rad/s: standard deviation, and change of the mean over `WINDOW`.

The noisiest sensors are below the first; a sensor in a hand exceeds the second.
"""

UNITS = {"accel": "m/s^2", "gyro": "rad/s"}


@dataclass(frozen=True, slots=True)
class Rests:
    """The times at rest of one recording, in order; k of them.

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
    """Find the times at rest.

    Parameters
    ----------
    recording : Recording
        Starts at rest.
    initial : float
        Length of the rest at the start that the limits are scaled from, s.

    Returns
    -------
    Rests
        Each at least `SHORTEST` long, without half a window at both ends.

    Raises
    ------
    DataError
        The recording does not start at rest; the message names the axis, the value and the limit.
    """
    first = int(np.searchsorted(recording.t, recording.t[0] + initial, side="right"))
    check_rest(recording, 0, first)
    length = max(3, round(WINDOW * recording.rate_hz))
    still = np.ones(len(recording), dtype=bool)
    for label in ("accel", "gyro"):
        scatter = _scatter(getattr(recording, label), length)
        typical = max(float(np.median(scatter[:first])), 0.02 * LIMITS[label][0])
        still &= scatter < MULTIPLE * typical
    edges = np.flatnonzero(np.diff(np.concatenate(([False], still, [False]))))
    start, stop = edges[::2], edges[1::2]
    long = recording.t[stop - 1] - recording.t[start] >= SHORTEST
    return _describe(recording, start[long], stop[long])


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
        An axis scatters or drifts too much; the message names it, the time, the value and the
        limit.
    """
    stop = len(recording) if stop is None else stop
    name = recording.name or "the recording"
    length = max(3, round(WINDOW * recording.rate_hz))
    if stop - start < 2 * length:
        raise DataError(
            f"{name}: {stop - start} samples of rest are too few; {2 * length}, a second, are "
            "needed"
        )
    for label, (noise, drift) in LIMITS.items():
        blocks = _blocks(getattr(recording, label)[start:stop], length)
        scatter = blocks.std(axis=1)
        change = np.abs(blocks.mean(axis=1) - np.median(blocks.mean(axis=1), axis=0))
        for values, limit, what in ((scatter, noise, "scatters by"), (change, drift, "changes by")):
            block, axis = (int(k) for k in np.unravel_index(np.argmax(values), values.shape))
            if values[block, axis] > limit:
                at = recording.t[start + block * length]
                raise DataError(
                    f"{name}: not at rest: {label}_{'xyz'[axis]} {what} {values[block, axis]:.3g} "
                    f"{UNITS[label]} at "
                    f"{at:.2f} s, more than {limit:g}; lay the sensor down, do not hold it, and "
                    "do not touch the table"
                )


def pooled(rests: Sequence[Rests]) -> Rests:
    """Join the rests of several recordings.

    `start` and `stop` then count in each recording of its own.
    """
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
    """Return the standard deviation of a component of each mean, from the scatter of all blocks."""
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
    """Cut samples into blocks of `length`, shape (blocks, length, 3), without the rest of them."""
    return samples[: len(samples) // length * length].reshape(-1, length, 3)


def _scatter(samples: Floats, length: int) -> Floats:
    """Return the standard deviation of the vector over the window around each sample, shape (n,).

    Inf at both ends.
    """
    centred = samples - samples.mean(axis=0)
    sums = np.concatenate(([np.zeros(6)], np.cumsum(np.hstack([centred, centred**2]), axis=0)))
    mean, square = np.hsplit((sums[length:] - sums[:-length]) / length, 2)
    scatter = np.full(len(samples), np.inf)
    inside = slice(length // 2, length // 2 + len(mean))
    scatter[inside] = np.sqrt(np.maximum(square - mean**2, 0.0).sum(axis=1))
    return scatter
