"""Six-position calibration.

Six sides of a box for the accelerometer, three known turns for the gyroscope.

With the directions known from the sides of the box, the errors follow from linear equations: F.
Ferraris, U. Grimaldi, M. Parvis, "Procedure for effortless in-field calibration of three-axial rate
gyro and accelerometers", Sensors and Materials 7(5), 1995.  The corrected axes are those of the
box.  The squareness of the box limits the misalignment: a side that is off by a degree is a
misalignment of a degree.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from footnav.calibration import mpu6050
from footnav.calibration.accel import check_range
from footnav.calibration.gyro import bias_of_rests
from footnav.calibration.model import SensorCalibration, Triad
from footnav.calibration.poses import DIRECTIONS, SIDES, missing_sides, sides
from footnav.calibration.provenance import as_recordings, check_setup, provenance
from footnav.calibration.static import Rests, find_rests, pooled
from footnav.calibration.turns import turn_angles
from footnav.config import Config, Mechanization
from footnav.conversions import as_matrix, as_vector
from footnav.errors import DataError
from footnav.mpu6050 import Setup
from footnav.recording import Floats, Recording

TURN_TOLERANCE = 0.2
"""Relative difference up to which a measured turn counts as a known one."""


def calibrate_six_position(
    recordings: Recording | Sequence[Recording],
    *,
    turn: float = 2 * np.pi,
    gravity: float | None = None,
    latitude_deg: float | None = None,
    initial: float = 2.0,
    device: str = "",
    setup: Setup | None = None,
) -> SensorCalibration:
    """Calibrate from the six sides of a box, and from turns by a known angle about its three edges.

    Parameters
    ----------
    recordings : Recording or sequence of Recording
        Each starts at rest; together they have a rest on each side, and may have turns about each
        axis, either way, with a rest before and after.
    turn : float
        Angle of the turns, rad; a full turn unless given.
    gravity, latitude_deg : float, optional
        Gravity in m/s², or the latitude in degrees to take it from; that of 45 degrees unless one
        is given.
    initial : float
        Length of the rest at the start, s, from which the limits of rest are taken.
    device : str
        Name of the device.
    setup : Setup, optional
        Registers of the MPU6050.

    Returns
    -------
    SensorCalibration
        With `accel`, and with `gyro`, whose note reports missing turns.

    Raises
    ------
    DataError
        The recording does not start at rest, a side is missing, the accelerometer is off by a power
        of two or by whole g, or a turn clips or has a gap.
    ConfigError
        Full scales or gravity are out of range.
    """
    walks = as_recordings(recordings)
    check_setup(walks, setup)
    standard = Config(
        mechanization=Mechanization(gravity=gravity, latitude_deg=latitude_deg)
    ).gravity
    rests = [find_rests(recording, initial) for recording in walks]
    accel = _accel(
        pooled(rests), standard, ", ".join(recording.name for recording in walks) or "the recording"
    )
    gyro = _gyro(walks, rests, turn) or bias_of_rests(pooled(rests)).replace(
        note=(
            f"bias only: turns of {np.degrees(turn):.0f} deg about each axis, with rests between, "
            "were not found"
        )
    )
    return SensorCalibration(
        device=device,
        gravity=standard,
        mpu6050=setup,
        accel=accel.replace(**provenance(walks, "accel")),
        gyro=gyro.replace(**provenance(walks, "gyro")),
    )


def _accel(rests: Rests, gravity: float, label: str) -> Triad:
    check_range(rests, label)
    missing = missing_sides(rests.accel)
    if missing:
        raise DataError(f"{label}: no rest with {', '.join(missing)} up; all six sides are needed")
    named = np.array([side or "" for side in sides(rests.accel)])
    means = np.array([rests.accel[named == side].mean(axis=0) for side in SIDES])
    # raw = inverse(M) (g u) + b, with the direction u of the side of the box.
    design = np.column_stack([gravity * DIRECTIONS, np.ones(len(SIDES))])
    inverse, bias = np.split(np.linalg.lstsq(design, means, rcond=None)[0], [3])
    problem = mpu6050.explain_bias(as_vector(bias[0]))
    if problem:
        raise DataError(f"{label}: {problem}")
    left = means - design @ np.vstack([inverse, bias])
    residual = float(np.sqrt(np.square(left).mean()))
    # Six equations and four parameters for each axis leave two degrees of freedom for the residual.
    std = max(residual * np.sqrt(6 / 2), float(rests.accel_std.max()))
    spread = np.sqrt(np.diag(np.linalg.inv(design.T @ design))) * std
    return Triad(
        matrix=as_matrix(np.linalg.inv(inverse.T)),
        bias=as_vector(bias[0]),
        matrix_std=as_matrix(np.tile(spread[:3], (3, 1))),
        bias_std=as_vector(np.full(3, spread[3])),
        residual=residual,
        condition=float(np.linalg.cond(design / np.linalg.norm(design, axis=0))),
        observations=int((named != "").sum()),
    )


def _gyro(recordings: Sequence[Recording], rests: Sequence[Rests], turn: float) -> Triad | None:
    """Return the correction of measured to known turns, or None where an axis has no turn."""
    read: list[Floats] = []
    for recording, each in zip(recordings, rests, strict=True):
        angles = [turn_angles(recording, each, k).sum(axis=0) for k in range(len(each) - 1)]
        read += [angle for angle in angles if abs(np.abs(angle).max() / turn - 1) < TURN_TOLERANCE]
    known = np.array(
        [turn * np.sign(angle) * (np.abs(angle) == np.abs(angle).max()) for angle in read]
    ).reshape(-1, 3)
    if not np.abs(known).sum(axis=0).all():
        return None
    matrix, *_ = np.linalg.lstsq(np.array(read), known, rcond=None)
    left = np.array(read) @ matrix - known
    spare = left.size - matrix.size
    std = np.sqrt(np.square(left).sum() / spare) if spare else _noise_of_turns(rests, turn)
    spread = std * np.sqrt(np.diag(np.linalg.inv(np.array(read).T @ np.array(read))))
    bias = bias_of_rests(pooled(rests))
    return bias.replace(
        matrix=as_matrix(matrix.T),
        matrix_std=as_matrix(np.tile(spread, (3, 1))),
        residual=float(np.sqrt(np.square(left).mean())),
        condition=float(np.linalg.cond(np.array(read))),
        observations=len(read),
        note="",
    )


def _noise_of_turns(rests: Sequence[Rests], turn: float) -> float:
    """Return the error of a turn at 1 rad/s by the scatter of the bias, rad.

    The only one that three turns show.
    """
    return float(pooled(rests).gyro.std(axis=0, ddof=1).max()) * turn
