"""States as the outside world wants them: z up, or z down."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from footnav.trajectory import Trajectory, check_frame

Floats = NDArray[np.float64]


class States(NamedTuple):
    """Vectors in one frame, as in `Trajectory`."""

    position: Floats
    velocity: Floats
    quaternion: Floats
    position_std: Floats


def states_in(traj: Trajectory, frame: str | None) -> States:
    """Express the states of a track in a frame.

    Parameters
    ----------
    traj : Trajectory
        The track.
    frame : {"enu", "ned"} or None
        None stands for `traj.frame`.

    Returns
    -------
    States
        Position (n, 3) m, velocity (n, 3) m/s, quaternion (n, 4) xyzw from the sensor to the frame,
        one sigma (n, 3) m.

    Raises
    ------
    ConfigError
        For an unknown frame.
    """
    frame = traj.frame if frame is None else frame
    check_frame(frame)
    if frame == "enu":
        return States(traj.position, traj.velocity, traj.quaternion, traj.position_std)
    std = traj.position_std[:, [1, 0, 2]]
    return States(_ned(traj.position), _ned(traj.velocity), _ned_attitude(traj.quaternion), std)


def _ned(vectors: Floats) -> Floats:
    return vectors[:, [1, 0, 2]] * [1, 1, -1]


def _ned_attitude(quaternion: Floats) -> Floats:
    """Multiply by (1, 1, 0, 0) / sqrt(2) from the left: half a turn about the axis between east and north."""
    x, y, z, w = quaternion.T
    rotated: Floats = np.column_stack([w + z, w - z, y - x, -x - y]) / np.sqrt(2)
    return rotated
