"""Rest detection: whether a sensor is at rest, block by block, and the limits of each use.

The detector is that of the core (``rust/src/ins/rest.rs``), from which the alignment takes the rest
at the start, too.  A block is at rest if it has no gap, if no axis has a standard deviation beyond
its limit, and if the means do not drift away from those of the rest so far.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from footnav import _core
from footnav.recording import Floats

if TYPE_CHECKING:
    from footnav.config import Config
    from footnav.recording import Recording

Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]

UNITS = {"accel": "m/s^2", "gyro": "rad/s"}
"""Unit of the samples of each sensor."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RestLimits:
    """Limits within which a sensor counts as at rest; ``math.inf`` is no limit.

    Attributes
    ----------
    block : float
        Length of a block, s.
    max_span : float
        Longest time that the samples of a block may span, s; a longer one has a gap.
    min_duration : float
        Shortest rest, s.
    accel_std, gyro_std : float
        Greatest standard deviation of an axis within a block, m/s² and rad/s.
    accel_drift, gyro_drift : float
        Greatest difference between the mean vector of a block and that of the rest so far, m/s²
        and rad/s.
    """

    block: float
    max_span: float
    min_duration: float = 0.0
    accel_std: float
    gyro_std: float
    accel_drift: float = math.inf
    gyro_drift: float = math.inf

    def std(self, sensor: str) -> float:
        """Return the greatest standard deviation of ``"accel"`` or ``"gyro"``, m/s² or rad/s."""
        return self.accel_std if sensor == "accel" else self.gyro_std

    def drift(self, sensor: str) -> float:
        """Return the greatest drift of ``"accel"`` or ``"gyro"``, m/s² or rad/s."""
        return self.accel_drift if sensor == "accel" else self.gyro_drift


ALLAN = RestLimits(block=1.0, max_span=2.0, accel_std=0.25, gyro_std=0.06)
"""An Allan deviation.

The standard deviations are those of the alignment, an upper bound whatever is usual in the
recording.  The means may drift: the bias instability is to be measured.
"""

CALIBRATION = RestLimits(
    block=0.5,
    max_span=1.0,
    min_duration=1.0,
    accel_std=0.15,
    gyro_std=0.03,
    accel_drift=0.10,
    gyro_drift=0.01,
)
"""A calibration at rest, and the rest at the start of one in many poses.

The noisiest sensors on sale stay below the standard deviations; a hand, however steady, does not
stay below the drifts.
"""

CALIBRATION_POSES = RestLimits(
    block=0.25, max_span=0.5, min_duration=1.4, accel_std=0.15, gyro_std=0.03
)
"""The rests of a calibration in many poses; the standard deviations are scaled to the noise.

A turn of the sensor lasts longer than a block.  Six blocks are the least, since the first and the
last one may hold the end of a turn.  The means may drift: they follow the temperature.
"""

CAPTURE = RestLimits(block=0.2, max_span=0.25, accel_std=0.15, gyro_std=math.radians(1.0))
"""A sensor that a person lays down.

The standard deviations are three times the noise of an MPU6050 at 94 Hz and more; a hand trembles
more.  The means may drift: the guide compares the directions of gravity itself.
"""


def alignment_limits(config: Config) -> RestLimits:
    """Return the limits of the rest at the start of a track.

    Parameters
    ----------
    config : Config
        Settings, of which `footnav.config.Alignment` gives the limits.

    Returns
    -------
    RestLimits
        Those with which `footnav.track` decides whether the recording starts in motion.
    """
    return RestLimits(**_core.alignment_rest_limits(config.to_json()))


@dataclass(frozen=True, slots=True, eq=False)
class RestBlocks:
    """Consecutive blocks of samples; k of them.

    Attributes
    ----------
    first, last : ndarray of int, shape (k,)
        Rows that each block spans: from the last sample of the block before, which is in none of
        its statistics, to its own last sample.
    at_rest : ndarray of bool, shape (k,)
        Whether the sensor is at rest.
    accel, gyro : ndarray, shape (k, 3)
        Means, m/s² and rad/s.
    accel_std, gyro_std : ndarray, shape (k, 3)
        Standard deviations, m/s² and rad/s.
    accel_drift, gyro_drift : ndarray, shape (k, 3)
        Means less those of the rest so far, m/s² and rad/s; zero at the beginning of a rest.
    """

    first: Rows
    last: Rows
    at_rest: Mask
    accel: Floats
    gyro: Floats
    accel_std: Floats
    gyro_std: Floats
    accel_drift: Floats
    gyro_drift: Floats

    def __len__(self) -> int:
        """Return the number of blocks."""
        return len(self.first)

    def __add__(self, later: RestBlocks) -> RestBlocks:
        """Return these blocks and those of `later`."""
        both = ((getattr(self, f.name), getattr(later, f.name)) for f in dataclasses.fields(self))
        return RestBlocks(*map(np.concatenate, both))

    def rests(self) -> list[slice]:
        """Return the blocks of each rest, in order; a gap or a drift separates two rests."""
        starts, stops = runs(self.at_rest)
        return [slice(start, stop) for start, stop in zip(starts, stops, strict=True)]


class RestDetector:
    """Decides block by block whether a sensor is at rest, as the samples arrive.

    Parameters
    ----------
    limits : RestLimits
        Limits of rest.
    rate_hz : float
        Sampling rate, Hz.
    """

    def __init__(self, limits: RestLimits, rate_hz: float) -> None:
        self._core = _core.RestDetector(dataclasses.asdict(limits), rate_hz)

    def push_block(self, t: Floats, accel: Floats, gyro: Floats) -> RestBlocks:
        """Add the next samples.

        Parameters
        ----------
        t : ndarray, shape (n,)
            Stamps, s; a repeated one is left out.
        accel, gyro : ndarray, shape (n, 3)
            Calibrated specific force and angular rate, m/s² and rad/s.

        Returns
        -------
        RestBlocks
            Those that the samples complete; rows count from the first sample of all.
        """
        return RestBlocks(**self._core.push_block(t, accel, gyro))

    def finish(self) -> RestBlocks:
        """Return the incomplete block at the end, if it has a sample."""
        return RestBlocks(**self._core.finish())


def detect_rest(recording: Recording, limits: RestLimits) -> RestBlocks:
    """Decide block by block whether the sensor is at rest.

    Parameters
    ----------
    recording : Recording
        Calibrated samples.
    limits : RestLimits
        Limits of rest.

    Returns
    -------
    RestBlocks
        All complete blocks.
    """
    detector = RestDetector(limits, recording.rate_hz)
    return detector.push_block(recording.t, recording.accel, recording.gyro)


def runs(mask: Mask) -> tuple[Rows, Rows]:
    """Return where each run of True starts, and the index after its last element.

    Parameters
    ----------
    mask : ndarray of bool, shape (n,)
        Any mask.

    Returns
    -------
    starts, stops : ndarray of int, shape (k,)
        In order.
    """
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False]))))
    return edges[::2], edges[1::2]


def longest_run(mask: Mask) -> slice:
    """Return the longest run of True, the first of several; empty where there is none."""
    starts, stops = runs(mask)
    if not len(starts):
        return slice(0, 0)
    longest = int((stops - starts).argmax())
    return slice(int(starts[longest]), int(stops[longest]))
