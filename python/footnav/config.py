"""Settings of every stage, in the order in which a sample meets the stages.

The Rust core declares the settings, and the classes of the sections are generated from it;
``docs/settings.md`` lists them.  Everything is SI; angles are in degrees where the name ends in
``_deg``.
"""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from footnav import _core
from footnav.config_file import load_settings, save_settings
from footnav.detectors import AdaptiveShoe, Detector
from footnav.sections import (
    Alignment,
    Calibration,
    Correction,
    Filter,
    HealthLimits,
    Magnetometer,
    Mechanization,
    Output,
    Sensor,
    Smoother,
)
from footnav.settings import IDENTITY, Matrix, Settings, Vector, decode, encode

if TYPE_CHECKING:
    from footnav.recording import Recording

__all__ = [
    "DEFAULTS",
    "IDENTITY",
    "Alignment",
    "Calibration",
    "Config",
    "Correction",
    "Detector",
    "Filter",
    "HealthLimits",
    "Magnetometer",
    "Matrix",
    "Mechanization",
    "Output",
    "Sensor",
    "Smoother",
    "Vector",
    "load_config",
]


class Config(Settings, frozen=True, kw_only=True, dict=True):
    """All settings; immutable.

    Attributes
    ----------
    sensor : Sensor
        What is known of the inertial measurement unit.
    calibration : Calibration
        Correction of raw readings.
    alignment : Alignment
        The start of the walk.
    mechanization : Mechanization
        The strapdown integration.
    detector : Detector
        The stance detector: the settings of one of the kinds in ``footnav.config.Detector``.
    filter : Filter
        The error-state filter.
    magnetometer : Magnetometer
        The heading that a magnetometer holds.
    correction : Correction
        Correction of whole gait cycles.
    smoother : Smoother
        States estimated from what came later, too.
    health : HealthLimits
        When the solution is called degraded or invalid.
    output : Output
        Where the track lies on the Earth and how files are written.

    Raises
    ------
    ConfigError
        A value has the wrong type, is out of range, or is at odds with another one.

    Examples
    --------
    >>> config = Config(detector=Shoe(threshold=1e4))
    >>> config.replace(alignment=config.alignment.replace(heading_deg=90.0)).alignment.heading_deg
    90.0
    """

    sensor: Sensor = Sensor()
    calibration: Calibration = Calibration()
    alignment: Alignment = Alignment()
    mechanization: Mechanization = Mechanization()
    detector: Detector = AdaptiveShoe()
    filter: Filter = Filter()
    magnetometer: Magnetometer = Magnetometer()
    correction: Correction = Correction()
    smoother: Smoother = Smoother()
    health: HealthLimits = HealthLimits()
    output: Output = Output()

    def __post_init__(self) -> None:
        """Let the core check the values."""
        _core.check_config(self.to_json())

    @classmethod
    def preset(cls, name: str) -> Config:
        """Return the default settings with the figures of a known sensor.

        Parameters
        ----------
        name : str
            "mpu6050", "mti-g710", "stim300", "ngimu" or "vn100".

        Raises
        ------
        ConfigError
            No such preset; the message lists the known ones.
        """
        return decode(_core.preset_config(name), cls)

    @property
    def gravity(self) -> float:
        """Gravity that the settings amount to, m/s²."""
        return _core.gravity(self.to_json())

    def with_heading_from(self, recording: Recording) -> Config:
        """Return the settings with the magnetic heading of the rest at the recording's start.

        Raises
        ------
        DataError
            The recording has no magnetometer.
        """
        alignment = self.alignment.replace(
            magnetic_field=recording.mean_magnetic_field(self.alignment.duration), heading_deg=None
        )
        return self.replace(alignment=alignment)

    def to_json(self) -> bytes:
        """Return the settings as the core reads them."""
        return self._json

    @cached_property
    def _json(self) -> bytes:
        return encode(self)

    def save(self, path: str | Path) -> None:
        """Write all settings as TOML; the file is the old one or the whole new one."""
        save_settings(self, path)


DEFAULTS = Config()
"""The settings that need no tuning."""


def load_config(path: str | Path) -> Config:
    """Read settings from a TOML file; absent ones keep their defaults.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Config

    Raises
    ------
    ConfigError
        The file cannot be read, is no TOML, has an unknown key (the message names the nearest known
        one), a value of the wrong type, or one out of range.
    """
    return load_settings(Config, path)
