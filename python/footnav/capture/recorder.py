"""Recording and tracking of a live sensor."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from footnav.capture.block import Block
from footnav.capture.source import Source, stream
from footnav.errors import DataError
from footnav.mpu6050 import Setup
from footnav.recording import Recording

if TYPE_CHECKING:
    from footnav.navigator import Navigator
    from footnav.trajectory import Trajectory

_VALIDATED_AFTER = 1.0
"""s after which the samples are validated, so that a wrong scale is found early."""


class Recorder:
    """Collects the blocks of a recording.

    Parameters
    ----------
    name : str
        Name of the source in messages and of the recording.

    Attributes
    ----------
    samples : int
        Number of samples so far.
    """

    name: str
    samples: int

    def __init__(self, name: str) -> None:
        self.name = name
        self.samples = 0
        self._blocks: list[Block] = []
        self._validated = False

    @property
    def duration(self) -> float:
        """Time from the first to the newest sample, s."""
        return float(self._blocks[-1].t[-1] - self._blocks[0].t[0]) if self._blocks else 0.0

    @property
    def setup(self) -> Setup | None:
        """Settings of the chip; None before the first block."""
        return self._blocks[0].setup if self._blocks else None

    def add(self, block: Block) -> None:
        """Append the next block.

        Parameters
        ----------
        block : Block
            At least one sample, later than all before.

        Raises
        ------
        DataError
            The settings of the chip changed, or the first second is not a valid recording.
        """
        if self.setup not in (None, block.setup):
            raise DataError(
                f"{self.name}: the settings of the chip changed from {self.setup} to "
                f"{block.setup}; restart the capture"
            )
        self._blocks.append(block)
        self.samples += len(block)
        if not self._validated and self.duration >= _VALIDATED_AFTER:
            self._validated = True
            self.recording()

    def recording(self) -> Recording:
        """Make a recording of all blocks.

        Returns
        -------
        Recording
            With the temperature and the full scales.

        Raises
        ------
        DataError
            There are fewer than two samples, or they are not a valid recording.
        """
        if self.samples < 2:
            raise DataError(
                f"{self.name}: {self.samples} samples arrived; a recording needs at least 2"
            )
        blocks, setup = self._blocks, self._blocks[0].setup
        return Recording(
            t=np.concatenate([block.t for block in blocks]),
            accel=np.concatenate([block.accel for block in blocks]),
            gyro=np.concatenate([block.gyro for block in blocks]),
            temperature=np.concatenate([block.temperature for block in blocks]),
            name=self.name,
            accel_range=setup.accel_range,
            gyro_range=setup.gyro_range,
        )


def record(
    source: Source, seconds: float, on_block: Callable[[Block], None] | None = None
) -> Recording:
    """Record from a live sensor.

    Parameters
    ----------
    source : Source
        The sensor.
    seconds : float
        Minimum duration by the stamps of the samples; the recording ends with a whole block.
    on_block : callable, optional
        Called with every block.

    Returns
    -------
    Recording
        With the name of the source, temperature and full scales.

    Raises
    ------
    DataError
        The sensor cannot be read, gave no samples for too long, or gave invalid ones.
    """
    recorder = Recorder(source.name)
    for block in stream(source):
        recorder.add(block)
        if on_block is not None:
            on_block(block)
        if recorder.duration >= seconds:
            break
    return recorder.recording()


def track_live(source: Source, navigator: Navigator) -> Iterator[Trajectory]:
    """Track a live sensor, without end.

    Parameters
    ----------
    source : Source
        The sensor.
    navigator : Navigator
        Navigator for the rate of the sensor; `Navigator.flush` gives its last states after the
        walk.

    Yields
    ------
    Trajectory
        The states that each block outputs, possibly none.

    Raises
    ------
    DataError
        The sensor cannot be read, or gave no samples for too long.
    NumericalError
        The filter failed.
    """
    for block in stream(source):
        yield navigator.push_block(block.t, block.accel, block.gyro)
