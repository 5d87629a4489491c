"""An MPU6050 on the I2C bus of a Raspberry Pi or another Linux machine.

The chip writes every sample into a FIFO of 1024 bytes, by its own clock; the host empties it now and then, and no
sample depends on when it does.  A FIFO that is full drops its oldest bytes, and what is left no longer begins with a
sample, so it is thrown away whole, and counted.

References
----------
InvenSense, "MPU-6000 and MPU-6050 Register Map and Descriptions", RM-MPU-6000A-00, revision 4.2, 2013.
"""

from __future__ import annotations

import contextlib
import struct
import time
from collections.abc import Callable
from types import TracebackType
from typing import TYPE_CHECKING, Protocol

import numpy as np

from footnav.capture.clock import HostedClock
from footnav.capture.library import require
from footnav.capture.line import MPU6050_ID
from footnav.capture.mpu6050 import SAMPLE_REGISTERS, Block, Setup
from footnav.capture.silence import Silence
from footnav.capture.source import Losses
from footnav.errors import ConfigError, DataError
from footnav.recording import Floats

if TYPE_CHECKING:
    from typing_extensions import Self

ADDRESSES = (0x68, 0x69)
"""With the pin AD0 low, as most boards leave it, and high."""

SMPLRT_DIV, FIFO_EN, INT_ENABLE, INT_STATUS = 0x19, 0x23, 0x38, 0x3A
USER_CTRL, PWR_MGMT_1, FIFO_COUNT, FIFO_R_W, WHO_AM_I = 0x6A, 0x6B, 0x72, 0x74, 0x75

DEVICE_RESET, CLOCK_OF_GYRO = 0x80, 0x01
"""PWR_MGMT_1: everything as after power-on; awake, on the gyroscope's oscillator, which is steadier than the other."""

ALL_SENSORS = 0xF8
"""FIFO_EN: thermometer, three gyroscopes, accelerometer."""

FIFO_ON, FIFO_RESET = 0x40, 0x04
"""USER_CTRL."""

FIFO_OVERFLOW = 0x10
"""INT_ENABLE and INT_STATUS."""

FIFO_BYTES = 1024

_BURST = 2
"""Samples that fit into one block of the Linux SMBus interface, 32 bytes."""

_RESET_TIME, _START_TIME = 0.1, 0.05
"""s; the gyroscope's oscillator takes up to 30 ms to start."""

_POLL = 0.02
"""s between two looks at the FIFO, which holds 73 samples: 0.37 s at 200 Hz."""

_PATIENCE = 1.0
"""Longest silence, s."""

_RATE_SIGMA = 0.02

_OTHER_CHIPS = {
    0x19: "an MPU6886",
    0x12: "an ICM-20602",
    0x70: "an MPU6500, or a copy of it",
    0x71: "an MPU9250",
    0x72: "a copy of the MPU6050",
    0x73: "an MPU9255",
    0x98: "a copy of the MPU6050",
    0x00: "nothing, as with a short circuit to ground",
    0xFF: "nothing, as with a loose wire",
}


class Bus(Protocol):
    """What is used of `smbus2.SMBus`."""

    def read_byte_data(self, i2c_addr: int, register: int) -> int:
        """Read one register."""
        ...

    def write_byte_data(self, i2c_addr: int, register: int, value: int) -> None:
        """Write one register."""
        ...

    def read_i2c_block_data(self, i2c_addr: int, register: int, length: int) -> list[int]:
        """Read up to 32 bytes from a register on."""
        ...

    def close(self) -> None:
        """Release the bus."""
        ...


def check_address(address: int) -> None:
    """Raise ConfigError for an address that an MPU6050 cannot have."""
    if address not in ADDRESSES:
        raise ConfigError(f"address is {address:#04x}; an MPU6050 has 0x68, or 0x69 with AD0 high")


class I2cSource:
    """An MPU6050 on an I2C bus, read through its FIFO; a `footnav.capture.Source`.

    Parameters
    ----------
    bus : Bus
        An open bus; `I2cSource.open` opens one.
    setup : Setup, optional
        How to set the chip.
    address : int
        0x68, or 0x69 with the pin AD0 high.
    name : str
        What messages call the bus.
    clock : callable
        The host's time, s; monotonic.
    sleep : callable
        Waits for a time in s.

    Raises
    ------
    ConfigError
        The address is none that the chip can have.
    DataError
        No chip answers, it is another one, or it does not keep its settings.
    """

    name: str
    losses: Losses

    def __init__(
        self,
        bus: Bus,
        setup: Setup | None = None,
        address: int = ADDRESSES[0],
        name: str = "I2C bus",
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        check_address(address)
        self.name = name
        self.losses = Losses()
        self._bus, self._address = bus, address
        self._setup = setup or Setup()
        self._now, self._sleep = clock, sleep
        interval = 1 / self._setup.rate_hz
        # A FIFO is looked at anywhere between two samples.
        self._clock = HostedClock(_RATE_SIGMA, lateness=interval)
        self._elapsed = self._t = 0.0
        self._fresh = False
        self._check_chip()
        self._configure()
        self._empty()
        self._silence = Silence()

    @classmethod
    def open(cls, bus: int, setup: Setup | None = None, address: int = ADDRESSES[0]) -> Self:
        """Open a bus and set the chip up.

        Parameters
        ----------
        bus : int
            Its number: 1 on a Raspberry Pi, for /dev/i2c-1.
        setup : Setup, optional
            How to set the chip.
        address : int
            0x68, or 0x69 with the pin AD0 high.

        Returns
        -------
        I2cSource
            To be closed after use, or used in a `with` statement.

        Raises
        ------
        ConfigError
            smbus2 is missing, or a setting is none that the chip has.
        DataError
            The bus cannot be opened, no chip answers, or it is another one.
        """
        smbus2 = require("smbus2", "an I2C bus, which Linux has,", "smbus2")
        try:
            opened = smbus2.SMBus(bus)
        except OSError as error:
            raise DataError(
                f"/dev/i2c-{bus} cannot be opened: {error.strerror}; switch I2C on (raspi-config, interface options), "
                "and join the group i2c"
            ) from None
        try:
            return cls(opened, setup, address, name=f"/dev/i2c-{bus}")
        except BaseException:
            opened.close()
            raise

    def __enter__(self) -> Self:
        """Return the source."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the bus."""
        self.close()

    def close(self) -> None:
        """Close the bus; the chip goes on sampling."""
        self._bus.close()

    def read(self) -> list[Block]:
        """Return what the FIFO holds, or nothing for a look that found none; looks `_POLL` apart.

        Returns
        -------
        list of Block
            One block or none.

        Raises
        ------
        DataError
            The chip has not answered, or has given no samples, for a second.
        """
        try:
            counts, host = self._drain()
        except OSError as error:
            self._skip(error)
            return []
        if not counts:
            self._check_alive("the chip answers, but takes no samples; did its supply fail for a moment?")
            self._sleep(_POLL)
            return []
        self._silence.end()
        return [Block.from_counts(self._stamps(len(counts), host), counts, self._setup)]

    def _drain(self) -> tuple[list[tuple[int, ...]], float]:
        """Return the samples in the FIFO, and when the last of them was there."""
        held = self._fifo_count()
        host = self._now()
        data = self._burst(held // SAMPLE_REGISTERS)
        # Asked last, so that an overflow while the FIFO was being read does not go unseen.
        if self._has_overflowed() or held >= FIFO_BYTES:
            self._count(overflows=1)
            self._check_alive("its FIFO overflows again and again; lower the rate, or raise the clock of the bus")
            self._empty()
            return [], host
        return list(struct.iter_unpack(">7h", data)), host

    def _burst(self, samples: int) -> bytes:
        data = bytearray()
        for first in range(0, samples, _BURST):
            size = min(_BURST, samples - first) * SAMPLE_REGISTERS
            data += bytes(self._bus.read_i2c_block_data(self._address, FIFO_R_W, size))
        return bytes(data)

    def _stamps(self, n: int, host: float) -> Floats:
        interval = 1 / self._setup.rate_hz
        device: Floats = self._elapsed + interval * np.arange(1.0, n + 1)
        self._elapsed = float(device[-1])
        if self._fresh:
            t = self._clock.restart(device, host, interval)
            self._count(missing=max(round((t[0] - self._t) / (interval * self._clock.rate)) - 1, 0))
        else:
            t = self._clock.stamps(device, host)
        self._fresh, self._t = False, float(t[-1])
        return t

    def _skip(self, error: OSError) -> None:
        """Begin anew after a transfer that failed, which may have left half a sample in the FIFO."""
        self._count(broken=1)
        self._check_alive(f"transfers fail: {error}; check the wires, and make them shorter")
        self._sleep(_POLL)
        with contextlib.suppress(OSError):
            self._empty()

    def _count(self, **more: int) -> None:
        self.losses = self.losses.plus(**more)

    def _check_alive(self, reason: str) -> None:
        silence = self._silence.grow(self._now())
        if silence > _PATIENCE:
            raise DataError(f"{self.name}: no sample for {silence:.1f} s: {reason}")

    def _check_chip(self) -> None:
        found = self._who_am_i(self._address)
        if found is None:
            other = next(address for address in ADDRESSES if address != self._address)
            cure = (
                f"one does at {other:#04x}: use that address"
                if self._who_am_i(other) is not None
                else "check VCC, GND, SDA and SCL (i2cdetect -y shows what is on a bus)"
            )
            raise DataError(f"{self.name}: no chip answers at {self._address:#04x}; {cure}")
        if found != MPU6050_ID:
            likely = _OTHER_CHIPS.get(found, "an unknown chip")
            raise DataError(
                f"{self.name}: WHO_AM_I at {self._address:#04x} reads {found:#04x}, {likely}; "
                f"expected {MPU6050_ID:#04x}, an MPU6050, whose registers and scales this reader relies on"
            )

    def _who_am_i(self, address: int) -> int | None:
        try:
            return self._bus.read_byte_data(address, WHO_AM_I)
        except OSError:
            return None

    def _configure(self) -> None:
        try:
            self._write(PWR_MGMT_1, DEVICE_RESET)
            self._sleep(_RESET_TIME)
            self._write(PWR_MGMT_1, CLOCK_OF_GYRO)
            self._sleep(_START_TIME)
            for offset, value in enumerate(self._setup.registers):
                self._write(SMPLRT_DIV + offset, value)
            self._write(INT_ENABLE, FIFO_OVERFLOW)
            self._write(FIFO_EN, ALL_SENSORS)
            kept = bytes(self._bus.read_i2c_block_data(self._address, SMPLRT_DIV, 4))
        except OSError as error:
            raise DataError(f"{self.name}: the chip stopped answering while it was set up: {error}") from None
        if kept != self._setup.registers:
            raise DataError(
                f"{self.name}: registers 0x19 to 0x1c read {kept.hex(' ')} after {self._setup.registers.hex(' ')} "
                "was written; check the supply, and make the wires shorter"
            )

    def _empty(self) -> None:
        """Begin to fill an empty FIFO; what comes next does not follow on what came before."""
        self._fresh = self._elapsed > 0
        self._write(USER_CTRL, 0)
        self._write(USER_CTRL, FIFO_RESET)
        self._write(USER_CTRL, FIFO_ON)
        self._has_overflowed()

    def _fifo_count(self) -> int:
        high, low = self._bus.read_i2c_block_data(self._address, FIFO_COUNT, 2)
        return high << 8 | low

    def _has_overflowed(self) -> bool:
        """Whether the FIFO was full since this was asked last; the chip forgets as it answers."""
        return bool(self._bus.read_byte_data(self._address, INT_STATUS) & FIFO_OVERFLOW)

    def _write(self, register: int, value: int) -> None:
        self._bus.write_byte_data(self._address, register, value)
