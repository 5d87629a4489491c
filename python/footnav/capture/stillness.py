"""Whether a sensor lies still, found as the samples come.

The samples are cut into windows of a fifth of a second; a window is still when no axis of the
accelerometer and no axis of the gyroscope moves about its mean.  The mean of a gyroscope is left
out, since a cheap one reads up to 20 deg/s at rest.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from footnav.capture.block import Block
from footnav.recording import Floats

WINDOW = 0.2
"""Length of a window, s."""

ACCEL_STILL, GYRO_STILL = 0.15, math.radians(1.0)
"""Standard deviations, m/s² and rad/s, three times the noise of an MPU6050 at 94 Hz and more; a hand trembles more."""

_LONGEST_GAP = WINDOW / 2
"""s; nobody knows what the sensor did in a longer gap."""


@dataclass(frozen=True, slots=True, eq=False)
class Window:
    """A fifth of a second.

    Attributes
    ----------
    duration : float
        s.
    still : bool
        Whether the sensor lay still.
    accel : ndarray of shape (3,)
        Mean specific force, m/s².
    """

    duration: float
    still: bool
    accel: Floats


class Stillness:
    """Cuts samples into windows, however they are cut into blocks."""

    def __init__(self) -> None:
        self._rows: list[tuple[float, Floats]] = []

    def feed(self, block: Block) -> Iterator[Window]:
        """Take the next samples in.

        Parameters
        ----------
        block : Block
            Samples.

        Yields
        ------
        Window
            Each that ended within `block`.
        """
        for t, row in zip(block.t.tolist(), np.hstack([block.accel, block.gyro]), strict=True):
            if self._rows and t - self._rows[0][0] >= WINDOW:
                yield self._close(t)
            self._rows.append((t, row))

    def _close(self, end: float) -> Window:
        """End the window before the sample at `end`, with which the next one begins."""
        t = np.array([*(t for t, _ in self._rows), end])
        samples = np.array([row for _, row in self._rows])
        self._rows = []
        spread = samples.std(axis=0)
        still = (
            spread[:3].max() < ACCEL_STILL
            and spread[3:].max() < GYRO_STILL
            and np.diff(t).max() <= _LONGEST_GAP
        )
        return Window(
            duration=float(t[-1] - t[0]), still=bool(still), accel=samples[:, :3].mean(axis=0)
        )
