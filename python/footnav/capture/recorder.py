"""From a live sensor to a recording, or straight into a navigator."""

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

_FIRST_LOOK = 1.0
"""s after which the samples are checked as a recording, so that nobody walks with a sensor whose scale is wrong."""


class Recorder:
    """Gathers blocks until they are made a recording.

    Parameters
    ----------
    name : str
        What messages, and later the recording, call the source.

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
        self._looked = False

    @property
    def duration(self) -> float:
        """Time from the first to the newest sample, s."""
        return float(self._blocks[-1].t[-1] - self._blocks[0].t[0]) if self._blocks else 0.0

    @property
    def setup(self) -> Setup | None:
        """How the chip is set; None before the first block."""
        return self._blocks[0].setup if self._blocks else None

    def add(self, block: Block) -> None:
        """Take the next block in.

        Parameters
        ----------
        block : Block
            At least one sample, later than all before.

        Raises
        ------
        DataError
            The chip was set otherwise than before, or the first second cannot be a recording of a
            shoe.
        """
        if self.setup not in (None, block.setup):
            raise DataError(
                f"{self.name}: the chip was set to {self.setup}, and now is to {block.setup}; capture anew"
            )
        self._blocks.append(block)
        self.samples += len(block)
        if not self._looked and self.duration >= _FIRST_LOOK:
            self._looked = True
            self.recording()

    def recording(self) -> Recording:
        """Make a recording of all that came.

        Returns
        -------
        Recording
            With the temperature and the full scales.

        Raises
        ------
        DataError
            There are fewer than two samples, or they cannot be those of a shoe.
        """
        if self.samples < 2:
            raise DataError(
                f"{self.name}: {self.samples} samples came; at least 2 make a recording"
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
    source: Source, seconds: float, watch: Callable[[Block], None] | None = None
) -> Recording:
    """Record from a live sensor.

    Parameters
    ----------
    source : Source
        The sensor.
    seconds : float
        How long, by the stamps of the samples; whole blocks, so a little longer.
    watch : callable, optional
        Sees every block as it comes.

    Returns
    -------
    Recording
        Named as the source, with the temperature and the full scales.

    Raises
    ------
    DataError
        The sensor cannot be read, has been silent for too long, or its samples cannot be those of a
        shoe.
    """
    recorder = Recorder(source.name)
    for block in stream(source):
        recorder.add(block)
        if watch is not None:
            watch(block)
        if recorder.duration >= seconds:
            break
    return recorder.recording()


def follow(source: Source, navigator: Navigator) -> Iterator[Trajectory]:
    """Track a live sensor, without end.

    Parameters
    ----------
    source : Source
        The sensor.
    navigator : Navigator
        Built for the rate of the sensor; `Navigator.flush` gives its last states once the walk is
        over.

    Yields
    ------
    Trajectory
        The states that came out with each block, possibly none.

    Raises
    ------
    DataError
        The sensor cannot be read, or has been silent for too long.
    NumericalError
        The filter cannot go on.
    """
    for block in stream(source):
        yield navigator.push_block(block.t, block.accel, block.gyro)
