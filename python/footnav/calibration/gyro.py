"""The gyroscope: its bias from rest, its scale and misalignment from the turns between poses.

Between two rests the gyroscope says how the sensor turned, and the calibrated accelerometer says which way was up before
and after: the second stage of Tedaldi, Pretto, Menegatti 2014, eqs. 13-17.  The bias of a turn is the mean of the two
rests around it, where the paper takes that of the rest at the start: it follows what drifts, and half of what gravity
does to the gyroscope.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footnav.calibration.fit import fit
from footnav.calibration.model import SensorCalibration, Triad
from footnav.calibration.mpu6050 import Setup
from footnav.calibration.origin import as_recordings, check_setup, origin
from footnav.calibration.static import BLOCK, Rests, check_rest
from footnav.recording import Floats, Recording
from footnav.triad import as_matrix, as_vector

LONGEST_TURN = 15.0
"""Time between two rests, s, beyond which noise and bias have had too long to spoil the angle."""

LEAST_TURN = np.radians(150.0)
"""What the turns about each axis have to add up to."""

FEWEST_TURNS = 6
"""Each turn gives two equations, and there are nine parameters."""

WORST_CONDITION = 100.0
"""Turns between twelve spread poses give about 5."""


def calibrate_gyro(
    recordings: Recording | Sequence[Recording], *, device: str = "", setup: Setup | None = None
) -> SensorCalibration:
    """Measure the bias of the gyroscope at rest.

    Parameters
    ----------
    recordings : Recording or sequence of Recording
        At rest from the first sample to the last, a second or more each.
    device : str
        What the device is called.
    setup : Setup, optional
        Registers of the MPU6050.

    Returns
    -------
    SensorCalibration
        With `gyro`, whose matrix is the identity.

    Raises
    ------
    DataError
        A recording moves; the message names the axis, the value and the limit.
    """
    walks = as_recordings(recordings)
    check_setup(walks, setup)
    for recording in walks:
        check_rest(recording)
    means = np.concatenate([_block_means(recording) for recording in walks])
    # The bias walks, so that blocks far apart differ by more than noise: halves are compared, too.
    halves = np.abs(means[: len(means) // 2].mean(axis=0) - means[len(means) // 2 :].mean(axis=0)) / 2
    std = np.maximum(means.std(axis=0, ddof=1) / np.sqrt(len(means)), halves)
    gyro = _bias_only(means.mean(axis=0), std, len(means), "bias only: the recording has no turns")
    return SensorCalibration(device=device, mpu6050=setup, gyro=gyro.replace(**origin(walks, "gyro")))


def bias_of_rests(rests: Rests) -> Triad:
    """Return the mean bias of the rests, with a note that there was nothing else to be measured."""
    return _bias_only(
        rests.gyro.mean(axis=0),
        _std_of_bias(rests),
        len(rests),
        "bias only: between its rests the recording turns too little about some axis, or for too long",
    )


def fit_rotations(recordings: Sequence[Recording], rests: Sequence[Rests], accel: Triad) -> Triad | None:
    """Find scale and misalignment of the gyroscope from the turns between rests (Tedaldi et al., eq. 17).

    Parameters
    ----------
    recordings : sequence of Recording
        The recordings.
    rests : sequence of Rests
        The rests of each.
    accel : Triad
        Calibration of the accelerometer.

    Returns
    -------
    Triad or None
        Corrects rates to the frame of the corrected accelerometer; None where the turns do not tell all nine elements.
    """
    turns = _turns(recordings, rests, accel)
    if turns is None:
        return None

    across = _across(turns.after)

    def misses(parameters: Floats) -> Floats:
        miss = turns.carried(parameters.reshape(3, 3)) - turns.after
        return (miss[:, None, :] @ across).ravel()

    std = np.repeat(turns.std, 2)
    found = fit(misses, np.eye(3).ravel(), std)
    if found.condition > WORST_CONDITION:
        return None
    bias = np.concatenate([each.gyro for each in rests])
    return Triad(
        matrix=as_matrix(found.parameters.reshape(3, 3)),
        bias=as_vector(bias.mean(axis=0)),
        matrix_std=as_matrix(found.std.reshape(3, 3)),
        bias_std=as_vector(bias.std(axis=0, ddof=1) / np.sqrt(len(bias))),
        residual=found.residual,
        condition=found.condition,
        observations=len(turns.after),
    )


@dataclass(frozen=True, slots=True)
class _Turns:
    """Turns between rests; k of them, padded to the same number n of samples.

    Attributes
    ----------
    angles : ndarray, shape (k, n, 3)
        Rate less bias, times the interval that the sample ends, rad; zero where a turn is over.
    before, after : ndarray, shape (k, 3)
        Up, from the accelerometer.
    std : ndarray, shape (k,)
        Standard deviation of the difference of the directions, rad.
    """

    angles: Floats
    before: Floats
    after: Floats
    std: Floats

    def carried(self, matrix: Floats) -> Floats:
        """Return where the gyroscope, corrected by a matrix, says that up went, shape (k, 3)."""
        turned = _product(_quaternions(_with_coning(self.angles @ matrix.T)))
        return _turn_back(turned, self.before)


def _turns(recordings: Sequence[Recording], rests: Sequence[Rests], accel: Triad) -> _Turns | None:
    """Collect the turns, or None where they are too few or too small about an axis."""
    angles: list[Floats] = []
    ends: list[tuple[Floats, Floats, float]] = []
    for recording, each in zip(recordings, rests, strict=True):
        up = accel.replace(thermal=None).correct(each.accel)
        length = np.linalg.norm(up, axis=1, keepdims=True)
        tilt_std = each.accel_std / length[:, 0]
        for k in range(len(each) - 1):
            between = slice(each.stop[k] - 1, each.start[k + 1] + 1)
            if recording.t[between][-1] - recording.t[between][0] > LONGEST_TURN:
                continue
            rate = recording.gyro[between][1:] - (each.gyro[k] + each.gyro[k + 1]) / 2
            angles.append(rate * np.diff(recording.t[between])[:, None])
            drift = (each.gyro_std[k] + each.gyro_std[k + 1]) * len(angles[-1]) / recording.rate_hz
            std = float(np.sqrt(tilt_std[k] ** 2 + tilt_std[k + 1] ** 2 + drift**2))
            ends.append((up[k] / length[k], up[k + 1] / length[k + 1], std))
    if len(angles) < FEWEST_TURNS:
        return None
    if min(sum(np.abs(turn.sum(axis=0)) for turn in angles)) < LEAST_TURN:
        return None
    padded = np.zeros((len(angles), max(map(len, angles)), 3))
    for row, turn in zip(padded, angles, strict=True):
        row[: len(turn)] = turn
    before, after, std_all = (np.array(column) for column in zip(*ends, strict=True))
    return _Turns(padded, before, after, np.maximum(std_all, 1e-9))


def _with_coning(angles: Floats) -> Floats:
    """Return rotation vectors of the samples: a twelfth of the product with the one before makes up for coning.

    This is the two-sample form; see P. G. Savage, "Strapdown inertial navigation integration algorithm design, part 1",
    J. Guidance 21(1), 1998, eqs. 32-34.
    """
    rotation = angles.copy()
    rotation[:, 1:] += np.cross(angles[:, :-1], angles[:, 1:]) / 12
    return rotation


def _quaternions(rotation: Floats) -> Floats:
    """Return the quaternions (w, x, y, z) of rotation vectors, shape (k, n, 4)."""
    half = np.linalg.norm(rotation, axis=2, keepdims=True) / 2
    return np.concatenate([np.cos(half), np.sinc(half / np.pi) * rotation / 2], axis=2)


def _product(quaternions: Floats) -> Floats:
    """Return the product of each row, shape (k, 4), multiplying neighbours until one is left."""
    while quaternions.shape[1] > 1:
        if quaternions.shape[1] % 2:
            identity = np.zeros_like(quaternions[:, :1])
            identity[..., 0] = 1.0
            quaternions = np.concatenate([quaternions, identity], axis=1)
        quaternions = _hamilton(quaternions[:, ::2], quaternions[:, 1::2])
    return quaternions[:, 0]


def _hamilton(p: Floats, q: Floats) -> Floats:
    w = p[..., :1] * q[..., :1] - (p[..., 1:] * q[..., 1:]).sum(axis=-1, keepdims=True)
    v = p[..., :1] * q[..., 1:] + q[..., :1] * p[..., 1:] + np.cross(p[..., 1:], q[..., 1:])
    return np.concatenate([w, v], axis=-1)


def _turn_back(quaternions: Floats, vectors: Floats) -> Floats:
    """Return vectors, fixed in the world, as the turned sensor sees them."""
    w, v = quaternions[:, :1], -quaternions[:, 1:]
    across = 2 * np.cross(v, vectors)
    turned: Floats = vectors + w * across + np.cross(v, across)
    return turned


def _across(directions: Floats) -> Floats:
    """Return two unit vectors at right angles to each of k directions, shape (k, 3, 2)."""
    _, _, rows = np.linalg.svd(directions[:, None, :])
    return np.swapaxes(rows[:, 1:], 1, 2)


def _bias_only(bias: Floats, std: Floats, observations: int, note: str) -> Triad:
    return Triad(bias=as_vector(bias), bias_std=as_vector(std), observations=observations, note=note)


def _std_of_bias(rests: Rests) -> Floats:
    if len(rests) < 2:
        return np.full(3, rests.gyro_std[0])
    return rests.gyro.std(axis=0, ddof=1) / np.sqrt(len(rests))


def _block_means(recording: Recording) -> Floats:
    length = max(1, round(BLOCK * recording.rate_hz))
    return recording.gyro[: len(recording) // length * length].reshape(-1, length, 3).mean(axis=1)
