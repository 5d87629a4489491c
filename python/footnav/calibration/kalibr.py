"""Kalibr's ``imu.yaml``: noise figures, and intrinsics of a scale-misalignment calibration.

Kalibr's model is raw = M f + b of the accelerometer and raw = M C w + A C f + b of the gyroscope, M
lower triangular and C the rotation from the accelerometer's frame to the gyroscope's; J. Rehder et
al., "Extending kalibr: calibrating the extrinsics of multiple IMUs and of individual axes", ICRA
2016.  It has no constant bias.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from footnav.calibration.model import SensorCalibration, Triad
from footnav.config import Sensor
from footnav.conversions import as_matrix
from footnav.errors import ConfigError, FootnavWarning
from footnav.files import replacing
from footnav.optional import require
from footnav.recording import Floats

NOISE = MappingProxyType(
    {
        "accelerometer_noise_density": "accel_noise_density",
        "accelerometer_random_walk": "accel_bias_walk",
        "gyroscope_noise_density": "gyro_noise_density",
        "gyroscope_random_walk": "gyro_bias_walk",
    }
)
"""Setting of `Sensor` that each of Kalibr's figures is; the units are the same."""

MODEL = "scale-misalignment"


@dataclass(frozen=True, slots=True)
class KalibrImu:
    """Content of an ``imu.yaml``.

    Attributes
    ----------
    sensor : Sensor
        Noise parameters; those that Kalibr does not have are the defaults.
    calibration : SensorCalibration, optional
        Intrinsics, without bias; None where the file has none.
    rate_hz : float
        Samples per second.
    topic : str
        ROS topic.
    """

    sensor: Sensor
    calibration: SensorCalibration | None
    rate_hz: float
    topic: str


def load_kalibr(path: str | PathLike[str]) -> KalibrImu:
    """Read an ``imu.yaml``, given to Kalibr or written by it.

    Parameters
    ----------
    path : path
        YAML file of one IMU, or of a set whose first is ``imu0``.

    Returns
    -------
    KalibrImu

    Raises
    ------
    ConfigError
        The file cannot be read, is no YAML, lacks a figure, or has an impossible one.

    Warns
    -----
    FootnavWarning
        The gyroscope's sensitivity to acceleration, which footnav does not correct, is left out.
    """
    path = Path(path)
    content = _load(path)
    content = content.get("imu0", content)
    figures = {ours: _number(path, content, theirs) for theirs, ours in NOISE.items()}
    return KalibrImu(
        sensor=Sensor(**figures),
        calibration=_intrinsics(path, content),
        rate_hz=_number(path, content, "update_rate"),
        topic=str(content.get("rostopic", "")),
    )


def save_kalibr(
    path: str | PathLike[str],
    sensor: Sensor,
    rate_hz: float,
    calibration: SensorCalibration | None = None,
    topic: str = "/imu0",
) -> None:
    """Write an ``imu.yaml``.

    Parameters
    ----------
    path : path
        The file, written atomically.
    sensor : Sensor
        Noise figures.
    rate_hz : float
        Samples per second.
    calibration : SensorCalibration, optional
        Intrinsics.  The format has neither biases nor a dependence on temperature.
    topic : str
        ROS topic.

    Raises
    ------
    ConfigError
        The accelerometer's matrix is not lower triangular, as Kalibr's is.
    FootnavError
        The file cannot be written.
    """
    yaml = require("yaml", "PyYAML")
    content: dict[str, Any] = {theirs: getattr(sensor, ours) for theirs, ours in NOISE.items()}
    content |= {"rostopic": topic, "update_rate": float(rate_hz)}
    if calibration is not None:
        content |= _kalibr_intrinsics(calibration)
    with replacing(path) as file:
        file.write(yaml.safe_dump(content, sort_keys=False).encode())


def _load(path: Path) -> dict[str, Any]:
    yaml = require("yaml", "PyYAML")
    try:
        content = yaml.safe_load(path.read_bytes())
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror or error}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise ConfigError(f"{path}: not a YAML file: {' '.join(str(error).split())}") from error
    if not isinstance(content, dict) or not isinstance(content.get("imu0", content), dict):
        raise ConfigError(
            f"{path}: expected keys such as update_rate: this is not Kalibr's imu.yaml"
        )
    return content


def _number(path: Path, content: Mapping[str, Any], key: str) -> float:
    value = content.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < np.inf:
        raise ConfigError(f"{path}: {key} is {value!r}; expected a positive number")
    return float(value)


def _intrinsics(path: Path, content: Mapping[str, Any]) -> SensorCalibration | None:
    if "accelerometers" not in content or "gyroscopes" not in content:
        return None
    accel = _matrix(path, content, "accelerometers", "M")
    scale = _matrix(path, content, "gyroscopes", "M")
    turn = _matrix(path, content, "gyroscopes", "C_gyro_i")
    coupling = _matrix(path, content, "gyroscopes", "A")
    if coupling.any():
        largest = float(np.abs(coupling).max())
        warnings.warn(
            FootnavWarning(
                f"{path}: gyroscopes.A, up to {largest:.3g} (rad/s)/(m/s^2), is left out: no such "
                "term"
            ),
            stacklevel=3,
        )
    note = "Kalibr; the bias is not known"
    try:
        return SensorCalibration(
            accel=Triad(matrix=as_matrix(np.linalg.inv(accel)), note=note),
            gyro=Triad(matrix=as_matrix(np.linalg.inv(scale @ turn)), note=note),
        )
    except (np.linalg.LinAlgError, ConfigError) as error:
        raise ConfigError(f"{path}: M cannot be inverted: {error}") from None


def _matrix(path: Path, content: Mapping[str, Any], sensor: str, key: str) -> Floats:
    section = content[sensor]
    value = section.get(key) if isinstance(section, dict) else None
    try:
        matrix = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        matrix = np.empty(0)
    if matrix.shape != (3, 3) or not np.isfinite(matrix).all():
        raise ConfigError(
            f"{path}: {sensor}.{key} is {value!r}; expected three rows of three numbers"
        )
    return matrix


def _kalibr_intrinsics(calibration: SensorCalibration) -> dict[str, Any]:
    accel, gyro = (
        np.linalg.inv(np.array((triad or Triad()).matrix))
        for triad in (calibration.accel, calibration.gyro)
    )
    if np.abs(np.triu(accel, 1)).max() > 1e-9:
        raise ConfigError(
            "the accelerometer's matrix is not lower triangular, as Kalibr's is; calibrate it "
            "from poses"
        )
    # M C = gyro with C a rotation and M lower triangular with a positive diagonal: the RQ
    # decomposition's mirror image.
    orthogonal, upper = np.linalg.qr(gyro.T)
    signs = np.sign(np.diag(upper))
    return {
        "model": MODEL,
        "accelerometers": {"M": accel.tolist()},
        "gyroscopes": {
            "M": (upper.T * signs).tolist(),
            "C_gyro_i": (orthogonal * signs).T.tolist(),
            "A": np.zeros((3, 3)).tolist(),
        },
    }
