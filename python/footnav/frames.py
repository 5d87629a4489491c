"""The two local-level frames: east-north-up and north-east-down."""

import numpy as np
from numpy.typing import NDArray

from footnav.errors import ConfigError

Floats = NDArray[np.float64]

FRAMES = ("enu", "ned")


def check_frame(frame: str) -> None:
    """Raise ConfigError for a frame other than "enu" and "ned"."""
    if frame not in FRAMES:
        raise ConfigError(f"frame is {frame!r}: expected 'enu' or 'ned'")


def enu_to_ned(vectors: Floats) -> Floats:
    """Express vectors (n, 3) of the frame with z up in the frame with z down."""
    return vectors[:, [1, 0, 2]] * [1, 1, -1]


def attitude_to_ned(quaternion: Floats) -> Floats:
    """Return the attitudes, quaternions xyzw (n, 4), from the sensor to the frame with z down.

    The frames differ by half a turn about the axis between east and north, a rotation that is the
    same in both directions.
    """
    from scipy.spatial.transform import Rotation

    half_turn = Rotation.from_quat([1.0, 1.0, 0.0, 0.0])
    turned: Floats = (half_turn * Rotation.from_quat(quaternion)).as_quat()
    return turned
