"""Calibration of the accelerometer from rests in many poses.

At rest a correct accelerometer reads gravity in every pose.  Bias, scale and misalignment are
estimated from this condition: the first stage of D. Tedaldi, A. Pretto, E. Menegatti, "A robust
and easy to implement method for IMU calibration without external equipments", ICRA 2014, eq. 10.
Two choices differ from the paper.  The residual is the difference of the magnitudes, not of their
squares, so that it is in m/s².  The product T K of misalignment and scale is one lower triangular
matrix, not an upper one: the x axis of the corrected frame is the accelerometer's own, and y lies
in the plane of its x and y.  This is the frame of Kalibr, too.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footnav.calibration import mpu6050
from footnav.calibration.fit import Fit, fit
from footnav.calibration.gyro import bias_of_rests
from footnav.calibration.model import SensorCalibration, Triad
from footnav.calibration.poses import count_distinct, missing_sides
from footnav.calibration.provenance import as_recordings, check_setup, provenance
from footnav.calibration.static import Rests, find_rests, pooled
from footnav.calibration.turns import fit_rotations
from footnav.config import Config, Mechanization
from footnav.conversions import as_matrix, as_vector
from footnav.errors import DataError
from footnav.mpu6050 import Setup
from footnav.recording import Floats, Recording

LOWER = np.tril_indices(3)
"""Rows and columns of the six elements of the matrix that are not zero."""

FEWEST_POSES = 9
"""The number of parameters (Tedaldi et al., section III)."""

WORST_CONDITION = 30.0
"""Twelve spread poses give about 3; beyond this, errors of a percent are indistinguishable."""


def calibrate_accel(
    recordings: Recording | Sequence[Recording],
    *,
    gravity: float | None = None,
    latitude_deg: float | None = None,
    initial: float = 2.0,
    device: str = "",
    setup: Setup | None = None,
) -> SensorCalibration:
    """Calibrate the accelerometer, and if possible the gyroscope, from rests in many poses.

    Parameters
    ----------
    recordings : Recording or sequence of Recording
        Each starts at rest; the sensor is then placed in at least nine poses in all, on all six
        sides and in between, and rests a second or more in each.
    gravity : float, optional
        Gravity where they were made, m/s².
    latitude_deg : float, optional
        Latitude to take gravity from, degrees; 45 unless one of the two is given.
    initial : float
        Length of the rest at the start, s, from which the limits of rest are taken.
    device : str
        Name of the device.
    setup : Setup, optional
        Registers of the MPU6050.

    Returns
    -------
    SensorCalibration
        With `accel`, and with `gyro`, whose note reports what could not be measured.

    Raises
    ------
    DataError
        The recording does not start at rest, there are too few poses or too similar ones (the
        message names the missing ones), the accelerometer is off by a power of two or by whole g,
        with the likely cause, or a turn between two poses clips or has a gap.
    ConfigError
        Full scales or gravity are out of range.

    See Also
    --------
    footnav.calibration.calibrate_six_position : When the sensor sits square in a box.
    """
    walks = as_recordings(recordings)
    check_setup(walks, setup)
    standard = Config(
        mechanization=Mechanization(gravity=gravity, latitude_deg=latitude_deg)
    ).gravity
    rests = [find_rests(recording, initial) for recording in walks]
    found = fit_accel(pooled(rests), standard, ", ".join(recording.name for recording in walks))
    gyro = fit_rotations(walks, rests, found, unpack) or bias_of_rests(pooled(rests))
    return SensorCalibration(
        device=device,
        gravity=standard,
        mpu6050=setup,
        accel=_triad(found, len(pooled(rests))).replace(**provenance(walks, "accel")),
        gyro=gyro.replace(**provenance(walks, "gyro")),
    )


def fit_accel(rests: Rests, gravity: float, name: str = "") -> Fit:
    """Find bias, scale and misalignment from rests (Tedaldi et al., eq. 10).

    Parameters
    ----------
    rests : Rests
        In nine poses or more.
    gravity : float
        m/s².
    name : str
        Name of the recording in messages.

    Returns
    -------
    Fit
        Fit of the parameters that `unpack` converts.

    Raises
    ------
    DataError
        There are too few poses or too similar ones, or the accelerometer is off by a power of two
        or by whole g.
    """
    label = name or "the recording"
    check_range(rests, label)
    _check_poses(rests, label)

    def excess(parameters: Floats) -> Floats:
        matrix, bias = unpack(parameters)
        misses: Floats = np.linalg.norm((rests.accel - bias) @ matrix.T, axis=1) - gravity
        return misses

    start = np.concatenate([np.eye(3)[LOWER], _middle(rests.accel, gravity)])
    found = fit(excess, start, rests.accel_std + 1e-9)
    _check_result(found, label)
    return found


def unpack(parameters: Floats) -> tuple[Floats, Floats]:
    """Convert nine parameters to the lower triangular matrix (3, 3) and the bias (3,)."""
    matrix = np.zeros((3, 3))
    matrix[LOWER] = parameters[:6]
    return matrix, parameters[6:]


def _triad(found: Fit, observations: int) -> Triad:
    matrix, bias = unpack(found.parameters)
    matrix_std, bias_std = unpack(found.std)
    return Triad(
        matrix=as_matrix(matrix),
        bias=as_vector(bias),
        matrix_std=as_matrix(matrix_std),
        bias_std=as_vector(bias_std),
        residual=found.residual,
        condition=found.condition,
        observations=observations,
    )


def _middle(accel: Floats, gravity: float) -> Floats:
    """Return the centre of the sphere that fits best.

    |a|² = 2 a·c + r² - |c|², linear in c and the constant.
    """
    design = np.column_stack([2 * accel / gravity, np.ones(len(accel))])
    solution = np.linalg.lstsq(design, np.square(accel).sum(axis=1) / gravity, rcond=None)[0]
    centre: Floats = solution[:3]
    return centre


def check_range(rests: Rests, label: str) -> None:
    """Raise DataError if the accelerometer reads gravity times a power of two in every pose."""
    if not len(rests):
        return
    levels = np.linalg.norm(rests.accel, axis=1)
    problem = (
        mpu6050.explain_rest(float(np.median(levels)))
        if np.ptp(levels) < 0.2 * np.median(levels)
        else None
    )
    if problem:
        raise DataError(f"{label}: {problem}")


def _check_poses(rests: Rests, label: str) -> None:
    missing = missing_sides(rests.accel - _offset(rests.accel))
    poses = count_distinct(rests.accel)
    if poses >= FEWEST_POSES and not missing:
        return
    lacking = [f"no pose with {side} up" for side in missing]
    if poses < FEWEST_POSES:
        lacking.append(f"{FEWEST_POSES - poses} more poses, such as edges down")
    raise DataError(
        f"{label}: {len(rests)} rest(s) in {poses} different pose(s); {FEWEST_POSES} or more are "
        "needed, on all "
        f"six sides; missing: {', '.join(lacking)}"
    )


def _offset(accel: Floats) -> Floats:
    """Return the middle of the extremes where they are clearly off-centre.

    An offset of 1 g hides a side.
    """
    middle: Floats = (accel.max(axis=0) + accel.min(axis=0)) / 2
    spread = np.ptp(accel, axis=0)
    return np.where(spread > 12.0, middle, 0.0)


def _check_result(found: Fit, label: str) -> None:
    problem = mpu6050.explain_bias(as_vector(unpack(found.parameters)[1]))
    if problem:
        raise DataError(f"{label}: {problem}")
    if found.condition > WORST_CONDITION:
        raise DataError(
            f"{label}: the poses are too similar: the condition number is {found.condition:.0f}, "
            "more than "
            f"{WORST_CONDITION:g}; add poses on edges and corners, each way up"
        )
