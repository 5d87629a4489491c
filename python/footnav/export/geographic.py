"""Latitude, longitude and height of a track."""

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from footnav.errors import DataError, FootnavWarning
from footnav.export.library import require
from footnav.trajectory import Origin, Trajectory, check_origin

Floats = NDArray[np.float64]


def place(position: Floats, origin: Origin) -> Floats:
    """Place positions on Earth.

    Parameters
    ----------
    position : (n, 3) ndarray
        East, north and up of the origin, m.
    origin : (latitude, longitude, height)
        Degrees and m (WGS-84).

    Returns
    -------
    (n, 3) ndarray
        Latitude and longitude in degrees and ellipsoidal height in m.
    """
    pymap3d = require("pymap3d", "pymap3d")
    return np.column_stack(pymap3d.enu2geodetic(*position.T, *origin))


def geodetic(traj: Trajectory, origin: Sequence[float] | None) -> Floats:
    """Place the line of a track on a map.

    Parameters
    ----------
    traj : Trajectory
        The track, with x to the east and y to the north.
    origin : (latitude, longitude, height) or None
        Degrees and m (WGS-84); None stands for `traj.origin`.

    Returns
    -------
    (n, 3) ndarray
        Longitude and latitude in degrees and height in m: the order of GeoJSON and KML.

    Raises
    ------
    ConfigError
        For an impossible origin.
    DataError
        For a track of fewer than two samples, or a position that is not finite.

    Warns
    -----
    FootnavWarning
        When there is no origin, and the track is put at latitude 0, longitude 0; when there is one,
        but x may not be east.
    """
    _check_positions(traj)
    return place(traj.position, _origin(traj, origin))[:, [1, 0, 2]]


def _origin(traj: Trajectory, origin: Sequence[float] | None) -> Origin:
    given = check_origin(origin) if origin is not None else traj.origin
    if given is not None:
        warn_of_heading(traj, stacklevel=3)
        return given
    warnings.warn(
        "the track has no origin and is put at latitude 0, longitude 0: "
        "set output.origin in the configuration, or save(..., origin=(latitude, longitude, height))",
        FootnavWarning,
        stacklevel=2,
    )
    return 0.0, 0.0, 0.0


def warn_of_heading(traj: Trajectory, stacklevel: int) -> None:
    """Warn of a track whose x axis may not be east; `stacklevel` as for `warnings.warn`."""
    if not traj.heading_known:
        warnings.warn(
            "the heading at the start is not known, so the map shows the track turned about its origin: "
            "set alignment.heading_deg in the configuration, or take it from the magnetometer",
            FootnavWarning,
            stacklevel=stacklevel + 1,
        )


def _check_positions(traj: Trajectory) -> None:
    label = f"{traj.name}: " if traj.name else ""
    if len(traj) < 2:
        raise DataError(
            f"{label}a line on a map needs two samples or more, the track has {len(traj)}"
        )
    bad = np.flatnonzero(~np.isfinite(traj.position).all(axis=1))
    if bad.size:
        raise DataError(
            f"{label}row {bad[0]}: position is {traj.position[bad[0]]}, expected finite numbers for a map"
        )
