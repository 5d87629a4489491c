"""The options of `footnav.read` on the command line."""

import dataclasses
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from footnav.errors import ConfigError, FootnavError
from footnav.io import FORMATS, check_options, detect, read
from footnav.io.options import FEET
from footnav.io.source import Source
from footnav.recording import Recording


@Parameter(name="*", group="Reading (found in the file unless given)")
@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """How to read a recording.

    Attributes
    ----------
    format : str, optional
        Format of the file.
    rate_hz : float, optional
        Sampling rate of a file without stamps.
    columns : str, optional
        Titles or numbers from 0 of columns, such as t=Time,ax=3.
    t_unit : str, optional
        s, ms, us or ns.
    accel_unit : str, optional
        m/s^2, g or mg.
    gyro_unit : str, optional
        rad/s or deg/s.
    axes : str, optional
        The sensor's axes in terms of the file's, such as y,-x,z.
    foot : str, optional
        left or right: the sensor to read from a pair; both unless given.
    accel_range : float, optional
        Full scale of the accelerometer in g.
    gyro_range : float, optional
        Full scale of the gyroscope in deg/s.

    Raises
    ------
    ConfigError
        An option is unknown, out of range, or inconsistent with another one.
    """

    format: Annotated[str | None, Parameter(help=f"One of {', '.join(FORMATS)}.")] = None
    rate_hz: float | None = None
    columns: str | None = None
    t_unit: str | None = None
    accel_unit: str | None = None
    gyro_unit: str | None = None
    axes: str | None = None
    foot: str | None = None
    accel_range: float | None = None
    gyro_range: float | None = None

    def __post_init__(self) -> None:
        """Validate the options before any file is opened."""
        check_options(**self.options())

    def options(self) -> dict[str, Any]:
        """Return the options as `footnav.read` takes them."""
        columns = None if self.columns is None else _columns(self.columns)
        return dataclasses.asdict(self) | {"columns": columns}


AS_FOUND = Reading()
"""No options: everything is found in the file."""


def read_walks(path: Path, reading: Reading, name: str | None = None) -> dict[str, Recording]:
    """Read the recording in a file, or both where it holds a pair of feet.

    Parameters
    ----------
    path : Path
        The file.
    reading : Reading
        How to read it.
    name : str, optional
        Name of the walk; the file's, without its suffix, unless given.

    Returns
    -------
    dict of str to Recording
        The recordings by the name of the walk.  Their own names, which messages carry, are those of
        the file.

    Raises
    ------
    ConfigError, DataError
        As `footnav.read`.
    """
    name = name or path.stem
    options = reading.options()
    if reading.foot is None and _form(path, options) == "mpu6050-pair":
        return {f"{name}-{foot}": _read_foot(path, options, foot) for foot in FEET}
    return {name: read(path, **options)}


def _form(path: Path, options: dict[str, Any]) -> str | None:
    """Return the format, or None for a file that cannot be read."""
    try:
        return detect(Source(path.read_bytes(), path.name), check_options(**options))
    except (OSError, FootnavError):
        # `read` reports the error.
        return None


def _read_foot(path: Path, options: dict[str, Any], foot: str) -> Recording:
    return read(path, **(options | {"foot": foot, "name": f"{path.name}, {foot} foot"}))


def _columns(given: str) -> dict[str, str | int]:
    """Parse "t=Time,ax=3"."""
    columns: dict[str, str | int] = {}
    for part in given.split(","):
        role, _, column = (word.strip() for word in part.partition("="))
        if not (role and column) or role in columns:
            raise ConfigError(
                f"columns is {given!r}; expected each role once with its column, such as "
                "t=Time,ax=3"
            )
        columns[role] = int(column) if column.isdecimal() else column
    return columns
