"""The registers of an MPU6050 on an I2C bus, and its FIFO.

References
----------
InvenSense, "MPU-6000 and MPU-6050 Register Map and Descriptions", RM-MPU-6000A-00, revision 4.2,
2013.
"""

from collections.abc import Callable
from typing import Protocol

from footnav.errors import ConfigError, DataError
from footnav.mpu6050 import MPU6050_ID, SAMPLE_REGISTERS, Setup, wrong_chip

ADDRESSES = (0x68, 0x69)
"""With the pin AD0 low, as on most boards, and high."""

SMPLRT_DIV, FIFO_EN, INT_ENABLE, INT_STATUS = 0x19, 0x23, 0x38, 0x3A
USER_CTRL, PWR_MGMT_1, FIFO_COUNT, FIFO_R_W, WHO_AM_I = 0x6A, 0x6B, 0x72, 0x74, 0x75

DEVICE_RESET, CLOCK_OF_GYRO = 0x80, 0x01
"""PWR_MGMT_1: reset; awake, on the gyroscope's oscillator, which is more stable than the internal
one.
"""

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


class Bus(Protocol):
    """The members of `smbus2.SMBus` that are used."""

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


class Mpu6050:
    """One chip on a bus.

    Parameters
    ----------
    bus : Bus
        An open bus.
    address : int
        0x68, or 0x69 with the pin AD0 high.
    name : str
        Name of the bus in messages.

    Raises
    ------
    ConfigError
        The chip cannot have the address.
    DataError
        No chip answers there, or it is another one.
    """

    def __init__(self, bus: Bus, address: int, name: str) -> None:
        check_address(address)
        self._bus, self._address, self._name = bus, address, name
        self._check_identity()

    def configure(self, setup: Setup, sleep: Callable[[float], None]) -> None:
        """Set the chip up.

        Parameters
        ----------
        setup : Setup
            Settings of the chip.
        sleep : callable
            Sleeps for a time in s.

        Raises
        ------
        DataError
            The chip stops answering, or its registers do not hold the settings.
        """
        try:
            self._write(PWR_MGMT_1, DEVICE_RESET)
            sleep(_RESET_TIME)
            self._write(PWR_MGMT_1, CLOCK_OF_GYRO)
            sleep(_START_TIME)
            for offset, value in enumerate(setup.registers):
                self._write(SMPLRT_DIV + offset, value)
            self._write(INT_ENABLE, FIFO_OVERFLOW)
            self._write(FIFO_EN, ALL_SENSORS)
            kept = bytes(self._bus.read_i2c_block_data(self._address, SMPLRT_DIV, 4))
        except OSError as error:
            raise DataError(
                f"{self._name}: the chip stopped answering while it was set up: {error}"
            ) from None
        if kept != setup.registers:
            raise DataError(
                f"{self._name}: registers 0x19 to 0x1c read {kept.hex(' ')} after "
                f"{setup.registers.hex(' ')} "
                "was written; check the supply, and make the wires shorter"
            )

    def reset_fifo(self) -> None:
        """Clear and start the FIFO.

        Raise OSError for a transfer that fails, as the methods below.
        """
        self._write(USER_CTRL, 0)
        self._write(USER_CTRL, FIFO_RESET)
        self._write(USER_CTRL, FIFO_ON)
        self.has_overflowed()

    def fifo_bytes(self) -> int:
        """Return how many bytes the FIFO holds."""
        high, low = self._bus.read_i2c_block_data(self._address, FIFO_COUNT, 2)
        return high << 8 | low

    def read_fifo(self, samples: int) -> bytes:
        """Read samples from the FIFO, `SAMPLE_REGISTERS` bytes each; it must hold as many."""
        data = bytearray()
        for first in range(0, samples, _BURST):
            size = min(_BURST, samples - first) * SAMPLE_REGISTERS
            data += bytes(self._bus.read_i2c_block_data(self._address, FIFO_R_W, size))
        return bytes(data)

    def has_overflowed(self) -> bool:
        """Whether the FIFO overflowed since the last call; the read clears the bit."""
        return bool(self._bus.read_byte_data(self._address, INT_STATUS) & FIFO_OVERFLOW)

    def _check_identity(self) -> None:
        found = self._who_am_i(self._address)
        if found is None:
            other = next(address for address in ADDRESSES if address != self._address)
            cure = (
                f"one does at {other:#04x}: use that address"
                if self._who_am_i(other) is not None
                else "check VCC, GND, SDA and SCL (i2cdetect -y shows the devices on a bus)"
            )
            raise DataError(f"{self._name}: no chip answers at {self._address:#04x}; {cure}")
        if found != MPU6050_ID:
            raise DataError(
                f"{self._name}: WHO_AM_I at {self._address:#04x} reads {wrong_chip(found)}"
            )

    def _who_am_i(self, address: int) -> int | None:
        try:
            return self._bus.read_byte_data(address, WHO_AM_I)
        except OSError:
            return None

    def _write(self, register: int, value: int) -> None:
        self._bus.write_byte_data(self._address, register, value)
