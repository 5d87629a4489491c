"""A sensor's calibration.

Corrections with their uncertainty and validity, and their application.
"""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

import msgspec
import numpy as np

from footnav import _core
from footnav.config import IDENTITY, Calibration, Matrix, Vector
from footnav.config_file import load_settings, save_settings
from footnav.errors import ConfigError, DataError
from footnav.mpu6050 import Setup
from footnav.recording import Floats, Recording
from footnav.settings import Settings, encode

if TYPE_CHECKING:
    from os import PathLike

SENSORS = {"accel": "accelerometer", "gyro": "gyroscope", "mag": "magnetometer"}
"""Name of each sensor in messages, by its name in a recording."""

RANGE_TOLERANCE = 0.01
"""Relative difference of two full scales that count as equal: the rounding of g differs."""


class TemperatureModel(Settings, frozen=True, kw_only=True):
    """Bias and scale of a sensor as functions of the temperature of its die.

    Both are polynomials of T - `reference` without a constant term.

    Attributes
    ----------
    reference : float
        Temperature at which the matrix and the bias of the sensor hold, degrees Celsius.
    lowest, highest : float
        Span of the measured temperatures, degrees Celsius.
    margin : float
        Margin beyond them in which the model is applied, K.
    bias : tuple of rows
        Coefficients of the change of the bias, the linear one first, per axis, unit of the
        sensor/K^k.
    scale : tuple of rows
        Coefficients of the relative change of the sensitivity, per axis, 1/K^k.
    bias_std, scale_std : tuple of rows
        Their standard deviations.
    residual : float
        Root mean square of the residuals, unit of the sensor.
    """

    reference: float
    lowest: float
    highest: float
    margin: float = 2.0
    bias: tuple[Vector, ...] = ()
    scale: tuple[Vector, ...] = ()
    bias_std: tuple[Vector, ...] = ()
    scale_std: tuple[Vector, ...] = ()
    residual: float = 0.0


class Triad(Settings, frozen=True, kw_only=True):
    """Correction M (raw - b) of the three axes of one sensor; the unit u is m/s², rad/s or T.

    Attributes
    ----------
    matrix : tuple of 3 rows
        Scale and misalignment M: scale on the diagonal, misalignment (rad) beside it.
    bias : tuple of 3 floats
        Bias b, u.
    matrix_std : tuple of 3 rows, optional
        Standard deviation of each element of M; absent when M was not measured.
    bias_std : tuple of 3 floats, optional
        Standard deviation of the bias, u; absent when it was not measured.
    residual : float, optional
        Root mean square of the residuals, u; of a gyroscope's rotations rad.
    condition : float, optional
        Condition number of the estimate, columns scaled to length one: large where errors are
        nearly indistinguishable in the data.
    observations : int
        Number of rests, rotations or samples that the estimate is based on.
    range : float, optional
        Full scale at which it was measured, u.
    temperature : float, optional
        Mean temperature at which it was measured, degrees Celsius.
    date : str
        Day of the recording or of the estimate, such as 2026-01-31.
    note : str
        Limits of the calibration and their reasons.
    thermal : TemperatureModel, optional
        Dependence on temperature.
    """

    matrix: Matrix = IDENTITY
    bias: Vector = (0.0, 0.0, 0.0)
    matrix_std: Matrix | None = None
    bias_std: Vector | None = None
    residual: float | None = None
    condition: float | None = None
    observations: int = 0
    range: float | None = None
    temperature: float | None = None
    date: str = ""
    note: str = ""
    thermal: TemperatureModel | None = None

    def correct(self, raw: Floats, temperature: Floats | None = None) -> Floats:
        """Return corrected readings.

        Parameters
        ----------
        raw : ndarray, shape (n, 3)
            Readings of the sensor, u.
        temperature : ndarray, shape (n,), optional
            Temperature of the die, degrees Celsius; needed for a correction over temperature.

        Returns
        -------
        ndarray, shape (n, 3)
            u.

        Raises
        ------
        DataError
            The temperature is missing or outside the calibrated span.
        """
        return _core.calibrate(self._json(), raw, temperature)

    def at(self, temperature: float | None) -> Triad:
        """Return the fixed correction at one temperature (degrees Celsius)."""
        fixed = msgspec.json.decode(
            _core.calibration_at(self._json(), temperature), type=_Correction
        )
        return self.replace(matrix=fixed.matrix, bias=fixed.bias, thermal=None)

    def _json(self) -> bytes:
        thermal = self.thermal and {
            key: getattr(self.thermal, key)
            for key in ("reference", "lowest", "highest", "margin", "bias", "scale")
        }
        return encode({"matrix": self.matrix, "bias": self.bias, "thermal": thermal})


class _Correction(msgspec.Struct):
    """The correction that the core returns."""

    matrix: Matrix
    bias: Vector


class SensorCalibration(Settings, frozen=True, kw_only=True):
    """The calibration of the sensors of one device.

    Attributes
    ----------
    device : str
        Name of the device; empty when unknown.
    gravity : float, optional
        Gravity that the accelerometer was measured against, m/s².
    mpu6050 : Setup, optional
        Registers of an MPU6050 that the recording was made with.
    accel, gyro, mag : Triad, optional
        Correction of each sensor, m/s², rad/s and T; absent when it was not calibrated.

    Raises
    ------
    ConfigError
        A number is out of range.
    """

    device: str = ""
    gravity: float | None = None
    mpu6050: Setup | None = None
    accel: Triad | None = None
    gyro: Triad | None = None
    mag: Triad | None = None

    def __post_init__(self) -> None:
        """Validate the numbers in the core."""
        for label, triad in self.triads().items():
            try:
                triad.correct(np.empty((0, 3)), np.empty(0))
            except ConfigError as error:
                raise ConfigError(f"{label}.{error}") from None

    def triads(self) -> dict[str, Triad]:
        """Return the existing corrections by the sensor's name in a recording."""
        found = {label: getattr(self, label) for label in SENSORS}
        return {label: triad for label, triad in found.items() if triad is not None}

    def apply(
        self, recording: Recording, *, device: str | None = None, temperature: float | None = None
    ) -> Recording:
        """Correct a recording.

        Parameters
        ----------
        recording : Recording
            Uncorrected samples.
        device : str, optional
            Device that made the recording; checked against the calibration's when both are known.
        temperature : float, optional
            Temperature of the sensor, degrees Celsius, for a recording without a thermometer.

        Returns
        -------
        Recording
            The same samples, corrected.  Its full scales are those of the least sensitive axis, so
            that clipped samples are still at or above them.

        Raises
        ------
        ConfigError
            The calibration is for another device or another full scale.
        DataError
            The temperature is missing or outside the calibrated span.
        """
        self.check(recording, device)
        given = None if temperature is None else np.full(len(recording), float(temperature))
        celsius = given if recording.temperature is None else recording.temperature
        changes: dict[str, Any] = self._corrected_ranges(recording)
        try:
            for label, triad in self.triads().items():
                raw = getattr(recording, label)
                if raw is not None:
                    changes[label] = triad.correct(raw, celsius)
        except DataError as error:
            raise DataError(
                f"{recording.name or 'the recording'}: {SENSORS[label]}: {error}"
            ) from None
        return dataclasses.replace(recording, **changes)

    def check(self, recording: Recording, device: str | None = None) -> None:
        """Raise ConfigError if the recording is of another device or another full scale."""
        name = recording.name or "the recording"
        if device and self.device and device != self.device:
            raise ConfigError(
                f"{name} is of device {device!r}, but the calibration is of {self.device!r}"
            )
        for label, triad in self.triads().items():
            full_scale: float | None = getattr(recording, f"{label}_range", None)
            if full_scale and triad.range and abs(full_scale / triad.range - 1) > RANGE_TOLERANCE:
                unit = "m/s^2" if label == "accel" else "rad/s"
                raise ConfigError(
                    f"{name} was made at {label}_range {full_scale:.4g} {unit}, but the "
                    "calibration at "
                    f"{triad.range:.4g} {unit}; each range has its own errors: calibrate at the "
                    "one that you record at"
                )

    def config(self, temperature: float | None = None) -> Calibration:
        """Return settings with which the navigator corrects samples, for streaming.

        Parameters
        ----------
        temperature : float, optional
            Temperature of the sensor, degrees Celsius; needed for a calibration over temperature.

        Returns
        -------
        footnav.config.Calibration
            Matrices and biases at that temperature.

        Raises
        ------
        DataError
            The temperature is missing or outside the calibrated span.
        """
        accel, gyro = ((triad or Triad()).at(temperature) for triad in (self.accel, self.gyro))
        return Calibration(
            accel_matrix=accel.matrix,
            accel_bias=accel.bias,
            gyro_matrix=gyro.matrix,
            gyro_bias=gyro.bias,
        )

    def update(self, newer: SensorCalibration) -> SensorCalibration:
        """Return this calibration with the sensors of a newer one of the same device.

        Where the newer one has the gyroscope's bias only, scale and misalignment stay.  The
        dependence on temperature has to be measured again: its polynomials refer to the matrix and
        the bias that are replaced.

        Raises
        ------
        ConfigError
            The two are of different devices, or were made with different settings of the chip.
        """
        for label in ("device", "mpu6050"):
            old, new = getattr(self, label), getattr(newer, label)
            if old and new and old != new:
                raise ConfigError(
                    f"the existing calibration has {label} {old!r}, the new one {new!r}; keep two "
                    "files"
                )
        changes = {
            label: _merged(label, getattr(self, label), triad)
            for label, triad in newer.triads().items()
        }
        return self.replace(
            device=newer.device or self.device,
            gravity=newer.gravity or self.gravity,
            mpu6050=newer.mpu6050 or self.mpu6050,
            **changes,
        )

    def save(self, path: str | PathLike[str]) -> None:
        """Write the calibration as TOML, atomically."""
        save_settings(self, path)

    def _corrected_ranges(self, recording: Recording) -> dict[str, float]:
        """Return the smallest corrected reading of an axis at which the sensor clips."""
        ranges = {}
        for label, triad in self.triads().items():
            full_scale = getattr(recording, f"{label}_range", None)
            if full_scale is not None:
                scale, bias = np.diagonal(triad.matrix), np.array(triad.bias)
                ranges[f"{label}_range"] = float((scale * (full_scale - np.abs(bias))).min())
        return ranges


def _merged(label: str, old: Triad | None, new: Triad) -> Triad:
    """Keep what the newer measurement of a sensor does not cover."""
    if old is None:
        return new
    if old.range and new.range and abs(old.range / new.range - 1) > RANGE_TOLERANCE:
        raise ConfigError(
            f"the existing calibration of the {SENSORS[label]} is for a full scale of "
            f"{old.range:.4g}, the new one for "
            f"{new.range:.4g}; keep two files"
        )
    if new.matrix_std is None and old.matrix_std is not None:
        kept = ("matrix", "matrix_std", "residual", "condition", "observations", "note")
        new = new.replace(**{key: getattr(old, key) for key in kept})
    return new


def load_calibration(path: str | PathLike[str]) -> SensorCalibration:
    """Read a calibration that `SensorCalibration.save` wrote.

    Parameters
    ----------
    path : path
        TOML file.

    Returns
    -------
    SensorCalibration

    Raises
    ------
    ConfigError
        The file cannot be read or is no calibration; the message names the file and the key.
    """
    return load_settings(SensorCalibration, path)
