"""Calibrations of imucal: JSON files of a Ferraris or a turntable calibration.

imucal's model is raw = K R truth + b, with another term K_ga f of the gyroscope's; accelerometer in
m/s² and gyroscope in deg/s.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from footnav.calibration.model import SensorCalibration, Triad
from footnav.conversions import as_matrix, as_vector
from footnav.errors import ConfigError, FootnavWarning
from footnav.io.units import ACCEL, GYRO, Quantity
from footnav.recording import Floats

KINDS = ("Ferraris", "Turntable")
SHAPES = {
    "K_a": (3, 3),
    "R_a": (3, 3),
    "b_a": (3,),
    "K_g": (3, 3),
    "R_g": (3, 3),
    "b_g": (3,),
    "K_ga": (3, 3),
}


def load_imucal(path: str | PathLike[str]) -> SensorCalibration:
    """Read a calibration that imucal wrote (format 2).

    Parameters
    ----------
    path : path
        JSON file of `FerrarisCalibrationInfo` or `TurntableCalibrationInfo`.

    Returns
    -------
    SensorCalibration
        In SI units.

    Raises
    ------
    ConfigError
        The file cannot be read, is of another kind, lacks a matrix, or is for raw counts.

    Warns
    -----
    FootnavWarning
        The gyroscope's sensitivity to acceleration, which footnav does not correct, is left out.
    """
    path = Path(path)
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror or error}") from error
    except ValueError as error:
        raise ConfigError(f"{path}: not a JSON file: {error}") from error
    kind = content.get("cal_type") if isinstance(content, dict) else None
    if kind not in KINDS:
        raise ConfigError(f"{path}: cal_type is {kind!r}; expected {' or '.join(KINDS)}")
    arrays = {label: _array(path, content, label) for label in SHAPES}
    if arrays["K_ga"].any():
        largest = float(np.abs(arrays["K_ga"]).max())
        warnings.warn(
            FootnavWarning(
                f"{path}: K_ga, up to {largest:.3g} deg/s per m/s^2, is left out: footnav has no "
                "such term"
            ),
            stacklevel=2,
        )
    accel = _triad(path, content, arrays, "acc", ACCEL)
    gyro = _triad(path, content, arrays, "gyr", GYRO)
    return SensorCalibration(accel=accel, gyro=gyro)


def _array(path: Path, content: Mapping[str, Any], label: str) -> Floats:
    try:
        values = np.array(content.get(label), dtype=np.float64)
    except (TypeError, ValueError):
        values = np.empty(0)
    if values.shape != SHAPES[label] or not np.isfinite(values).all():
        raise ConfigError(
            f"{path}: {label} is {content.get(label)!r}; expected numbers of shape {SHAPES[label]}"
        )
    return values


def _triad(
    path: Path,
    content: Mapping[str, Any],
    arrays: dict[str, Floats],
    sensor: str,
    quantity: Quantity,
) -> Triad:
    read, meant = (
        _unit(path, content, label, quantity) for label in (f"from_{sensor}_unit", f"{sensor}_unit")
    )
    letter = sensor[0]
    try:
        inverse = np.linalg.inv(arrays[f"K_{letter}"] @ arrays[f"R_{letter}"])
    except np.linalg.LinAlgError:
        raise ConfigError(f"{path}: K_{letter} times R_{letter} cannot be inverted") from None
    return Triad(
        matrix=as_matrix(inverse * meant / read),
        bias=as_vector(arrays[f"b_{letter}"] * read),
        note=f"imucal, {content['cal_type']}",
    )


def _unit(path: Path, content: Mapping[str, Any], label: str, quantity: Quantity) -> float:
    """Return the SI value of one of the unit that the file names."""
    unit = quantity.unit_of(str(content.get(label)))
    if unit is None:
        raise ConfigError(
            f"{path}: {label} is {content.get(label)!r}; expected one of "
            f"{', '.join(quantity.scale)}: a calibration of "
            "raw counts holds for one full scale only, repeat it with readings in these units"
        )
    return quantity.scale[unit]
