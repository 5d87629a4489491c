"""Four swings of a foot between two rests, with white noise."""

from typing import Any

import numpy as np

COLUMNS = (
    "t",
    "position",
    "velocity",
    "quaternion",
    "zero_velocity",
    "position_std",
    "gyro_bias",
    "accel_bias",
    "flags",
)
"""Columns of a track, each of which has one entry for each sample."""


def swings(t: Any) -> tuple[Any, Any]:
    """Specific force (m/s^2) and angular rate (rad/s) at the stamps `t` (s), each (n, 3)."""
    swing = np.sin(np.pi * np.clip((t - 2) % 1.0 / 0.5, 0, 1)) * ((t > 2) & (t < 6))
    noise = np.random.default_rng(7).normal(size=(2, len(t), 3))
    accel = (
        [0.3, -0.2, 9.79]
        + swing[:, None] * [4.0, 0.5, 3.0] * np.cos(9 * t)[:, None]
        + 0.02 * noise[0]
    )
    gyro = (
        [0.002, -0.001, 0.003]
        + swing[:, None] * [0.3, 5.0, 0.2] * np.cos(12 * t)[:, None]
        + 0.002 * noise[1]
    )
    return accel, gyro


def assert_same(got: Any, expected: Any, columns: Any = COLUMNS) -> None:
    """Compare two tracks to the bit."""
    for column in columns:
        np.testing.assert_array_equal(
            getattr(got, column), getattr(expected, column), err_msg=column
        )
