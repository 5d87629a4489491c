"""Bias and scale over the temperature of the die.

The sensor is at rest while it warms up or cools down.  The reading of the gyroscope is its bias.
The reading of the accelerometer changes by its bias and, along gravity, by its scale: opposite
poses separate the two, one pose does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from footnav.calibration.model import SensorCalibration, TemperatureModel, Triad
from footnav.calibration.provenance import as_recordings, provenance
from footnav.calibration.static import find_rests
from footnav.conversions import as_vector
from footnav.errors import ConfigError, DataError
from footnav.recording import STANDARD_GRAVITY, Floats, Recording

BLOCK = 2.0
"""Length of the means that the polynomials are fitted to, s: the temperature changes by less than
0.1 K in it.
"""

LEAST_SPAN = 5.0
"""Span of temperatures, K, below which a slope is noise."""

MARGIN = 2.0
"""Margin beyond the span in which the polynomials are used, K."""

HIGHEST_ORDER = 3

LEAST_TILT = 1.2
"""Span of gravity along an axis, in g, from which on bias and scale are separable."""


def calibrate_temperature(
    recordings: Recording | Sequence[Recording],
    base: SensorCalibration | None = None,
    *,
    order: int = 2,
    device: str = "",
) -> SensorCalibration:
    """Measure bias and scale over the temperature of the die.

    Parameters
    ----------
    recordings : Recording or sequence of Recording
        With temperature; each rest is one pose.
    base : SensorCalibration, optional
        Calibration to extend; the accelerometer's matrix and bias stay.
    order : int
        Order of the polynomials, 1 to 3.
    device : str
        Name of the device, if `base` has none.

    Returns
    -------
    SensorCalibration
        `base` with `thermal` of both sensors, and with the gyroscope's bias.

    Raises
    ------
    ConfigError
        The order is out of range, or the recordings do not fit `base`.
    DataError
        There is no temperature, it spans too little, or the sensor did not rest.
    """
    walks = as_recordings(recordings)
    base = SensorCalibration(device=device) if base is None else base
    if order not in range(1, HIGHEST_ORDER + 1):
        raise ConfigError(f"order is {order}; expected 1 to {HIGHEST_ORDER}")
    for recording in walks:
        base.check(recording, device or None)
    means = _means(walks)
    if np.ptp(means.temperature) < LEAST_SPAN:
        raise DataError(
            f"the temperature goes from {means.temperature.min():.1f} to "
            f"{means.temperature.max():.1f} degC only; "
            f"{LEAST_SPAN:g} K are needed: start with a cold sensor, and record until it is warm"
        )
    old_accel, old_gyro = (
        base.accel or Triad(**provenance(walks, "accel")),
        base.gyro or Triad(**provenance(walks, "gyro")),
    )
    middle = float(means.temperature.mean())
    reference = middle if old_accel.temperature is None else old_accel.temperature
    accel = old_accel.replace(thermal=_accel(means, old_accel, order, reference))
    bias, std, model = _gyro(means, order, middle)
    gyro = old_gyro.replace(bias=bias, bias_std=std, temperature=middle, thermal=model)
    return base.replace(
        device=base.device or device, accel=accel.replace(temperature=reference), gyro=gyro
    )


@dataclass(frozen=True, slots=True)
class _Means:
    """Means over blocks at rest; m of them, in k poses.

    Attributes
    ----------
    accel, gyro : ndarray, shape (m, 3)
        m/s² and rad/s.
    temperature : ndarray, shape (m,)
        Degrees Celsius.
    pose : ndarray of int, shape (m,)
        Number of the rest.
    """

    accel: Floats
    gyro: Floats
    temperature: Floats
    pose: Floats


def _means(recordings: Sequence[Recording]) -> _Means:
    columns: list[Floats] = []
    poses = 0
    for recording in recordings:
        if recording.temperature is None:
            raise DataError(
                f"{recording.name or 'the recording'} has no temperature; record that of the "
                "sensor's die"
            )
        rests = find_rests(recording)
        samples = np.column_stack([recording.accel, recording.gyro, recording.temperature])
        length = max(1, round(BLOCK * recording.rate_hz))
        for start, stop in zip(rests.start, rests.stop, strict=True):
            count = (stop - start) // length
            blocks = samples[start : start + count * length].reshape(count, length, 7).mean(axis=1)
            columns.append(np.column_stack([blocks, np.full(count, float(poses))]))
            poses += bool(count)
    if not poses:
        raise DataError(
            f"there is no rest of {BLOCK:g} s or more; lay the sensor down and do not touch it"
        )
    table = np.concatenate(columns)
    return _Means(accel=table[:, :3], gyro=table[:, 3:6], temperature=table[:, 6], pose=table[:, 7])


def _gyro(
    means: _Means, order: int, reference: float
) -> tuple[tuple[float, float, float], tuple[float, float, float], TemperatureModel]:
    """Return bias, its standard deviation, and the dependence on temperature."""
    powers = _powers(means.temperature - reference, order)
    values, std, residual = _solve(np.column_stack([np.ones(len(powers)), powers]), means.gyro)
    model = TemperatureModel(
        reference=reference,
        bias=_rows(values[1:]),
        bias_std=_rows(std[1:]),
        residual=residual,
        **_span(means),
    )
    return as_vector(values[0]), as_vector(std[0]), model


def _accel(means: _Means, old: Triad, order: int, reference: float) -> TemperatureModel:
    """Return the dependence on temperature.

    The readings at the reference differ by pose, the changes are common.
    """
    powers = _powers(means.temperature - reference, order)
    poses = (means.pose[:, None] == np.unique(means.pose)).astype(np.float64)
    gravity = poses @ np.linalg.lstsq(poses, means.accel, rcond=None)[0] - np.array(old.bias)
    separable = np.ptp(gravity, axis=0) > LEAST_TILT * STANDARD_GRAVITY
    changes = np.zeros((2, 2 * order, 3))
    residuals = []
    for axis in range(3):
        scaled = powers * gravity[:, axis, None] if separable[axis] else powers[:, :0]
        design = np.column_stack([powers, scaled, poses])
        values, std, residual = _solve(design, means.accel[:, axis, None])
        used = powers.shape[1] + scaled.shape[1]
        changes[:, :used, axis] = values[:used, 0], std[:used, 0]
        residuals.append(residual)
    (bias, scale), (bias_std, scale_std) = (np.split(change, 2) for change in changes)
    return TemperatureModel(
        reference=reference,
        bias=_rows(bias),
        bias_std=_rows(bias_std),
        scale=_rows(scale) if separable.any() else (),
        scale_std=_rows(scale_std) if separable.any() else (),
        residual=float(np.sqrt(np.square(residuals).mean())),
        **_span(means),
    )


def _span(means: _Means) -> dict[str, Any]:
    """Return the span of validity as keywords of `TemperatureModel`."""
    return {
        "lowest": float(means.temperature.min()),
        "highest": float(means.temperature.max()),
        "margin": MARGIN,
    }


def _powers(excess: Floats, order: int) -> Floats:
    """Return the powers from the first to `order`, shape (m, order)."""
    return np.power.outer(excess, np.arange(1, order + 1))


def _solve(design: Floats, values: Floats) -> tuple[Floats, Floats, float]:
    """Return the least-squares solution, its standard deviation, and the RMS of the residuals."""
    length = np.linalg.norm(design, axis=0)
    scaled = design / np.where(length > 0, length, 1.0)
    solution = np.linalg.lstsq(scaled, values, rcond=None)[0]
    left = values - scaled @ solution
    spare = max(len(values) - design.shape[1], 1)
    inverse = np.sqrt(np.diag(np.linalg.pinv(scaled.T @ scaled)))
    std = inverse[:, None] * np.sqrt(np.square(left).sum(axis=0) / spare)
    divisor = np.where(length > 0, length, 1.0)[:, None]
    return solution / divisor, std / divisor, float(np.sqrt(np.square(left).mean()))


def _rows(values: Floats) -> tuple[tuple[float, float, float], ...]:
    return tuple(map(as_vector, values))
