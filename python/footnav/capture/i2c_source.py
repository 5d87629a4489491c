"""An MPU6050 on the I2C bus of a Raspberry Pi or another Linux machine.

The chip writes every sample into a FIFO of 1024 bytes, by its own clock; the times at which the
host reads it do not affect the samples.  A full FIFO drops its oldest bytes, and the rest no longer
starts with a sample, so all of it is discarded and counted.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from footnav.capture.block import Block
from footnav.capture.clock import HostedClock
from footnav.capture.i2c_chip import ADDRESSES, FIFO_BYTES, Bus, Mpu6050
from footnav.capture.silence import Silence
from footnav.capture.source import CloseOnExit, LossCounters
from footnav.errors import ConfigError, DataError
from footnav.mpu6050 import SAMPLE_REGISTERS, Setup
from footnav.optional import require
from footnav.recording import Floats

if TYPE_CHECKING:
    from typing_extensions import Self

_POLL_INTERVAL = 0.02
"""s between two reads of the FIFO, which holds 73 samples: 0.37 s at 200 Hz."""

_MAX_SILENCE = 1.0
"""Maximum time without samples, s."""

_RATE_SIGMA = 0.02


class I2cSource(CloseOnExit):
    """An MPU6050 on an I2C bus, read through its FIFO; a `footnav.capture.Source`.

    Parameters
    ----------
    bus : Bus
        An open bus; `I2cSource.open` opens one.
    setup : Setup, optional
        Settings of the chip.
    address : int
        0x68, or 0x69 with the pin AD0 high.
    name : str
        Name of the bus in messages.
    clock : callable
        The host's time, s; monotonic.
    sleep : callable
        Sleeps for a time in s.

    Raises
    ------
    ConfigError
        The chip cannot have the address.
    DataError
        No chip answers, it is another one, or its registers do not hold the settings.
    """

    name: str
    losses: LossCounters

    def __init__(
        self,
        bus: Bus,
        setup: Setup | None = None,
        address: int = ADDRESSES[0],
        name: str = "I2C bus",
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.name = name
        self.losses = LossCounters()
        self._bus = bus
        self._setup = setup or Setup()
        self._chip = Mpu6050(bus, address, name)
        self._chip.configure(self._setup, sleep)
        self._now, self._sleep = clock, sleep
        # The FIFO is read at any time between two samples.
        self._clock = HostedClock(_RATE_SIGMA, latency=self._interval)
        self._silence = Silence()
        self._elapsed = self._t = 0.0
        self._aligned = self._follows = False

    @classmethod
    def open(cls, bus: int, setup: Setup | None = None, address: int = ADDRESSES[0]) -> Self:
        """Open a bus and set the chip up.

        Parameters
        ----------
        bus : int
            Its number: 1 on a Raspberry Pi, for /dev/i2c-1.
        setup : Setup, optional
            Settings of the chip.
        address : int
            0x68, or 0x69 with the pin AD0 high.

        Returns
        -------
        I2cSource
            To be closed after use, or used in a `with` statement.

        Raises
        ------
        ConfigError
            smbus2 is missing, or the chip does not have a setting.
        DataError
            The bus cannot be opened, no chip answers, or it is another one.
        """
        smbus2 = require("smbus2", "smbus2", ConfigError)
        try:
            opened = smbus2.SMBus(bus)
        except OSError as error:
            raise DataError(
                f"/dev/i2c-{bus} cannot be opened: {error.strerror}; switch I2C on (raspi-config, "
                "interface options), "
                "and join the group i2c"
            ) from None
        try:
            return cls(opened, setup, address, name=f"/dev/i2c-{bus}")
        except BaseException:
            opened.close()
            raise

    def close(self) -> None:
        """Close the bus; the chip continues to sample."""
        self._bus.close()

    def read(self) -> list[Block]:
        """Return the samples in the FIFO; after an empty read, wait for `_POLL_INTERVAL`.

        Returns
        -------
        list of Block
            One block or none.

        Raises
        ------
        DataError
            The chip did not answer, or gave no samples, for a second.
        """
        try:
            counts, host = self._read_fifo()
        except OSError as error:
            self._skip(error)
            return []
        if not counts:
            self._check_alive(
                "the chip answers, but takes no samples; did its supply fail for a moment?"
            )
            self._sleep(_POLL_INTERVAL)
            return []
        self._silence.reset()
        return [Block.from_counts(self._stamps(len(counts), host), counts, self._setup)]

    def _read_fifo(self) -> tuple[list[tuple[int, ...]], float]:
        """Return the samples in the FIFO, and the host's time of the last."""
        if not self._aligned:
            self._begin()
        held, host = self._chip.fifo_bytes(), self._now()
        data = self._chip.read_fifo(held // SAMPLE_REGISTERS)
        # Checked last, so that an overflow during the read is detected.
        if self._chip.has_overflowed() or held >= FIFO_BYTES:
            self._count(overflows=1)
            self._check_alive(
                "its FIFO overflows repeatedly; lower the rate, or raise the clock of the bus"
            )
            self._begin()
            return [], host
        return list(struct.iter_unpack(">7h", data)), host

    def _begin(self) -> None:
        """Restart the FIFO at a sample, which does not continue those before."""
        self._aligned = self._follows = False
        self._chip.reset_fifo()
        self._aligned = True

    def _skip(self, error: OSError) -> None:
        """Continue after a failed transfer, which may have left half a sample in the FIFO."""
        self._aligned = False
        self._count(broken=1)
        self._check_alive(f"transfers fail: {error}; check the wires, and make them shorter")
        self._sleep(_POLL_INTERVAL)

    def _stamps(self, n: int, host: float) -> Floats:
        device: Floats = self._elapsed + self._interval * np.arange(1.0, n + 1)
        if self._follows or not self._elapsed:
            t = self._clock.stamps(device, host)
        else:
            t = self._clock.restart(device, host, self._interval)
            self._count(
                missing=max(round((t[0] - self._t) / (self._interval * self._clock.rate)) - 1, 0)
            )
        self._elapsed, self._t, self._follows = float(device[-1]), float(t[-1]), True
        return t

    @property
    def _interval(self) -> float:
        return 1 / self._setup.rate_hz

    def _count(self, **more: int) -> None:
        self.losses = self.losses.plus(**more)

    def _check_alive(self, reason: str) -> None:
        silence = self._silence.update(self._now())
        if silence > _MAX_SILENCE:
            raise DataError(f"{self.name}: no sample for {silence:.1f} s: {reason}")
