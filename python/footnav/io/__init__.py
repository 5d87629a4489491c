"""Readers of recordings: files of samples to validated recordings in SI units."""

import dataclasses
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from footnav.errors import DataError
from footnav.io import delimited, euroc, mpu6050, npz, xio
from footnav.io.options import Options, check_choice, rotation
from footnav.io.samples import Samples
from footnav.io.source import Source
from footnav.recording import STANDARD_GRAVITY, Recording

__all__ = ["read"]


@dataclass(frozen=True, slots=True)
class Format:
    """A format of recordings.

    Attributes
    ----------
    read : callable
        Reads a file of the format.
    sniff : callable, optional
        Whether a file is of the format; without it the format is read only when it is named.
    """

    read: Callable[[Source, Options], Samples]
    sniff: Callable[[Source, Options], bool] = lambda source, options: False


FORMATS: Mapping[str, Format] = {
    "npz": Format(npz.read, npz.sniff),
    "euroc": Format(euroc.read, euroc.sniff),
    "xio": Format(xio.read),
    **{
        form: Format(partial(mpu6050.read, form=form), partial(mpu6050.sniff, form=form))
        for form in mpu6050.SENSORS
    },
    "csv": Format(delimited.read, lambda source, options: True),
}
"""The formats by name, in the order of detection."""


def read(
    path: str | os.PathLike[str],
    *,
    format: str | None = None,
    rate_hz: float | None = None,
    columns: Mapping[str, str | int] | None = None,
    t_unit: str | None = None,
    accel_unit: str | None = None,
    gyro_unit: str | None = None,
    axes: str | None = None,
    foot: str | None = None,
    accel_range: float | None = None,
    gyro_range: float | None = None,
    name: str | None = None,
) -> Recording:
    """Read a recording from a file.

    The format, the delimiter, the columns and the units are found in the file where they are
    unambiguous.  Otherwise the error names the option that is needed.

    Parameters
    ----------
    path : str or path-like
        The file.
    format : {"npz", "euroc", "xio", "mpu6050", "mpu6050-pair", "csv"}, optional
        "npz": arrays t, accel, gyro and optionally mag, pressure, temperature, in SI units (mag
        also in uT).  "euroc": the IMU files of the EuRoC MAV dataset, whose stamps are integers in
        ns; t counts from the first sample.  "xio": the CSV files of x-io Technologies.  "mpu6050":
        raw counts without a header, ms, ax, ay, az, gx, gy, gz; needs both ranges.
        "mpu6050-pair": the same with the counts of the left foot, then of the right one; needs
        `foot` too.  "csv": a header such as footnav's own "t,ax,ay,az,gx,gy,gz", or one of many
        other spellings, with units such as "(deg/s)" or "[g]".
    rate_hz : float, optional
        Sampling rate, Hz, for a file that has no stamps, and only for such a file.
    columns : mapping, optional
        Title, or number from 0, of the column that is "t", "ax", "ay", "az", "gx", "gy", "gz",
        "mx", "my", "mz", "pressure" or "temperature"; the others are found by their titles.
    t_unit : {"s", "ms", "us", "ns"}, optional
        Unit of the stamps; overrides the header.
    accel_unit : {"m/s^2", "g", "mg"}, optional
        Unit of the accelerometer; overrides the header.
    gyro_unit : {"rad/s", "deg/s"}, optional
        Unit of the gyroscope; overrides the header.
    axes : str, optional
        The sensor's own axes in terms of the file's columns, such as "y,-x,z"; a right-handed
        rotation.
    foot : {"left", "right"}, optional
        The sensor to read from a file of format "mpu6050-pair".
    accel_range, gyro_range : float, optional
        Full scale of the sensors, g and deg/s.
    name : str, optional
        Name of the recording; the file's name unless given.

    Returns
    -------
    Recording
        In SI units, along the sensor's own axes.

    Raises
    ------
    ConfigError
        An option is unknown, missing, or does not fit the file.
    DataError
        The file cannot be read, or its content cannot be used as it is; the message names the file
        and the line.

    Warns
    -----
    FootnavWarning
        The last line is truncated, or an optional sensor has unusable values, and is left out.
    """
    options = check_options(
        format=format,
        rate_hz=rate_hz,
        columns=columns,
        t_unit=t_unit,
        accel_unit=accel_unit,
        gyro_unit=gyro_unit,
        axes=axes,
        foot=foot,
        accel_range=accel_range,
        gyro_range=gyro_range,
    )
    path = Path(path)
    source = Source(_load(path), path.name)
    samples = FORMATS[detect(source, options)].read(source, options)
    recording = _recording(samples, path.name, options)
    return recording if name is None else dataclasses.replace(recording, name=name)


def check_options(**given: Any) -> Options:
    """Validate the options of `read` before a file is opened.

    Parameters
    ----------
    **given
        The options by name.

    Returns
    -------
    Options

    Raises
    ------
    ConfigError
        A value is unknown, out of range, or inconsistent with another one.
    """
    check_choice("format", given.get("format"), FORMATS)
    return Options(**given)


def detect(source: Source, options: Options) -> str:
    """Return the format in the options, or else the first one that fits the file.

    Parameters
    ----------
    source : Source
        The file.
    options : Options
        The options of the caller.

    Returns
    -------
    str
        A key of `FORMATS`.

    Raises
    ------
    DataError
        The file is neither text nor of a binary format.
    """
    return options.format or next(
        form for form, entry in FORMATS.items() if entry.sniff(source, options)
    )


def _load(path: Path) -> bytes:
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        raise DataError(f"{path} does not exist") from None
    except IsADirectoryError:
        raise DataError(f"{path} is a folder; expected a file") from None
    except OSError as error:
        raise DataError(f"{path} cannot be read: {error.strerror}") from None
    if not data.strip():
        raise DataError(f"{path.name} is empty")
    return data


def _recording(samples: Samples, name: str, options: Options) -> Recording:
    """Validate the recording along the axes of the file, and rotate it to those of the sensor."""
    ranges = {
        "accel_range": _accel_range(samples, options),
        "gyro_range": _gyro_range(samples, options),
    }
    fields = {field.name: getattr(samples, field.name) for field in dataclasses.fields(samples)}
    recording = Recording(**(fields | ranges), name=name)
    return recording if options.axes is None else _turn(recording, options.axes)


def _accel_range(samples: Samples, options: Options) -> float | None:
    given = options.accel_range
    return samples.accel_range if given is None else given * STANDARD_GRAVITY


def _gyro_range(samples: Samples, options: Options) -> float | None:
    given = options.gyro_range
    return samples.gyro_range if given is None else math.radians(given)


def _turn(recording: Recording, axes: str) -> Recording:
    matrix = rotation(axes).T
    triads = {label: getattr(recording, label) for label in ("accel", "gyro", "mag")}
    turned = {label: triad @ matrix for label, triad in triads.items() if triad is not None}
    return dataclasses.replace(recording, **turned)
