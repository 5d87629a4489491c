"""The registers of the MPU6050.

References
----------
InvenSense, "MPU-6000 and MPU-6050 Register Map and Descriptions", RM-MPU-6000A-00, rev. 4.2, 2013:
registers 25 (sample rate divider), 26 (low-pass filter), 27 and 28 (full scales), 65 (temperature).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from numpy.typing import ArrayLike

from footnav.errors import ConfigError
from footnav.io.mpu6050 import ACCEL_RANGES, FULL_SCALE_COUNTS, GYRO_RANGES
from footnav.recording import STANDARD_GRAVITY, Floats, to_floats
from footnav.settings import Settings

MPU6050_ID = 0x68
"""Value of the register WHO_AM_I of an MPU6050, at either address."""

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
"""Bytes of a sample, in the order of the registers: accelerometer, thermometer, gyroscope, each
high byte first.
"""


@dataclass(frozen=True, slots=True)
class LowPass:
    """The low-pass filter of one sensor.

    Attributes
    ----------
    bandwidth_hz : float
        Bandwidth, Hz.
    delay : float
        Delay of its output, s.
    """

    bandwidth_hz: float
    delay: float


_ROUNDING = 0.005
"""Relative rounding of the sensitivities in the data sheet."""

_FILTERS = MappingProxyType(
    {
        0: (LowPass(260.0, 0.0), LowPass(256.0, 0.98e-3)),
        1: (LowPass(184.0, 2.0e-3), LowPass(188.0, 1.9e-3)),
        2: (LowPass(94.0, 3.0e-3), LowPass(98.0, 2.8e-3)),
        3: (LowPass(44.0, 4.9e-3), LowPass(42.0, 4.8e-3)),
        4: (LowPass(21.0, 8.5e-3), LowPass(20.0, 8.3e-3)),
        5: (LowPass(10.0, 13.8e-3), LowPass(10.0, 13.4e-3)),
        6: (LowPass(5.0, 19.0e-3), LowPass(5.0, 18.6e-3)),
    }
)
"""Filters of accelerometer and gyroscope by DLPF_CFG (register 26)."""


class Setup(Settings, frozen=True, kw_only=True):
    """The registers that set range, bandwidth and rate of an MPU6050.

    Attributes
    ----------
    accel_range_g : int
        Full scale of the accelerometer, g: 2, 4, 8 or 16.  A heel strike reaches 10 g.
    gyro_range_deg_s : int
        Full scale of the gyroscope, deg/s: 250, 500, 1000 or 2000.  A foot turns at up to 1000
        deg/s.
    dlpf_cfg : int
        Low-pass filter, 0 to 6; 2 passes 94 Hz, for 200 samples per second.
    smplrt_div : int
        The chip samples at 1 kHz over one more than this (8 kHz without low-pass filter, at
        `dlpf_cfg` 0); 0 to 255.

    Raises
    ------
    ConfigError
        The chip does not have a value.
    """

    accel_range_g: int = 16
    gyro_range_deg_s: int = 2000
    dlpf_cfg: int = 2
    smplrt_div: int = 4

    def __post_init__(self) -> None:
        """Validate the values of the registers."""
        choices: dict[str, Sequence[int]] = {
            "accel_range_g": ACCEL_RANGES,
            "gyro_range_deg_s": GYRO_RANGES,
            "dlpf_cfg": range(7),
            "smplrt_div": range(256),
        }
        for label, known in choices.items():
            _check_known(label, getattr(self, label), known)

    @classmethod
    def at_rate(cls, rate_hz: float, **settings: Any) -> "Setup":
        """Return the settings for a sampling rate.

        Parameters
        ----------
        rate_hz : float
            Samples per second, Hz.
        **settings
            The other attributes.

        Returns
        -------
        Setup
            Settings with exactly this rate.

        Raises
        ------
        ConfigError
            The chip does not have the rate; the message has the nearest one.
        """
        setup = cls(**settings)
        if not (math.isfinite(rate_hz) and rate_hz > 0):
            raise ConfigError(f"rate_hz is {rate_hz}; expected a positive number")
        divider = min(max(round(setup._undivided_hz / rate_hz) - 1, 0), 255)
        found = setup.replace(smplrt_div=divider)
        if not math.isclose(found.rate_hz, rate_hz, rel_tol=1e-4):
            raise ConfigError(
                f"rate_hz is {rate_hz:g}; an MPU6050 divides {setup._undivided_hz:g} Hz by 1 to "
                "256, "
                f"and the nearest is {found.rate_hz:.6g}"
            )
        return found

    @classmethod
    def from_registers(cls, registers: bytes) -> "Setup":
        """Decode SMPLRT_DIV, CONFIG, GYRO_CONFIG and ACCEL_CONFIG (sections 4.2 to 4.5).

        Parameters
        ----------
        registers : bytes
            The four registers, from address 0x19 on.

        Returns
        -------
        Setup
            Their meaning.

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
        """SMPLRT_DIV, CONFIG, GYRO_CONFIG and ACCEL_CONFIG, from address 0x19 on."""
        gyro_config = GYRO_RANGES.index(self.gyro_range_deg_s) << 3
        accel_config = ACCEL_RANGES.index(self.accel_range_g) << 3
        return bytes((self.smplrt_div, self.dlpf_cfg, gyro_config, accel_config))

    @property
    def rate_hz(self) -> float:
        """Samples per second by the chip's own clock, Hz.

        Beyond 1 kHz samples of the accelerometer repeat.
        """
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
        return 1000.0 if self.dlpf_cfg else 8000.0

    @property
    def accel_filter(self) -> LowPass:
        """Low-pass filter of the accelerometer."""
        return _FILTERS[self.dlpf_cfg][0]

    @property
    def gyro_filter(self) -> LowPass:
        """Low-pass filter of the gyroscope."""
        return _FILTERS[self.dlpf_cfg][1]

    @property
    def accel_lag(self) -> float:
        """Delay of the accelerometer relative to the gyroscope, s: within 1 ms."""
        return self.accel_filter.delay - self.gyro_filter.delay

    @property
    def accel_counts_per_g(self) -> float:
        """Counts of the accelerometer in 1 g."""
        return FULL_SCALE_COUNTS / self.accel_range_g

    @property
    def gyro_counts_per_deg_s(self) -> float:
        """Counts of the gyroscope in 1 deg/s; the register map rounds them to a tenth."""
        return FULL_SCALE_COUNTS / self.gyro_range_deg_s

    def __str__(self) -> str:
        """Return the settings in one line."""
        return (
            f"{self.accel_range_g} g, {self.gyro_range_deg_s} deg/s, {self.rate_hz:.6g} Hz, "
            f"low-pass {self.dlpf_cfg}"
        )


def accel_range_g(counts_per_g: float) -> int:
    """Return the full scale in g for counts per g, such as 16384 or 4096."""
    return _range(counts_per_g, ACCEL_RANGES, "counts per g")


def gyro_range_deg_s(counts_per_deg_s: float) -> int:
    """Return the full scale in deg/s for counts per deg/s, such as 131 or 16.4."""
    return _range(counts_per_deg_s, GYRO_RANGES, "counts per deg/s")


def temperature_degc(counts: ArrayLike) -> Floats:
    """Return the temperature of the die.

    Parameters
    ----------
    counts : array_like
        TEMP_OUT (registers 65 and 66), signed.

    Returns
    -------
    ndarray
        Degrees Celsius.
    """
    return to_floats("temperature counts", counts) / 340.0 + 36.53


def wrong_chip(chip: int) -> str:
    """Name a chip that is not an MPU6050 by its WHO_AM_I, as the end of a message."""
    likely = _OTHER_CHIPS.get(chip, "an unknown chip")
    return (
        f"{chip:#04x}, {likely}; expected {MPU6050_ID:#04x}, an MPU6050, whose registers and "
        "scales are required"
    )


def _range(counts: float, known: Sequence[int], label: str) -> int:
    """Return the full scale with these counts per unit."""
    for full_scale in known:
        if abs(counts * full_scale / FULL_SCALE_COUNTS - 1) < _ROUNDING:
            return full_scale
    choices = ", ".join(f"{FULL_SCALE_COUNTS / full_scale:.5g}" for full_scale in known)
    raise ConfigError(f"{counts:g} {label}: an MPU6050 has {choices}")


def _check_known(label: str, value: int, known: Sequence[int]) -> None:
    if value not in known:
        choices = (
            f"{known[0]} to {known[-1]}" if isinstance(known, range) else ", ".join(map(str, known))
        )
        raise ConfigError(f"{label} is {value}; an MPU6050 has {choices}")
