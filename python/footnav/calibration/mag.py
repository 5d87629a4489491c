"""The magnetometer: hard and soft iron shift and deform the sphere of its readings to an ellipsoid.

Away from other iron the strength of the field is the same in all orientations.  Hard iron is the
centre of the ellipsoid, soft iron and scale are its axes; see V. Renaudin, M. H. Afzal, G.
Lachapelle, "Complete triaxis magnetometer calibration in the magnetic domain", J. Sensors 2010,
eqs. 10-20.  The ellipsoid does not determine the rotation of the corrected axes against the
accelerometer's: the matrix is the symmetric one, with the smallest rotation.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footnav.calibration.fit import fit
from footnav.calibration.model import SensorCalibration, Triad
from footnav.calibration.poses import missing_sides
from footnav.calibration.provenance import as_recordings, provenance
from footnav.conversions import as_matrix, as_vector
from footnav.errors import DataError
from footnav.recording import Floats, Recording

UPPER = np.triu_indices(3)
"""The six elements of a symmetric matrix."""

MOST_SAMPLES = 2000
"""Further samples, so close together, add no information."""

WORST_CONDITION = 30.0
WORST_RESIDUAL = 0.1
"""Relative scatter of the corrected strength beyond which the field was disturbed."""


def calibrate_mag(
    recordings: Recording | Sequence[Recording], *, field: float | None = None, device: str = ""
) -> SensorCalibration:
    """Find hard and soft iron from a recording with rotations about all axes, far from other iron.

    Parameters
    ----------
    recordings : Recording or sequence of Recording
        With magnetometer; the orientations have to cover all directions.
    field : float, optional
        Strength of the field where they were made, T; the mean of the readings unless given, which
        is all that a heading needs.
    device : str
        Name of the device.

    Returns
    -------
    SensorCalibration
        With `mag`.

    Raises
    ------
    DataError
        There is no magnetometer, the directions cover too little, or the field was disturbed.
    """
    walks = as_recordings(recordings)
    label = ", ".join(recording.name for recording in walks) or "the recording"
    readings = np.concatenate([_readings(recording) for recording in walks])
    readings = readings[:: -(-len(readings) // MOST_SAMPLES)]
    centre, radius = _sphere(readings, label)
    strength = radius if field is None else field

    def excess(parameters: Floats) -> Floats:
        matrix, bias = _unpack(parameters)
        misses: Floats = (
            np.linalg.norm((readings / radius - bias) @ matrix, axis=1) - strength / radius
        )
        return misses

    start = np.concatenate([np.eye(3)[UPPER] * strength / radius, centre / radius])
    found = fit(excess, start, np.full(len(readings), 1e-3))
    matrix, bias = _unpack(found.parameters)
    _check_cover((readings / radius - bias) @ matrix, found.condition, label)
    if found.residual > WORST_RESIDUAL * strength / radius:
        raise DataError(
            f"{label}: after the fit the strength of the field still scatters by "
            f"{100 * found.residual * radius / strength:.0f} %: record away from iron, cables and "
            "loudspeakers"
        )
    matrix_std, bias_std = _unpack(found.std)
    mag = Triad(
        matrix=as_matrix(matrix),
        bias=as_vector(bias * radius),
        matrix_std=as_matrix(matrix_std),
        bias_std=as_vector(bias_std * radius),
        residual=found.residual * radius,
        condition=found.condition,
        observations=len(readings),
    )
    return SensorCalibration(device=device, mag=mag.replace(**provenance(walks, "mag")))


def _readings(recording: Recording) -> Floats:
    if recording.mag is None:
        raise DataError(f"{recording.name or 'the recording'} has no magnetometer")
    return recording.mag


def _sphere(readings: Floats, label: str) -> tuple[Floats, float]:
    """Return centre and radius of the best sphere.

    |m|² = 2 m·c + r² - |c|² is linear in c and the constant.
    """
    scale = float(np.abs(readings).max())
    design = np.column_stack([2 * readings / scale, np.ones(len(readings))])
    solution = np.linalg.lstsq(design, np.square(readings / scale).sum(axis=1), rcond=None)[0]
    centre, square = solution[:3], solution[3] + solution[:3] @ solution[:3]
    if not square > 0:
        raise DataError(
            f"{label}: the readings of the magnetometer lie on no sphere; turn the sensor all "
            "around"
        )
    _check_cover(readings / scale - centre, 1.0, label)
    return centre * scale, float(np.sqrt(square)) * scale


def _unpack(parameters: Floats) -> tuple[Floats, Floats]:
    """Return the symmetric matrix and the centre."""
    matrix = np.zeros((3, 3))
    matrix[UPPER] = parameters[:6]
    return matrix + np.triu(matrix, 1).T, parameters[6:]


def _check_cover(directions: Floats, condition: float, label: str) -> None:
    missing = missing_sides(directions)
    if missing:
        raise DataError(
            f"{label}: the directions cover too little: the field never pointed along "
            f"{', '.join(missing)} of the sensor; "
            "turn it slowly all around, upside down, too"
        )
    if condition > WORST_CONDITION:
        raise DataError(
            f"{label}: the directions cover too little: the condition number is {condition:.0f}, "
            "more than "
            f"{WORST_CONDITION:g}; turn the sensor about all of its axes"
        )
