"""The line of a track on a map."""

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from footnav.errors import DataError, FootnavWarning
from footnav.export.track import Track
from footnav.geodesy import Origin, check_origin, enu_to_geodetic, warn_of_heading

Floats = NDArray[np.float64]


def geodetic(traj: Track, origin: Sequence[float] | None) -> Floats:
    """Return the line of a track on a map.

    Parameters
    ----------
    traj : Track
        The track, with x to the east and y to the north.
    origin : (latitude, longitude, height) or None
        Degrees and m (WGS-84); None for `traj.origin`.

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
        When there is no origin, and latitude 0, longitude 0 is assumed; when there is one, but x
        may not be east.
    """
    _check_positions(traj)
    return enu_to_geodetic(traj.position, _origin(traj, origin))[:, [1, 0, 2]]


def _origin(traj: Track, origin: Sequence[float] | None) -> Origin:
    given = check_origin(origin) if origin is not None else traj.origin
    if given is not None:
        warn_of_heading(traj.heading_known, stacklevel=3)
        return given
    warnings.warn(
        "the track has no origin and is put at latitude 0, longitude 0: "
        "set output.origin in the configuration, or save(..., origin=(latitude, longitude, "
        "height))",
        FootnavWarning,
        stacklevel=2,
    )
    return 0.0, 0.0, 0.0


def _check_positions(traj: Track) -> None:
    label = f"{traj.name}: " if traj.name else ""
    if len(traj) < 2:
        raise DataError(
            f"{label}a line on a map needs two samples or more, the track has {len(traj)}"
        )
    bad = np.flatnonzero(~np.isfinite(traj.position).all(axis=1))
    if bad.size:
        raise DataError(
            f"{label}row {bad[0]}: position is {traj.position[bad[0]]}, expected finite numbers "
            "for a map"
        )
