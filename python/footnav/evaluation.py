"""Errors of a track against the truth.

References
----------
Wagstaff, Peretroukhin, Kelly 2019: the ARMSE and the alignment of the yaw at 0.8 m. Umeyama 1991,
IEEE TPAMI 13(4): the least-squares alignment, here with a rotation about the vertical alone.
"""

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footnav.errors import ConfigError, DataError, FootnavWarning
from footnav.summary import Displacement
from footnav.trajectory import Trajectory

Floats = NDArray[np.float64]
Truth = Trajectory | ArrayLike | tuple[ArrayLike, ArrayLike]

ALIGNMENTS = ("yaw", "umeyama-yaw", "start", "none")

YAW_DISTANCE = 0.8
PATH_INTERVAL = 0.5
STAMP_ROUNDING = 1e-6


@dataclass(frozen=True, slots=True)
class Evaluation:
    """Errors of a track against the truth.

    Attributes
    ----------
    align : str
        Method of the alignment.
    samples : int
        Number of compared samples.
    armse : float
        Mean over the samples of sqrt((dx^2 + dy^2) / 2), m.
    euclidean_mean : float
        Mean horizontal error, m.
    height_rms : float
        Root mean square of the height error, m.
    rmse_3d : float
        Root mean square of the error in space, m.
    max : float
        Greatest error in space, m.
    closing_error : Displacement
        From the end of the truth to the end of the track, after alignment, m.
    distance : float
        Horizontal length of the truth, sampled every 0.5 s, m.
    percent_of_distance : float
        Horizontal closing error in percent of the distance; nan where the distance is zero.
    """

    align: str
    samples: int
    armse: float
    euclidean_mean: float
    height_rms: float
    rmse_3d: float
    max: float
    closing_error: Displacement
    distance: float
    percent_of_distance: float

    def __str__(self) -> str:
        """Write the errors as a small table."""
        end = self.closing_error
        return "\n".join(
            [
                f"{self.samples:,} samples against {self.distance:.2f} m of truth, aligned by "
                f"{self.align!r}",
                f"  ARMSE          {self.armse:.3f} m",
                f"  mean           {self.euclidean_mean:.3f} m horizontal",
                f"  height         {self.height_rms:.3f} m RMS",
                f"  in space       {self.rmse_3d:.3f} m RMS, {self.max:.3f} m at most",
                f"  at the end     {end.horizontal:.3f} m ({self.percent_of_distance:.2f} % of "
                "the distance) horizontal, "
                f"{end.vertical:+.3f} m vertical, {end.spatial:.3f} m in space",
            ]
        )


@dataclass(frozen=True, slots=True)
class Alignment:
    """A rotation about the vertical and a shift.

    Attributes
    ----------
    yaw : float
        Rotation angle, rad, positive to the left.
    source, target : (3,) ndarray
        A point, and its image, m.
    """

    yaw: float
    source: Floats
    target: Floats

    def apply(self, position: Floats) -> Floats:
        """Transform positions (n, 3), m, from the frame of the estimate to that of the truth."""
        return _turned(position - self.source, self.yaw) + self.target

    def undo(self, position: Floats) -> Floats:
        """Transform positions (n, 3), m, from the frame of the truth to that of the estimate."""
        return _turned(position - self.target, -self.yaw) + self.source


def evaluate(traj: Trajectory, truth: Truth, *, align: str = "yaw") -> Evaluation:
    """Compare a track with the truth.

    Parameters
    ----------
    traj : Trajectory
        The estimate.
    truth : Trajectory, (n, 3) array-like, or tuple (t, position)
        Positions with z up, m.  An array has one row for each sample of `traj`; the others are
        interpolated linearly at `traj.t` and have to cover it.
    align : {"yaw", "umeyama-yaw", "start", "none"}
        "yaw" aligns the starts and rotates the estimate about the vertical so that the directions
        from the start agree at its first sample that is 0.8 m away.  "umeyama-yaw" rotates and
        shifts it for the least sum of squared errors.  "start" aligns the starts.

    Returns
    -------
    Evaluation
        The errors.

    Raises
    ------
    ConfigError
        For an unknown `align`.
    DataError
        For a truth that does not fit the track, does not cover it, or is not finite.

    Warns
    -----
    FootnavWarning
        When the estimate stays within 0.8 m of its start; "yaw" then uses its farthest sample.
    """
    position = true_positions(traj, truth)
    error = find_alignment(traj.position, position, align).apply(traj.position) - position
    horizontal = np.hypot(error[:, 0], error[:, 1])
    spatial = np.linalg.norm(error, axis=1)
    closing = Displacement.of(error[-1])
    distance = path_length(traj.t, position)
    return Evaluation(
        align=align,
        samples=len(traj),
        armse=float(horizontal.mean() / np.sqrt(2)),
        euclidean_mean=float(horizontal.mean()),
        height_rms=_rms(error[:, 2]),
        rmse_3d=_rms(spatial),
        max=float(spatial.max()),
        closing_error=closing,
        distance=distance,
        percent_of_distance=closing.percent_of(distance).horizontal,
    )


def true_positions(traj: Trajectory, truth: Truth) -> Floats:
    """Interpolate the truth at the samples of a track; see `evaluate` for its forms.

    Returns
    -------
    (n, 3) ndarray
        m.

    Raises
    ------
    DataError
        For a truth that does not fit the track, does not cover it, or is not finite, and for a
        track that is not finite or has fewer than two samples.
    """
    if len(traj) < 2:
        raise DataError(f"the track has {len(traj)} samples: a comparison needs two or more")
    _check_finite("track", traj.position)
    if isinstance(truth, Trajectory):
        return _interpolated(traj.t, truth.t, truth.position)
    if isinstance(truth, tuple):
        return _interpolated(traj.t, *_stamped(truth))
    position = _floats("truth", truth)
    if position.shape != (len(traj), 3):
        raise DataError(
            f"truth has shape {position.shape}, expected ({len(traj)}, 3): one row for each "
            "sample of the track; "
            "give (t, position) when its stamps are its own"
        )
    _check_finite("truth", position)
    return position


def find_alignment(estimate: Floats, truth: Floats, align: str) -> Alignment:
    """Find rotation and shift of an estimate (n, 3) to the truth (n, 3), m.

    See `evaluate` for `align`.

    Raises
    ------
    ConfigError
        For an unknown `align`.
    """
    if align == "none":
        return Alignment(0.0, np.zeros(3), np.zeros(3))
    if align == "start":
        return Alignment(0.0, estimate[0], truth[0])
    if align == "yaw":
        return Alignment(
            _yaw_at_distance(estimate - estimate[0], truth - truth[0]), estimate[0], truth[0]
        )
    if align == "umeyama-yaw":
        source, target = estimate.mean(axis=0), truth.mean(axis=0)
        return Alignment(_least_squares_yaw(estimate - source, truth - target), source, target)
    raise ConfigError(f"align is {align!r}: expected one of {', '.join(ALIGNMENTS)}")


def path_length(t: Floats, position: Floats) -> float:
    """Length of a path, without the motion of the foot within a stride.

    Parameters
    ----------
    t : (n,) ndarray
        Stamps, s.
    position : (n, 3) ndarray
        m.

    Returns
    -------
    float
        Horizontal length of the polygon through a sample every 0.5 s and the last one, m.
    """
    corners = np.append(np.searchsorted(t, np.arange(t[0], t[-1], PATH_INTERVAL)), len(t) - 1)
    return float(np.linalg.norm(np.diff(position[corners, :2], axis=0), axis=1).sum())


def _turned(vectors: Floats, yaw: float) -> Floats:
    """Rotate vectors (n, 3) about the vertical."""
    from scipy.spatial.transform import Rotation

    turned: Floats = Rotation.from_euler("z", yaw).apply(vectors)
    return turned


def _yaw_at_distance(estimate: Floats, truth: Floats) -> float:
    """Angle between both at the first sample of the estimate that is far enough from the start."""
    away = np.hypot(estimate[:, 0], estimate[:, 1])
    far = np.flatnonzero(away >= YAW_DISTANCE)
    if not far.size:
        warnings.warn(
            f"the track stays within {away.max():.2f} m of its start, so its yaw is aligned at "
            "its farthest sample "
            f"instead of at {YAW_DISTANCE} m; align='umeyama-yaw' uses all of it",
            FootnavWarning,
            stacklevel=4,
        )
    k = far[0] if far.size else away.argmax()
    return float(np.arctan2(truth[k, 1], truth[k, 0]) - np.arctan2(estimate[k, 1], estimate[k, 0]))


def _least_squares_yaw(estimate: Floats, truth: Floats) -> float:
    """Yaw that maximizes sum(truth . R estimate) of centred points.

    Tan(yaw) = sum(cross) / sum(dot).
    """
    cross = (estimate[:, 0] * truth[:, 1] - estimate[:, 1] * truth[:, 0]).sum()
    dot = (estimate[:, :2] * truth[:, :2]).sum()
    return float(np.arctan2(cross, dot))


def _interpolated(t: Floats, truth_t: Floats, position: Floats) -> Floats:
    """Interpolate the truth at the stamps of the track, without extrapolation."""
    _check_finite("truth", position)
    if len(truth_t) == 0:
        raise DataError("truth is empty")
    missing = max(truth_t[0] - t[0], t[-1] - truth_t[-1])
    if missing > STAMP_ROUNDING:
        raise DataError(
            f"truth covers {truth_t[0]} s to {truth_t[-1]} s, the track {t[0]} s to {t[-1]} s: "
            "cut the track to the truth, as in traj[a:b]"
        )
    return np.column_stack([np.interp(t, truth_t, axis) for axis in position.T])


def _stamped(truth: tuple[Any, ...]) -> tuple[Floats, Floats]:
    if len(truth) != 2:
        raise DataError(f"truth is a tuple of {len(truth)}: expected (t, position)")
    t, position = _floats("truth t", truth[0]), _floats("truth position", truth[1])
    if t.ndim != 1 or position.shape != (len(t), 3):
        raise DataError(
            f"truth has shapes {t.shape} and {position.shape}: expected (n,) and (n, 3)"
        )
    _check_finite("truth t", t)
    back = np.flatnonzero(np.diff(t) < 0)
    if back.size:
        row = back[0] + 1
        raise DataError(f"truth, row {row}: t goes back from {t[row - 1]} s to {t[row]} s")
    return t, position


def _floats(label: str, value: Any) -> Floats:
    try:
        return np.asarray(value, float)
    except (ValueError, TypeError) as error:
        raise DataError(f"{label} is not an array of numbers: {error}") from None


def _check_finite(label: str, array: Floats) -> None:
    finite = np.isfinite(array)
    bad = np.flatnonzero(~(finite if array.ndim == 1 else finite.all(axis=1)))
    if bad.size:
        raise DataError(
            f"{label}, row {bad[0]}: {array[bad[0]]} is not finite ({bad.size} such rows); "
            "remove the rows, and give (t, position) for a truth with rows missing"
        )


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))
