"""Simulation of a sensor that is turned from pose to pose, as for a calibration."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from footnav import _core
from footnav.config import Config
from footnav.errors import ConfigError
from footnav.recording import Floats, Recording
from footnav.settings import encode
from footnav.simulation import SensorErrors

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

_ROUND_X = [[0, 0, 1], [0, 1, 1], [0, 1, 0], [0, 1, -1], [0, 0, -1]]
_ROUND_Z = [[1, 0, -1], [1, 0, 0], [1, 0, 1], [1, 1, 0], [-1, 1, 0], [-1, 0, 0], [-1, 0, -1]]
_UNDER = [[0, -1, -1], [0, -1, 0], [0, -1, 1], [1, -1, 0], [-1, -1, 0], [-1, 0, 1]]

SIDES_AND_EDGES: Floats = np.array([*_ROUND_X, *_ROUND_Z, *_UNDER], dtype=np.float64)
"""The six sides and the twelve edges of a box: direction of up in the sensor's axes, pose by pose.
"""


def simulate_poses(
    poses: ArrayLike = SIDES_AND_EDGES,
    sensor: SensorErrors | str = "mpu6050",
    seed: int = 0,
    *,
    turns: Sequence[ArrayLike] = (),
    rate_hz: float = 100.0,
    initial: float = 5.0,
    rest: float = 3.0,
    move: float = 1.5,
    gravity: float | None = None,
) -> Recording:
    """Simulate a sensor that is turned from pose to pose, with rests between.

    Parameters
    ----------
    poses : array_like, shape (k, 3)
        Up in the axes of the sensor, of any length: (0, 0, 1) lies flat.  Each pose has a random
        heading.
    sensor : SensorErrors or str
        Sensor errors; a string names a preset.  The same seed and errors are the same
        sensor as in `footnav.simulate`.
    seed : int
        The same seed gives the same recording.
    turns : sequence of array_like, shape (3,)
        Rotation vectors in the axes of the sensor, rad, to be turned by in the last pose, with
        rests between.
    rate_hz : float
        Samples per second.
    initial, rest, move : float
        Length of the rest at the start, of every other rest and of every move, s.
    gravity : float, optional
        m/s²; the default is that of ``Config()``.

    Returns
    -------
    Recording
        Readings of the sensor; it moves smoothly and turns about its own centre.

    Raises
    ------
    ConfigError
        A parameter is out of range; the message names it.
    """
    from scipy.spatial.transform import Rotation

    up = _directions(poses)
    for label, value in {
        "rate_hz": rate_hz,
        "initial": initial,
        "rest": rest,
        "move": move,
    }.items():
        if not (np.isfinite(value) and value > 0):
            raise ConfigError(f"{label} is {value}; expected a positive number")
    errors = SensorErrors.preset(sensor) if isinstance(sensor, str) else sensor
    drawn = np.random.default_rng(seed).uniform(-np.pi, np.pi, len(up))
    headings = Rotation.from_rotvec(drawn[:, None] * [0.0, 0.0, 1.0])
    attitudes = headings * Rotation.concatenate([_level(direction) for direction in up])
    moves = [(attitudes[k].inv() * attitudes[k + 1]).as_rotvec() for k in range(len(up) - 1)]
    steps = np.vstack([*moves, *turns]) if moves or turns else np.zeros((0, 3))

    stamps = np.arange(round(rate_hz * (initial + len(steps) * (move + rest)))) / rate_hz
    # Half steps lie between, so that Simpson's rule can average the specific force over each
    # interval.
    fine = (np.arange(2 * len(stamps) + 1) / 2 - 1.0) / rate_hz
    motion = _motion(fine, attitudes[0], steps, initial, rest, move)
    weight = Config().gravity if gravity is None else gravity
    force = motion.inv().apply([0.0, 0.0, weight])
    truth_accel = (force[:-2:2] + 4 * force[1:-1:2] + force[2::2]) / 6
    truth_gyro = (motion[:-2:2].inv() * motion[2::2]).as_rotvec() * rate_hz
    accel, gyro = _core.corrupt(encode(errors), seed, stamps, truth_accel, truth_gyro)
    return Recording(
        stamps,
        accel,
        gyro,
        name=f"simulated poses {seed}",
        accel_range=errors.accel.range,
        gyro_range=errors.gyro.range,
    )


def _directions(poses: ArrayLike) -> Floats:
    directions = np.asarray(poses, dtype=np.float64)
    if directions.ndim != 2 or directions.shape[1] != 3 or not len(directions):
        raise ConfigError(
            f"poses have shape {directions.shape}; expected (k, 3), up in the axes of the sensor"
        )
    lengths = np.linalg.norm(directions, axis=1, keepdims=True)
    if not (np.isfinite(lengths).all() and lengths.all()):
        raise ConfigError(
            f"pose {int(np.argmin(lengths))} points nowhere; expected up in the axes of the sensor"
        )
    units: Floats = directions / lengths
    return units


def _level(up: Floats) -> Rotation:
    """Return an attitude in which `up` points up."""
    from scipy.spatial.transform import Rotation

    return Rotation.align_vectors([[0.0, 0.0, 1.0]], up[None])[0]


def _motion(
    fine: Floats, start: Rotation, steps: Floats, initial: float, rest: float, move: float
) -> Rotation:
    """Return the attitude at each time.

    Smooth moves by the rotation vectors `steps` with rests between.
    """
    from scipy.spatial.transform import Rotation

    reached = [start]
    for step in steps:
        reached.append(reached[-1] * Rotation.from_rotvec(step))
    which = np.clip(
        np.floor((fine - initial) / (move + rest)).astype(int), 0, max(len(steps) - 1, 0)
    )
    if not len(steps):
        return Rotation.concatenate([start] * len(fine))
    share = np.clip((fine - initial - which * (move + rest)) / move, 0.0, 1.0)
    # Rate and its change vanish at both ends.
    smooth = share**3 * (10 - 15 * share + 6 * share**2)
    return Rotation.concatenate(reached)[which] * Rotation.from_rotvec(
        smooth[:, None] * steps[which]
    )
