"""The MPU6050 as a chip: what its registers mean.

References
----------
InvenSense, "MPU-6000 and MPU-6050 Register Map and Descriptions", RM-MPU-6000A-00, revision 4.2, 2013.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footnav.errors import ConfigError
from footnav.io.mpu6050 import ACCEL_RANGES, FULL_SCALE_COUNTS, GYRO_RANGES
from footnav.recording import STANDARD_GRAVITY, Floats

MPU6050_ID = 0x68
"""What the register WHO_AM_I of an MPU6050 reads, whichever address it answers at."""

_OTHER_CHIPS = {
    0x00: "nothing, as with a short circuit to ground",
    0x12: "an ICM-20602",
    0x19: "an MPU6886",
    0x70: "an MPU6500, or a copy of it",
    0x71: "an MPU9250",
    0x72: "a copy of the MPU6050",
    0x73: "an MPU9255",
    0x98: "a copy of the MPU6050",
    0xFF: "nothing, as with a loose wire",
}

SAMPLE_REGISTERS = 14
"""Bytes of a sample, in the order of the registers: accelerometer, thermometer, gyroscope, each high byte first."""

DLPF_CHOICES = range(7)
"""Settings of the low-pass filter, from 256 Hz (0) down to 5 Hz (6); 7 is reserved."""

_RATE, _RATE_WITHOUT_DLPF = 1000.0, 8000.0
"""Hz, section 4.4: what the divider divides, with the low-pass filter and at its widest setting 0."""

_KELVIN_COUNTS, _ZERO_COUNT_TEMPERATURE = 340.0, 36.53
"""Counts per degree, and degrees Celsius at count 0, section 4.18."""


@dataclass(frozen=True, slots=True)
class Setup:
    """How the chip is set.

    Attributes
    ----------
    accel_range_g : int
        Full scale of the accelerometer, g: 2, 4, 8 or 16.  A heel strikes the ground with up to 10 g.
    gyro_range_deg_s : int
        Full scale of the gyroscope, deg/s: 250, 500, 1000 or 2000.  A foot turns at up to 1000 deg/s.
    dlpf_cfg : int
        Setting of the low-pass filter, 0 to 6; 2 passes 94 Hz, which suits 200 samples per second.
    smplrt_div : int
        The chip samples at 1 kHz over one more than this (8 kHz without low-pass filter, at `dlpf_cfg` 0); 0 to 255.

    Raises
    ------
    ConfigError
        A value is none that the chip has.
    """

    accel_range_g: int = 16
    gyro_range_deg_s: int = 2000
    dlpf_cfg: int = 2
    smplrt_div: int = 4

    def __post_init__(self) -> None:
        """Refuse what the chip does not have."""
        _check_choice("accel_range", "g", self.accel_range_g, ACCEL_RANGES)
        _check_choice("gyro_range", "deg/s", self.gyro_range_deg_s, GYRO_RANGES)
        _check_choice("dlpf", "", self.dlpf_cfg, tuple(DLPF_CHOICES))
        if self.smplrt_div not in range(256):
            raise ConfigError(f"smplrt_div is {self.smplrt_div}; expected 0 to 255")

    @classmethod
    def at_rate(cls, rate_hz: float, **settings: Any) -> "Setup":
        """Find the divider that gives a sampling rate.

        Parameters
        ----------
        rate_hz : float
            Samples per second, Hz.
        **settings
            The other attributes.

        Returns
        -------
        Setup
            With exactly this rate.

        Raises
        ------
        ConfigError
            The chip does not have the rate; the message names the nearest that it has.
        """
        setup = cls(**settings)
        if not (math.isfinite(rate_hz) and rate_hz > 0):
            raise ConfigError(f"rate_hz is {rate_hz}; expected a positive number")
        divider = min(max(round(setup._undivided_hz / rate_hz) - 1, 0), 255)
        found = cls(setup.accel_range_g, setup.gyro_range_deg_s, setup.dlpf_cfg, divider)
        if not math.isclose(found.rate_hz, rate_hz, rel_tol=1e-4):
            raise ConfigError(
                f"rate_hz is {rate_hz:g}; an MPU6050 divides {setup._undivided_hz:g} Hz by 1 to 256, "
                f"and the nearest is {found.rate_hz:.6g}"
            )
        return found

    @classmethod
    def from_registers(cls, registers: bytes) -> "Setup":
        """Read the settings from SMPLRT_DIV, CONFIG, GYRO_CONFIG and ACCEL_CONFIG, sections 4.2 to 4.5.

        Parameters
        ----------
        registers : bytes
            The four registers, from address 0x19 on.

        Returns
        -------
        Setup
            What they mean.

        Raises
        ------
        ConfigError
            The low-pass filter has its reserved setting.
        """
        divider, config, gyro_config, accel_config = registers
        return cls(
            accel_range_g=ACCEL_RANGES[accel_config >> 3 & 3],
            gyro_range_deg_s=GYRO_RANGES[gyro_config >> 3 & 3],
            dlpf_cfg=config & 7,
            smplrt_div=divider,
        )

    @property
    def registers(self) -> bytes:
        """SMPLRT_DIV, CONFIG, GYRO_CONFIG and ACCEL_CONFIG, which lie side by side from address 0x19 on."""
        gyro_config = GYRO_RANGES.index(self.gyro_range_deg_s) << 3
        accel_config = ACCEL_RANGES.index(self.accel_range_g) << 3
        return bytes((self.smplrt_div, self.dlpf_cfg, gyro_config, accel_config))

    @property
    def rate_hz(self) -> float:
        """Samples per second, Hz, by the chip's own clock."""
        return self._undivided_hz / (1 + self.smplrt_div)

    @property
    def accel_range(self) -> float:
        """Full scale of the accelerometer, m/s²."""
        return self.accel_range_g * STANDARD_GRAVITY

    @property
    def gyro_range(self) -> float:
        """Full scale of the gyroscope, rad/s."""
        return math.radians(self.gyro_range_deg_s)

    @property
    def _undivided_hz(self) -> float:
        return _RATE if self.dlpf_cfg else _RATE_WITHOUT_DLPF

    def __str__(self) -> str:
        """Return the settings in one line."""
        return f"{self.accel_range_g} g, {self.gyro_range_deg_s} deg/s, {self.rate_hz:.6g} Hz, low-pass {self.dlpf_cfg}"


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Samples that came together, in SI units.

    Attributes
    ----------
    t : ndarray of shape (n,)
        Time since the first sample of the capture, s.
    accel : ndarray of shape (n, 3)
        Specific force along the sensor's axes, m/s².
    gyro : ndarray of shape (n, 3)
        Angular rate about the sensor's axes, rad/s.
    temperature : ndarray of shape (n,)
        Of the chip, degrees Celsius.
    setup : Setup
        How the chip was set.
    """

    t: Floats
    accel: Floats
    gyro: Floats
    temperature: Floats
    setup: Setup

    @classmethod
    def from_counts(cls, t: Floats, counts: ArrayLike, setup: Setup) -> "Block":
        """Scale raw counts.

        Parameters
        ----------
        t : ndarray of shape (n,)
            Stamps, s.
        counts : array_like of shape (n, 7)
            Accelerometer, thermometer and gyroscope, in the order of the registers.
        setup : Setup
            How the chip was set.

        Returns
        -------
        Block
            In SI units.
        """
        raw: NDArray[np.float64] = np.asarray(counts, dtype=np.float64).reshape(-1, 7)
        return cls(
            t=t,
            accel=raw[:, :3] / FULL_SCALE_COUNTS * setup.accel_range,
            gyro=raw[:, 4:] / FULL_SCALE_COUNTS * setup.gyro_range,
            temperature=raw[:, 3] / _KELVIN_COUNTS + _ZERO_COUNT_TEMPERATURE,
            setup=setup,
        )

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.t)


def wrong_chip(chip: int) -> str:
    """Say what a chip is that WHO_AM_I shows not to be an MPU6050, as the end of a message."""
    likely = _OTHER_CHIPS.get(chip, "an unknown chip")
    return f"{chip:#04x}, {likely}; expected {MPU6050_ID:#04x}, an MPU6050, on whose registers and scales this relies"


def _check_choice(label: str, unit: str, value: int, known: tuple[int, ...]) -> None:
    if value not in known:
        raise ConfigError(f"{label} is {value:g}{unit and ' ' + unit}; an MPU6050 has {', '.join(map(str, known))}")
