"""The options of `footnav.io.read`, checked before a file is opened."""

import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from footnav.errors import ConfigError, nearest
from footnav.io.header import ROLES
from footnav.io.units import ACCEL, GYRO, TIME
from footnav.recording import Floats

FEET = ("left", "right")


@dataclass(frozen=True, slots=True, kw_only=True)
class Options:
    """Options of `footnav.io.read`, which documents them.

    The format is only stored; the registry of formats validates it.

    Raises
    ------
    ConfigError
        A value is unknown, out of range, or inconsistent with another one.
    """

    format: str | None = None
    rate_hz: float | None = None
    columns: Mapping[str, str | int] | None = None
    t_unit: str | None = None
    accel_unit: str | None = None
    gyro_unit: str | None = None
    axes: str | None = None
    foot: str | None = None
    accel_range: float | None = None
    gyro_range: float | None = None

    def __post_init__(self) -> None:
        """Validate the values."""
        check_choice("t_unit", self.t_unit, TIME.scale)
        check_choice("accel_unit", self.accel_unit, ACCEL.scale)
        check_choice("gyro_unit", self.gyro_unit, GYRO.scale)
        check_choice("foot", self.foot, FEET)
        for label in ("rate_hz", "accel_range", "gyro_range"):
            _check_positive(label, getattr(self, label))
        if self.columns is not None:
            _check_columns(self.columns)
        if self.axes is not None:
            rotation(self.axes)

    def refuse(self, form: str, *labels: str) -> None:
        """Raise ConfigError if an option is given that does not apply to format `form`."""
        for label in labels:
            if getattr(self, label) is not None:
                raise ConfigError(
                    f"{label} has no meaning for a file of format {form!r}; leave it out"
                )


def rotation(axes: str) -> Floats:
    """Convert "y,-x,z" to the matrix whose rows are the sensor's axes in terms of the file's.

    Parameters
    ----------
    axes : str
        The file's column, with its sign, that each of the sensor's axes x, y and z is.

    Returns
    -------
    ndarray, shape (3, 3)
        Rotation matrix of entries -1, 0 and 1.

    Raises
    ------
    ConfigError
        The text is not three signed letters, or the axes are not right-handed.
    """
    parts = re.fullmatch(
        r"\s*([+-]?[xyz])\s*,\s*([+-]?[xyz])\s*,\s*([+-]?[xyz])\s*", axes, re.IGNORECASE
    )
    if not parts:
        raise ConfigError(
            f'axes is {axes!r}; expected three of x, y, z with their signs, such as "y,-x,z"'
        )
    matrix = np.zeros((3, 3))
    for row, part in enumerate(parts.groups()):
        matrix[row, "xyz".index(part[-1].lower())] = -1.0 if part[0] == "-" else 1.0
    determinant = round(float(np.linalg.det(matrix)))
    if determinant == 0:
        raise ConfigError(f"axes is {axes!r}; each of x, y and z must appear once")
    if determinant < 0:
        raise ConfigError(
            f"axes is {axes!r}, which mirrors the sensor; a right-handed one has one sign fewer "
            "or more"
        )
    return matrix


def check_choice(label: str, value: object, known: Collection[str]) -> None:
    """Raise ConfigError for an option that is given and is not one of the known values."""
    if value is not None and value not in known:
        raise ConfigError(
            f"{label} is {value!r}; expected one of {', '.join(known)}{nearest(str(value), known)}"
        )


def _check_positive(label: str, value: object) -> None:
    if value is None:
        return
    number = float(value) if isinstance(value, int | float | np.integer | np.floating) else math.nan
    if isinstance(value, bool) or not (math.isfinite(number) and number > 0):
        raise ConfigError(f"{label} is {value!r}; expected a positive number")


def _check_columns(columns: Mapping[str, str | int]) -> None:
    for role, column in columns.items():
        if role not in ROLES:
            raise ConfigError(
                f"columns names {role!r}; expected one of "
                f"{', '.join(ROLES)}{nearest(str(role), ROLES)}"
            )
        if isinstance(column, bool) or not isinstance(column, str | int):
            raise ConfigError(
                f"columns[{role!r}] is {column!r}; expected the title or the number of a column"
            )
