"""Calibration files of all known formats, by suffix."""

from os import PathLike
from pathlib import Path

from footnav.calibration.imucal import load_imucal
from footnav.calibration.kalibr import load_kalibr
from footnav.calibration.model import SensorCalibration, load_calibration
from footnav.errors import ConfigError


def read_calibration(path: str | PathLike[str]) -> SensorCalibration:
    """Read a calibration of footnav (``.toml``), Kalibr (``.yaml``) or imucal (``.json``).

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    SensorCalibration
        In SI units.

    Raises
    ------
    ConfigError
        The suffix is unknown, or the file cannot be read or has no calibration.
    """
    path = Path(path)
    match path.suffix.lower():
        case ".toml":
            return load_calibration(path)
        case ".json":
            return load_imucal(path)
        case ".yaml" | ".yml":
            calibration = load_kalibr(path).calibration
            if calibration is None:
                raise ConfigError(
                    f"{path}: holds noise figures, but no scale or misalignment to correct "
                    "readings with"
                )
            return calibration
        case other:
            raise ConfigError(
                f"{path}: unknown suffix {other!r}, expected .toml, .yaml (Kalibr) or .json "
                "(imucal)"
            )
