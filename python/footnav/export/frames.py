"""States of a track in the frame of a file."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from footnav.export.track import Track
from footnav.frames import attitude_to_ned, check_frame, enu_to_ned

Floats = NDArray[np.float64]


class States(NamedTuple):
    """Vectors in one frame, as in `Trajectory`."""

    position: Floats
    velocity: Floats
    quaternion: Floats
    position_std: Floats


def states_in(traj: Track, frame: str | None) -> States:
    """Express the states of a track in a frame.

    Parameters
    ----------
    traj : Track
        The track.
    frame : {"enu", "ned"} or None
        None for `traj.frame`.

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
    return States(
        enu_to_ned(traj.position), enu_to_ned(traj.velocity), attitude_to_ned(traj.quaternion), std
    )
