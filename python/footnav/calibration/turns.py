"""Scale and misalignment of the gyroscope from the rotations between poses.

Between two rests the gyroscope measures the rotation, and the calibrated accelerometer the
direction of up before and after: the second stage of Tedaldi, Pretto, Menegatti 2014, eqs. 13-17.
The bias of a rotation is the mean of the two rests around it, where the paper takes that of the
rest at the start: it follows the drift, and half of the g-sensitivity of the gyroscope.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from footnav.calibration.fit import Fit, fit
from footnav.calibration.gyro import std_of_bias
from footnav.calibration.model import Triad
from footnav.calibration.static import Rests, pooled
from footnav.conversions import as_matrix, as_vector
from footnav.diagnosis import CLIP_BAND
from footnav.errors import DataError
from footnav.recording import Floats, Recording

LONGEST_TURN = 15.0
"""Maximum time between two rests, s: noise and bias accumulate in the angle."""

LEAST_TURN = np.radians(150.0)
"""Minimum sum of the rotations about each axis, rad."""

FEWEST_TURNS = 6
"""Each turn gives two equations, and there are nine parameters."""

WORST_CONDITION = 100.0
"""Turns between twelve spread poses give about 5."""

LONGEST_GAP = 3.0
"""Gap, in sample intervals, beyond which a rotation is unknown."""


def fit_rotations(
    recordings: Sequence[Recording],
    rests: Sequence[Rests],
    accel: Fit,
    unpack: Callable[[Floats], tuple[Floats, Floats]],
) -> Triad | None:
    """Find scale and misalignment of the gyroscope from turns (Tedaldi et al., eq. 17).

    The parameters of the accelerometer are estimated again with their fit as prior, so that their
    uncertainty propagates to the gyroscope's.

    Parameters
    ----------
    recordings : sequence of Recording
        The recordings.
    rests : sequence of Rests
        The rests of each.
    accel : Fit
        Of the accelerometer.
    unpack : callable
        Returns matrix and bias of the accelerometer's parameters.

    Returns
    -------
    Triad or None
        Corrects rates to the frame of the corrected accelerometer; None where the rotations do not
        determine all nine elements.
    """
    turns = _turns(recordings, rests)
    if turns is None:
        return None
    hold = np.linalg.pinv(
        np.linalg.cholesky(accel.covariance + 1e-24 * np.eye(len(accel.parameters)))
    )
    across = _across(_up(turns.after, *unpack(accel.parameters)))

    # Half of the differences of the Jacobian do not change the gyroscope's matrix.
    @lru_cache(maxsize=2)
    def rotations(elements: bytes) -> Floats:
        return turns.rotations(np.frombuffer(elements).reshape(3, 3))

    def misses(parameters: Floats) -> Floats:
        held = parameters[9:]
        before, after = (_up(rest, *unpack(held)) for rest in (turns.before, turns.after))
        miss = np.einsum("kji,kj->ki", rotations(parameters[:9].tobytes()), before) - after
        return np.concatenate(
            [(miss[:, None, :] @ across).ravel(), hold @ (held - accel.parameters)]
        )

    start = np.concatenate([np.eye(3).ravel(), accel.parameters])
    std = np.concatenate([np.repeat(turns.std, 2), np.ones(len(accel.parameters))])
    found = fit(misses, start, std)
    if found.condition > WORST_CONDITION:
        return None
    left = misses(found.parameters)[: 2 * len(turns.std)]
    return Triad(
        matrix=as_matrix(found.parameters[:9].reshape(3, 3)),
        bias=as_vector(pooled(rests).gyro.mean(axis=0)),
        matrix_std=as_matrix(found.std[:9].reshape(3, 3)),
        bias_std=as_vector(std_of_bias(pooled(rests))),
        residual=float(np.sqrt(np.square(left).mean())),
        condition=found.condition,
        observations=len(turns.std),
    )


@dataclass(frozen=True, slots=True)
class _Turns:
    """Turns between rests; k of them, padded to the same number n of samples, a power of two.

    Attributes
    ----------
    angles : ndarray, shape (k, n, 3)
        Rate less bias, times the interval that the sample ends, rad; zero where a turn is over.
    before, after : ndarray, shape (k, 3)
        Mean reading of the accelerometer in the rests around it, m/s².
    std : ndarray, shape (k,)
        Standard deviation of the difference of the two directions of up, rad.
    """

    angles: Floats
    before: Floats
    after: Floats
    std: Floats

    def rotations(self, matrix: Floats) -> Floats:
        """Return the turns as the gyroscope, corrected by a matrix, sees them, shape (k, 3, 3)."""
        return _product(_with_coning(self.angles @ matrix.T))


def _turns(recordings: Sequence[Recording], rests: Sequence[Rests]) -> _Turns | None:
    """Collect the turns, or None where they are too few or too small about an axis."""
    pairs = [
        (recording, each, k)
        for recording, each in zip(recordings, rests, strict=True)
        for k in range(len(each) - 1)
        if recording.t[each.start[k + 1]] - recording.t[each.stop[k] - 1] <= LONGEST_TURN
    ]
    if len(pairs) < FEWEST_TURNS:
        return None
    angles = [turn_angles(*pair) for pair in pairs]
    if min(sum(np.abs(turn.sum(axis=0)) for turn in angles)) < LEAST_TURN:
        return None
    padded = np.zeros((len(angles), 1 << max(map(len, angles)).bit_length(), 3))
    for row, turn in zip(padded, angles, strict=True):
        row[: len(turn)] = turn
    return _Turns(
        padded,
        before=np.array([each.accel[k] for _, each, k in pairs]),
        after=np.array([each.accel[k + 1] for _, each, k in pairs]),
        std=np.array([_std_of_turn(*pair) for pair in pairs]),
    )


def turn_angles(recording: Recording, rests: Rests, k: int) -> Floats:
    """Return (rate - bias) times interval between rest k and the next one, shape (n, 3), rad."""
    between = slice(rests.stop[k] - 1, rests.start[k + 1] + 1)
    _check_turn(recording, between)
    rate = recording.gyro[between][1:] - (rests.gyro[k] + rests.gyro[k + 1]) / 2
    angles: Floats = rate * np.diff(recording.t[between])[:, None]
    return angles


def _check_turn(recording: Recording, between: slice) -> None:
    """Raise DataError for a rotation with clipping or a gap."""
    name = recording.name or "the recording"
    t, rate = recording.t[between], np.abs(recording.gyro[between])
    fastest, axis = (int(index) for index in np.unravel_index(rate.argmax(), rate.shape))
    full_scale = recording.gyro_range
    if full_scale is not None and rate[fastest, axis] >= (1 - CLIP_BAND) * full_scale:
        raise DataError(
            f"{name}: gyro_{'xyz'[axis]} clips at {np.degrees(full_scale):.0f} deg/s in a turn at "
            f"{t[fastest]:.2f} s; "
            "turn the sensor slower"
        )
    gap = int(np.diff(t).argmax())
    if t[gap + 1] - t[gap] > LONGEST_GAP / recording.rate_hz:
        raise DataError(
            f"{name}: {t[gap + 1] - t[gap]:.3f} s without a sample in the turn at {t[gap]:.2f} s; "
            "record without gaps"
        )


def _std_of_turn(recording: Recording, rests: Rests, k: int) -> float:
    """Return the standard deviation between the directions of up, rad.

    Of both rests, and of the bias.
    """
    two = slice(k, k + 2)
    tilt = rests.accel_std[two] / np.linalg.norm(rests.accel[two], axis=1)
    drift = (
        rests.gyro_std[two] / 2 * (recording.t[rests.start[k + 1]] - recording.t[rests.stop[k] - 1])
    )
    return float(np.sqrt(np.square(tilt).sum() + np.square(drift).sum())) + 1e-9


def _up(readings: Floats, matrix: Floats, bias: Floats) -> Floats:
    """Return the direction of corrected readings, shape (k, 3)."""
    corrected = (readings - bias) @ matrix.T
    direction: Floats = corrected / np.linalg.norm(corrected, axis=1, keepdims=True)
    return direction


def _with_coning(angles: Floats) -> Floats:
    """Return rotation vectors of the samples with coning correction.

    This is the two-sample form; see P. G. Savage, "Strapdown inertial navigation integration
    algorithm design, part 1", J. Guidance 21(1), 1998, eqs. 32-34.
    """
    rotation: Floats = angles.copy()
    rotation[:, 1:] += np.cross(angles[:, :-1], angles[:, 1:]) / 12.0
    return rotation


def _product(rotation: Floats) -> Floats:
    """Return the product of the rotations of each row, shape (k, 3, 3).

    Their number is a power of two.
    """
    from scipy.spatial.transform import Rotation

    k, n, _ = rotation.shape
    product: Floats = Rotation.from_rotvec(rotation.reshape(-1, 3)).as_matrix().reshape(k, n, 3, 3)
    while product.shape[1] > 1:
        product = product[:, ::2] @ product[:, 1::2]
    return product[:, 0]


def _across(directions: Floats) -> Floats:
    """Return two unit vectors at right angles to each of k directions, shape (k, 3, 2)."""
    _, _, rows = np.linalg.svd(directions[:, None, :])
    return np.swapaxes(rows[:, 1:], 1, 2)
