"""What is special about an MPU6050: its registers, its self-test, and the ways in which it is misread.

References
----------
InvenSense, "MPU-6000 and MPU-6050 Register Map and Descriptions", RM-MPU-6000A-00, rev. 4.2, 2013: registers 13 to 16
(self-test), 25 (sample rate divider), 26 (low-pass filter), 27 and 28 (full scales), 65 (temperature).
InvenSense, "MPU-6000 and MPU-6050 Product Specification", PS-MPU-6000A-00, rev. 3.4, 2013: sections 6.1 and 6.2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from footnav.errors import ConfigError
from footnav.io.mpu6050 import ACCEL_RANGES, FULL_SCALE_COUNTS, GYRO_RANGES
from footnav.recording import STANDARD_GRAVITY, Floats, to_floats
from footnav.section import Section

CHANGE_LIMIT = 0.14
"""Largest change of the self-test response from the factory's that a sound part shows, relative (both sections 6)."""


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


ROUNDING = 0.005
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


class Setup(Section, frozen=True, kw_only=True):
    """The registers that decide what an MPU6050 puts out.

    Attributes
    ----------
    accel_range_g : int
        Full scale of the accelerometer, g: 2, 4, 8 or 16.
    gyro_range_deg_s : int
        Full scale of the gyroscope, deg/s: 250, 500, 1000 or 2000.
    dlpf_cfg : int
        DLPF_CFG, 0 to 6.
    smplrt_div : int
        SMPLRT_DIV, 0 to 255.

    Raises
    ------
    ConfigError
        A value that the chip does not have.
    """

    accel_range_g: int
    gyro_range_deg_s: int
    dlpf_cfg: int = 0
    smplrt_div: int = 0

    def __post_init__(self) -> None:
        """Refuse what the registers cannot hold."""
        choices: dict[str, Sequence[int]] = {
            "accel_range_g": ACCEL_RANGES,
            "gyro_range_deg_s": GYRO_RANGES,
            "dlpf_cfg": range(7),
            "smplrt_div": range(256),
        }
        for label, known in choices.items():
            _check_known(f"mpu6050.{label}", getattr(self, label), known)

    @property
    def rate_hz(self) -> float:
        """Samples per second, Hz; beyond 1 kHz the accelerometer repeats itself."""
        return (8000.0 if self.dlpf_cfg == 0 else 1000.0) / (1 + self.smplrt_div)

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
        """How much later than the gyroscope the accelerometer answers, s: up to 1 ms either way."""
        return self.accel_filter.delay - self.gyro_filter.delay

    @property
    def accel_counts_per_g(self) -> float:
        """Counts of the accelerometer in 1 g."""
        return FULL_SCALE_COUNTS / self.accel_range_g

    @property
    def gyro_counts_per_deg_s(self) -> float:
        """Counts of the gyroscope in 1 deg/s; the register map rounds them to a tenth."""
        return FULL_SCALE_COUNTS / self.gyro_range_deg_s


def accel_range_g(counts_per_g: float) -> int:
    """Return the full scale in g of an accelerometer that counts so much in 1 g, such as 16384 or 4096."""
    return _range(counts_per_g, ACCEL_RANGES, "counts per g")


def gyro_range_deg_s(counts_per_deg_s: float) -> int:
    """Return the full scale in deg/s of a gyroscope that counts so much in 1 deg/s, such as 131 or 16.4."""
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


@dataclass(frozen=True, slots=True)
class SelfTest:
    """The self-test of the chip against the factory's.

    Attributes
    ----------
    accel_trim, gyro_trim : tuple of 3 floats
        Response that the factory measured, counts at 8 g and at 250 deg/s; zero where it left none.
    accel_change, gyro_change : tuple of 3 floats
        Relative change of the response since then; nan where the factory left none.
    """

    accel_trim: tuple[float, ...]
    gyro_trim: tuple[float, ...]
    accel_change: tuple[float, ...]
    gyro_change: tuple[float, ...]

    @property
    def passed(self) -> bool:
        """Whether every axis lies within 14 % of the factory's response."""
        return all(abs(change) <= CHANGE_LIMIT for change in (*self.accel_change, *self.gyro_change))

    def __str__(self) -> str:
        """Return one line an axis, and the verdict."""
        lines = [
            f"{sensor}_{axis}: {100 * change:+.1f} % from the factory's {trim:.0f} counts"
            for sensor in ("accel", "gyro")
            for axis, change, trim in zip(
                "xyz", getattr(self, f"{sensor}_change"), getattr(self, f"{sensor}_trim"), strict=True
            )
        ]
        return "\n".join([*lines, f"self-test {'passed' if self.passed else 'failed'}: within +-14 % is sound"])


def factory_trim(registers: Sequence[int]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Decode the self-test response that the factory wrote into the chip (registers 13 to 16).

    Parameters
    ----------
    registers : sequence of 4 int
        SELF_TEST_X, SELF_TEST_Y, SELF_TEST_Z, SELF_TEST_A, 0 to 255.

    Returns
    -------
    accel, gyro : tuple of 3 floats
        Counts at full scales of 8 g and 250 deg/s; zero where the register is zero.

    Raises
    ------
    ConfigError
        These are not four bytes.
    """
    if len(registers) != 4 or any(not 0 <= value <= 255 for value in registers):
        raise ConfigError(f"self-test registers are {list(registers)}; expected the four bytes of registers 13 to 16")
    *axes, shared = registers
    accel = ((value >> 5) << 2 | shared >> shift & 3 for value, shift in zip(axes, (4, 2, 0), strict=True))
    gyro = (value & 31 for value in axes)
    return (
        tuple(4096 * 0.34 * (0.92 / 0.34) ** ((n - 1) / 30) if n else 0.0 for n in accel),
        tuple(sign * 25 * 131 * 1.046 ** (n - 1) if n else 0.0 for sign, n in zip((1, -1, 1), gyro, strict=True)),
    )


def self_test(registers: Sequence[int], accel_response: ArrayLike, gyro_response: ArrayLike) -> SelfTest:
    """Compare the self-test response with the factory's.

    Parameters
    ----------
    registers : sequence of 4 int
        Registers 13 to 16.
    accel_response, gyro_response : array_like, shape (3,)
        Mean counts with the self-test on, less those with it off, at 8 g and 250 deg/s.

    Returns
    -------
    SelfTest

    Raises
    ------
    ConfigError
        The registers are not four bytes.
    """
    accel_trim, gyro_trim = factory_trim(registers)
    return SelfTest(accel_trim, gyro_trim, _change(accel_response, accel_trim), _change(gyro_response, gyro_trim))


def explain_rest(magnitude: float) -> str | None:
    """Say what is wrong with a sensor whose accelerometer reads so much at rest in every pose.

    Parameters
    ----------
    magnitude : float
        Specific force at rest, m/s².

    Returns
    -------
    str or None
        Likely cause and cure; None for about 1 g, and for what no range explains.
    """
    in_g = magnitude / STANDARD_GRAVITY
    power = round(math.log2(in_g)) if in_g > 0 else 0
    if power == 0 or abs(power) > 3 or abs(in_g / 2.0**power - 1) > 0.2:
        return None
    factor = f"{2**power} times" if power > 0 else f"1/{2**-power} of"
    return (
        f"at rest the accelerometer reads {in_g:.2f} g in every pose, so accel_range is {factor} what the sensor was "
        "set to: give the range that its register ACCEL_CONFIG holds"
    )


def explain_bias(bias: Sequence[float]) -> str | None:
    """Say what is wrong with an accelerometer that is off by whole g on one axis.

    Parameters
    ----------
    bias : sequence of 3 floats
        Bias of the accelerometer, m/s².

    Returns
    -------
    str or None
        Likely cause and cure; None when no axis is off by half a g.
    """
    axis = int(np.argmax(np.abs(bias)))
    in_g = bias[axis] / STANDARD_GRAVITY
    if abs(in_g) < 0.5:
        return None
    return (
        f"accel_{'xyz'[axis]} reads {in_g:+.2f} g too much in every pose (an upright sensor would read "
        f"{1 + in_g:.2f} g): the chip's offset registers are wrong, as after i2cdevlib's offset calibration, which "
        "takes the range for 2 g (at 4, 8 and 16 g it leaves 2, 4 and 8 g at rest), or which was run twice; switch the "
        "power off and on, write no offsets, and record again"
    )


def _change(response: ArrayLike, trim: tuple[float, ...]) -> tuple[float, ...]:
    """Return the relative change of a response from the factory's."""
    measured = to_floats("self-test response", response).tolist()
    return tuple(value / factory - 1 if factory else math.nan for value, factory in zip(measured, trim, strict=True))


def _range(counts: float, known: Sequence[int], label: str) -> int:
    """Return the full scale at which the chip counts so much in one unit."""
    for full_scale in known:
        if abs(counts * full_scale / FULL_SCALE_COUNTS - 1) < ROUNDING:
            return full_scale
    choices = ", ".join(f"{FULL_SCALE_COUNTS / full_scale:.5g}" for full_scale in known)
    raise ConfigError(f"{counts:g} {label}: an MPU6050 has {choices}")


def _check_known(label: str, value: int, known: Sequence[int]) -> None:
    if value not in known:
        choices = f"{known[0]} to {known[-1]}" if isinstance(known, range) else ", ".join(map(str, known))
        raise ConfigError(f"{label} is {value}; an MPU6050 has {choices}")
