"""Raw counts of one or two MPU6050s: ms, then ax ay az gx gy gz of each sensor, left foot first.

No header.

The counts are 16-bit; their full scale has to be given.
"""

from types import MappingProxyType

import numpy as np

from footnav.errors import ConfigError, DataError
from footnav.io import delimited
from footnav.io.header import CANONICAL, REQUIRED
from footnav.io.options import Options
from footnav.io.samples import Samples, stamps
from footnav.io.source import Source
from footnav.io.text import Table
from footnav.io.units import ACCEL, GYRO
from footnav.recording import Floats

ACCEL_RANGES = (2, 4, 8, 16)
"""Full scales of the accelerometer, g."""

GYRO_RANGES = (250, 500, 1000, 2000)
"""Full scales of the gyroscope, deg/s."""

FULL_SCALE_COUNTS = 32768

SENSORS = MappingProxyType({"mpu6050": 1, "mpu6050-pair": 2})
"""Sensors of each format."""


def sniff(source: Source, options: Options, form: str) -> bool:
    """Whether a table has no titles, integers only, and the columns of the format."""
    if options.columns:
        return False
    table = source.table
    fits = not table.titles and table.width == 1 + SENSORS[form] * len(REQUIRED)
    return fits and not any("." in line for line in table.lines[:100])


def read(source: Source, options: Options, form: str) -> Samples:
    """Read raw counts.

    Parameters
    ----------
    source : Source
        The file; stamps in ms unless `options.t_unit` is given.
    options : Options
        Must have the two ranges, and the foot for a pair.
    form : {"mpu6050", "mpu6050-pair"}
        One sensor or two.

    Returns
    -------
    Samples
        Along the axes of the sensor, with its full scales.

    Raises
    ------
    ConfigError
        A range or the foot is missing or not one of the sensor's, or an option does not fit the
        format.
    DataError
        A column is missing, or a value is not a 16-bit integer.
    """
    options.refuse(
        form, "accel_unit", "gyro_unit", *(["foot"] if form == "mpu6050" else ["columns"])
    )
    table = source.table
    accel_range = _full_scale(table.name, "accel_range", "g", options.accel_range, ACCEL_RANGES)
    gyro_range = _full_scale(table.name, "gyro_range", "deg/s", options.gyro_range, GYRO_RANGES)
    columns = _columns(table, options, form)
    counts = _counts(table, columns)
    t = delimited.read_time(table, columns, options.t_unit, default="ms")
    full_scale_accel, full_scale_gyro = (
        accel_range * ACCEL.scale["g"],
        gyro_range * GYRO.scale["deg/s"],
    )
    return Samples(
        t=stamps(table.name, t, len(counts), options.rate_hz),
        accel=counts[:, :3] / FULL_SCALE_COUNTS * full_scale_accel,
        gyro=counts[:, 3:] / FULL_SCALE_COUNTS * full_scale_gyro,
        accel_range=full_scale_accel,
        gyro_range=full_scale_gyro,
    )


def _full_scale(
    name: str, label: str, unit: str, value: float | None, known: tuple[int, ...]
) -> float:
    choices = ", ".join(map(str, known))
    if value is None:
        raise ConfigError(
            f"{name} holds raw counts, whose range is not in the file; give {label} in {unit}: "
            f"{choices}"
        )
    if value not in known:
        raise ConfigError(f"{label} is {value:g} {unit}; an MPU6050 has {choices}")
    return value


def _columns(table: Table, options: Options, form: str) -> delimited.Columns:
    if form == "mpu6050" and (table.titles or options.columns):
        return delimited.locate(table, options.columns or {})
    if table.titles:
        titles = ", ".join(repr(title.text) for title in table.titles)
        raise DataError(
            f"{table.name}: a file of format {form!r} has no header, but this one has {titles}"
        )
    samples = SENSORS[form] * len(REQUIRED)
    if table.width not in (samples, samples + 1):
        raise DataError(
            f"{table.name} has {table.width} columns; format {form!r} has ms and {samples} counts"
        )
    stamped = table.width - samples
    first = stamped + _sensor(table.name, options, form) * len(REQUIRED)
    columns = {role: first + k for k, role in enumerate(REQUIRED)}
    return columns | {CANONICAL[0]: 0} if stamped else columns


def _sensor(name: str, options: Options, form: str) -> int:
    if form == "mpu6050":
        return 0
    if options.foot is None:
        raise ConfigError(
            f'{name} holds the sensors of both feet; give foot="left" or foot="right"'
        )
    return ("left", "right").index(options.foot)


def _counts(table: Table, columns: delimited.Columns) -> Floats:
    indices = [columns[role] for role in REQUIRED]
    counts = table.columns(indices)
    bad = np.argwhere(
        (counts != np.rint(counts)) | (counts < -FULL_SCALE_COUNTS) | (counts >= FULL_SCALE_COUNTS)
    )
    if bad.size:
        row, column = bad[0]
        raise DataError(
            f"{table.name}, line {table.numbers[row]}: {table.title(indices[column])} is "
            f"{counts[row, column]:.10g}; "
            f"expected a count from {-FULL_SCALE_COUNTS} to {FULL_SCALE_COUNTS - 1}"
        )
    return counts
