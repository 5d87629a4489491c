"""The formats of a track by suffix."""

import inspect
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any

from footnav.errors import ConfigError, nearest
from footnav.export.archive import write_npz
from footnav.export.geojson import write_geojson
from footnav.export.gpx import write_gpx
from footnav.export.kml import write_kml
from footnav.export.table import write_csv, write_feather, write_parquet, write_tum
from footnav.export.track import Track
from footnav.files import replacing

WRITERS: dict[str, Callable[..., None]] = {
    ".csv": write_csv,
    ".npz": write_npz,
    ".tum": write_tum,
    ".geojson": write_geojson,
    ".gpx": write_gpx,
    ".kml": write_kml,
    ".parquet": write_parquet,
    ".feather": write_feather,
}
"""The writer of each suffix."""


def save(traj: Track, path: str | PathLike[str], **options: Any) -> None:
    """Write a track to a file whose suffix names the format.

    Parameters
    ----------
    traj : Track
        The track.
    path : path
        ``.csv``, ``.tum``, ``.parquet``, ``.feather``: the states as a table; option `frame`, "enu"
        or "ned" (default: `traj.frame`).  All of them but ``.tum`` also have latitude_deg,
        longitude_deg and height where origin and heading are known.  ``.npz``: everything, read
        back by `footnav.load_trajectory`; no options.  ``.geojson``, ``.gpx``, ``.kml``: latitude,
        longitude and height; option `origin`, (latitude, longitude, height) in degrees and m
        (default: `traj.origin`).
    **options
        Those of the format.  ``.geojson`` has `stances` (bool: a point for each stance), ``.gpx``
        has `start_time` (datetime with a time zone, that of the first sample; without it the points
        have no time).

    Raises
    ------
    ConfigError
        For an unknown suffix, an option that the format does not have, or an impossible value of
        one.
    DataError
        For a track that the format cannot represent.
    FootnavError
        For a file that cannot be written, which leaves an existing one unchanged, or a missing
        library.

    Warns
    -----
    FootnavWarning
        When a geographic file is written without an origin.
    """
    path = Path(path)
    writer = WRITERS.get(path.suffix.lower())
    if writer is None:
        raise ConfigError(
            f"{path}: unknown suffix {path.suffix!r}, expected one of {', '.join(WRITERS)}"
        )
    _check_options(path, writer, options)
    with replacing(path) as file:
        writer(traj, file, **options)


def _check_options(path: Path, writer: Callable[..., None], options: dict[str, Any]) -> None:
    known = list(inspect.signature(writer).parameters)[2:]
    for option in options:
        if option not in known:
            expected = ", ".join(known) or "no options"
            raise ConfigError(
                f"{path}: {path.suffix} has {expected}, not {option!r}{nearest(option, known)}"
            )
