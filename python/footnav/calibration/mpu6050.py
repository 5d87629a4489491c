"""Calibration of an MPU6050: self-test, and detection of wrong ranges and offsets.

References
----------
InvenSense, "MPU-6000 and MPU-6050 Register Map and Descriptions", RM-MPU-6000A-00, rev. 4.2, 2013:
registers 13 to 16 (self-test). InvenSense, "MPU-6000 and MPU-6050 Product Specification",
PS-MPU-6000A-00, rev. 3.4, 2013: sections 6.1 and 6.2.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from footnav.errors import ConfigError
from footnav.recording import STANDARD_GRAVITY, to_floats

CHANGE_LIMIT = 0.14
"""Maximum relative change of the self-test response from the factory's for a part that passes (both
sections 6).
"""


@dataclass(frozen=True, slots=True)
class SelfTest:
    """The self-test of the chip against the factory's.

    Attributes
    ----------
    accel_trim, gyro_trim : tuple of 3 floats
        Response that the factory measured, counts at 8 g and at 250 deg/s; zero where it is absent.
    accel_change, gyro_change : tuple of 3 floats
        Relative change of the response since then; nan where it is absent.
    """

    accel_trim: tuple[float, ...]
    gyro_trim: tuple[float, ...]
    accel_change: tuple[float, ...]
    gyro_change: tuple[float, ...]

    @property
    def passed(self) -> bool:
        """Whether every axis lies within 14 % of the factory's response."""
        return all(
            abs(change) <= CHANGE_LIMIT for change in (*self.accel_change, *self.gyro_change)
        )

    def __str__(self) -> str:
        """Return one line for each axis, and the result."""
        lines = [
            f"{sensor}_{axis}: {100 * change:+.1f} % from the factory's {trim:.0f} counts"
            for sensor in ("accel", "gyro")
            for axis, change, trim in zip(
                "xyz",
                getattr(self, f"{sensor}_change"),
                getattr(self, f"{sensor}_trim"),
                strict=True,
            )
        ]
        return "\n".join(
            [*lines, f"self-test {'passed' if self.passed else 'failed'}: within +-14 % is sound"]
        )


def factory_trim(registers: Sequence[int]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Decode the self-test response of the factory (registers 13 to 16).

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
        raise ConfigError(
            f"self-test registers are {list(registers)}; expected the four bytes of registers 13 "
            "to 16"
        )
    *axes, shared = registers
    accel = (
        (value >> 5) << 2 | shared >> shift & 3
        for value, shift in zip(axes, (4, 2, 0), strict=True)
    )
    gyro = (value & 31 for value in axes)
    return (
        tuple(4096 * 0.34 * (0.92 / 0.34) ** ((n - 1) / 30) if n else 0.0 for n in accel),
        tuple(
            sign * 25 * 131 * 1.046 ** (n - 1) if n else 0.0
            for sign, n in zip((1, -1, 1), gyro, strict=True)
        ),
    )


def self_test(
    registers: Sequence[int], accel_response: ArrayLike, gyro_response: ArrayLike
) -> SelfTest:
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
    return SelfTest(
        accel_trim,
        gyro_trim,
        _change(accel_response, accel_trim),
        _change(gyro_response, gyro_trim),
    )


def explain_rest(magnitude: float) -> str | None:
    """Explain a wrong specific force at rest that is the same in every pose.

    Parameters
    ----------
    magnitude : float
        Specific force at rest, m/s².

    Returns
    -------
    str or None
        Likely cause and remedy; None for about 1 g, and where no range explains it.
    """
    in_g = magnitude / STANDARD_GRAVITY
    power = round(math.log2(in_g)) if in_g > 0 else 0
    if power == 0 or abs(power) > 3 or abs(in_g / 2.0**power - 1) > 0.2:
        return None
    factor = f"{2**power} times" if power > 0 else f"1/{2**-power} of"
    return (
        f"at rest the accelerometer reads {in_g:.2f} g in every pose, so accel_range is {factor} "
        "what the sensor was "
        "set to: give the range that its register ACCEL_CONFIG holds"
    )


def explain_bias(bias: Sequence[float]) -> str | None:
    """Explain a bias of whole g on one axis of the accelerometer.

    Parameters
    ----------
    bias : sequence of 3 floats
        Bias of the accelerometer, m/s².

    Returns
    -------
    str or None
        Likely cause and remedy; None when no axis is off by half a g.
    """
    axis = int(np.argmax(np.abs(bias)))
    in_g = bias[axis] / STANDARD_GRAVITY
    if abs(in_g) < 0.5:
        return None
    return (
        f"accel_{'xyz'[axis]} reads {in_g:+.2f} g too much in every pose (an upright sensor would "
        "read "
        f"{1 + in_g:.2f} g): the chip's offset registers are wrong, as after i2cdevlib's offset "
        "calibration, which "
        "takes the range for 2 g (at 4, 8 and 16 g it leaves 2, 4 and 8 g at rest), or which was "
        "run twice; switch the "
        "power off and on, write no offsets, and record again"
    )


def _change(response: ArrayLike, trim: tuple[float, ...]) -> tuple[float, ...]:
    """Return the relative change of a response from the factory's."""
    measured = to_floats("self-test response", response).tolist()
    return tuple(
        value / factory - 1 if factory else math.nan
        for value, factory in zip(measured, trim, strict=True)
    )
