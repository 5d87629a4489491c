"""Whether a recording was made at rest, without a gap: what measurements of the sensor's own noise need."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footnav.config import Alignment
from footnav.errors import DataError, FootnavWarning
from footnav.recording import Floats, Recording

Mask = NDArray[np.bool_]

UNITS = {"accel": "m/s^2", "gyro": "rad/s"}

REST = {"accel": Alignment().rest_accel_std, "gyro": Alignment().rest_gyro_std}
"""Scatter that is no rest, however usual it is in the recording."""

UNEVEN = 0.8
"""Part of the median interval by which one may differ; stamps in whole milliseconds jitter by less."""

BLOCK = 1.0
"""s over which scatter and mean are taken."""

MOVED_SCATTER, MOVED_JUMP = 3.0, 15.0
"""Times the usual scatter of a block, and the usual step from its mean to the next, that noise does not reach."""

WARMING = 2.0
"""K by which the temperature may move."""

_STEP_SAMPLES = 100_000
"""Samples that are enough to see the resolution in."""


def check_even(t: Floats) -> None:
    """Refuse samples that are not evenly spaced.

    Parameters
    ----------
    t : ndarray, shape (n,)
        Stamps, s.

    Raises
    ------
    DataError
        An interval is far from the median one; the message names the first and the longest stretch
        without any.
    """
    intervals = np.diff(t)
    median = float(np.median(intervals[intervals > 0]))
    uneven = np.abs(intervals - median) > UNEVEN * median
    if uneven.any():
        row = int(uneven.argmax())
        start, end = _longest_run(~uneven)
        raise DataError(
            f"the stamps {t[row]:.3f} s and {t[row + 1]:.3f} s are {intervals[row]:.4g} s apart, where {median:.4g} s "
            f"are usual; {int(uneven.sum())} such interval(s) in all: the samples must be evenly spaced, so record "
            f"without losses, or take the longest stretch without one, span=({t[start]:.3f}, {t[end]:.3f})"
        )


def check_rest(recording: Recording) -> None:
    """Refuse a recording in which the sensor moved.

    Parameters
    ----------
    recording : Recording
        Evenly spaced samples, a second or more.

    Raises
    ------
    DataError
        A channel scatters or jumps as noise does not, or never changes; the message says when, and
        how long the sensor rested.

    Warns
    -----
    FootnavWarning
        The temperature moves, or the noise of a channel is below its resolution.
    """
    blocks = _Blocks.of(recording)
    findings: dict[int, str] = {}
    for channel in (f"{sensor}_{axis}" for sensor in UNITS for axis in "xyz"):
        findings = _movements(recording, channel, blocks) | findings
    if findings:
        raise DataError(_moved(recording.t, blocks, findings))
    _warn_of_warming(recording, blocks)


@dataclass(frozen=True, slots=True)
class _Blocks:
    """Rows at which the blocks of about a second start that a recording is divided into, and the row after the last."""

    edges: NDArray[np.intp]

    @classmethod
    def of(cls, recording: Recording) -> _Blocks:
        length = max(2, round(BLOCK * recording.rate_hz))
        return cls(np.linspace(0, len(recording), len(recording) // length + 1).astype(np.intp))

    def __len__(self) -> int:
        return len(self.edges) - 1

    def means(self, samples: Floats) -> Floats:
        means: Floats = np.add.reduceat(samples, self.edges[:-1]) / np.diff(self.edges)
        return means

    def scatter(self, samples: Floats) -> Floats:
        return np.sqrt(
            self.means((samples - np.repeat(self.means(samples), np.diff(self.edges))) ** 2)
        )


def _moved(t: Floats, blocks: _Blocks, findings: dict[int, str]) -> str:
    """Say when the sensor moved first, and how long it rested."""
    still = np.ones(len(blocks), dtype=bool)
    still[list(findings)] = False
    first, (start, end) = min(findings), _longest_run(still)
    rest = f", or take its longest rest, span=({t[blocks.edges[start]]:.3f}, {t[blocks.edges[end] - 1]:.3f})"
    return (
        f"{findings[first]} at {t[blocks.edges[first]]:.1f} s: the sensor was moved or touched, in {len(findings)} of "
        f"{len(blocks)} s; leave it alone{rest if still.any() else ''}"
    )


def _movements(recording: Recording, channel: str, blocks: _Blocks) -> dict[int, str]:
    """Say for each block in which a channel moved how it did."""
    sensor, _, axis = channel.partition("_")
    unit, samples = UNITS[sensor], getattr(recording, sensor)[:, "xyz".index(axis)]
    step = _step(channel, unit, samples)
    scatter, means = blocks.scatter(samples), blocks.means(samples)
    jump = np.abs(np.diff(means, prepend=means[0]))
    usual = float(np.median(scatter))
    if usual < step / 2:
        _warn(
            recording.name,
            f"{channel} scatters by {usual:.2g} {unit}, less than half of its resolution of {step:.2g}: its figures "
            "are those of the rounding; choose a finer range",
        )
    scatter_limit = min(REST[sensor], MOVED_SCATTER * max(usual, step))
    jump_limit = MOVED_JUMP * max(float(np.median(jump)), step)
    jumps = {
        int(k): _over(channel, "jumps", jump[k], unit, jump_limit)
        for k in np.flatnonzero(jump > jump_limit)
    }
    shakes = np.flatnonzero(scatter > scatter_limit)
    return jumps | {
        int(k): _over(channel, "scatters", scatter[k], unit, scatter_limit) for k in shakes
    }


def _over(channel: str, does: str, value: float, unit: str, limit: float) -> str:
    return f"{channel} {does} by {value:.3g} {unit}, more than {limit:.3g},"


def _step(channel: str, unit: str, samples: Floats) -> float:
    """Return the smallest step between the values of a channel: its resolution, if it has one."""
    values = np.unique(samples[:_STEP_SAMPLES])
    if len(values) == 1 and np.ptp(samples) == 0:
        raise DataError(
            f"{channel} reads {values[0]:.6g} {unit} in every sample: there is no noise to measure; "
            "choose a finer range, or check the wiring"
        )
    return float(np.diff(values).min()) if len(values) > 1 else 0.0


def _warn_of_warming(recording: Recording, blocks: _Blocks) -> None:
    if recording.temperature is None:
        return
    means = blocks.means(recording.temperature)
    low, high = float(means.min()), float(means.max())
    if high - low > WARMING:
        _warn(
            recording.name,
            f"the temperature moves from {low:.1f} to {high:.1f} degrees Celsius: the drift that follows it counts as "
            "bias walk; let the sensor warm up for half an hour, and keep draughts and sun away",
        )


def _warn(name: str, text: str) -> None:
    """Warn the caller of `footnav.allan`."""
    warnings.warn(f"{name}: {text}" if name else text, FootnavWarning, stacklevel=5)


def _longest_run(mask: Mask) -> tuple[int, int]:
    """Return where the longest run of True starts and where it has ended."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], mask, [False]))))
    starts, ends = edges[::2], edges[1::2]
    if not len(starts):
        return 0, 0
    longest = int((ends - starts).argmax())
    return int(starts[longest]), int(ends[longest])
