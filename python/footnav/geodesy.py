"""Positions on Earth.

The origin of the navigation frame, and latitude, longitude and height (WGS-84).
"""

import warnings
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from footnav.errors import ConfigError, FootnavWarning
from footnav.optional import require

Floats = NDArray[np.float64]
Origin = tuple[float, float, float]


class Georeference(NamedTuple):
    """Relation of the navigation frame to the Earth.

    Attributes
    ----------
    origin : (latitude, longitude, height) or None
        Of the navigation frame, degrees and m (WGS-84).
    frame : {"enu", "ned"}
        Frame in which tables are written.
    heading_known : bool
        Whether x is east.
    """

    origin: Origin | None
    frame: str
    heading_known: bool


def check_origin(origin: Sequence[float]) -> Origin:
    """Validate an origin.

    Parameters
    ----------
    origin : (latitude, longitude, height)
        Degrees, degrees and m (WGS-84).

    Returns
    -------
    (latitude, longitude, height)
        As floats.

    Raises
    ------
    ConfigError
        For anything but three finite numbers within -90..90 and -180..180.
    """
    try:
        latitude, longitude, height = (float(number) for number in origin)
    except (TypeError, ValueError):
        raise ConfigError(
            f"origin is {origin!r}: expected (latitude, longitude, height) in degrees and m"
        ) from None
    if not abs(latitude) <= 90:
        raise ConfigError(f"origin: latitude is {latitude}, expected -90 to 90 degrees")
    if not abs(longitude) <= 180:
        raise ConfigError(f"origin: longitude is {longitude}, expected -180 to 180 degrees")
    if not np.isfinite(height):
        raise ConfigError(f"origin: height is {height}, expected a number in m")
    return latitude, longitude, height


def enu_to_geodetic(position: Floats, origin: Origin) -> Floats:
    """Convert local positions to latitude, longitude and height.

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


def warn_of_heading(heading_known: bool, stacklevel: int) -> None:
    """Warn of a track whose x axis may not be east; `stacklevel` as for `warnings.warn`."""
    if not heading_known:
        warnings.warn(
            "the heading at the start is not known, so the map shows the track turned about its "
            "origin: "
            "set alignment.heading_deg in the configuration, or take it from the magnetometer",
            FootnavWarning,
            stacklevel=stacklevel + 1,
        )
