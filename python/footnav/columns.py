"""Columns of a track: names, widths and types of its arrays."""

import numpy as np

COLUMNS: dict[str, tuple[tuple[int, ...], type]] = {
    "t": ((), np.float64),
    "position": ((3,), np.float64),
    "velocity": ((3,), np.float64),
    "quaternion": ((4,), np.float64),
    "zero_velocity": ((), np.bool_),
    "position_std": ((3,), np.float64),
    "gyro_bias": ((3,), np.float64),
    "accel_bias": ((3,), np.float64),
    "flags": ((), np.uint16),
}
"""Shape of one row, and type, of each array of a `Trajectory`."""
