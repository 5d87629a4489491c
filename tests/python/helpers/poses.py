"""A sensor on a table that a person turns from pose to pose, as blocks of samples."""

from collections.abc import Iterable, Iterator

import numpy as np

from footnav.capture import Block, Setup

RATE = 200
GRAVITY = 9.80665

UP = {
    "+x": (1, 0, 0),
    "-x": (-1, 0, 0),
    "+y": (0, 1, 0),
    "-y": (0, -1, 0),
    "+z": (0, 0, 1),
    "-z": (0, 0, -1),
}

Pose = tuple[object, float]
"""What points up, the name of a side or a vector, and for how many seconds."""


def tilts(n: int) -> list[tuple[float, float, float]]:
    """Directions that are no sides, and far from each other."""
    edges = [(a, b, 0) for a in (1, -1) for b in (1, -1)]
    corners = [(a, b, c) for a in (1, -1) for b in (1, -1) for c in (1, -1)]
    return [*corners, *edges, *[(b, 0, a) for a, b, _ in edges]][:n]


def counts(
    poses: Iterable[Pose], noise: float = 1.0, turn: float = 0.8, seed: int = 1
) -> np.ndarray:
    """Make raw counts at 16 g and 2000 deg/s, shape (n, 7).

    The shortest turn between two poses takes `turn` s.
    """
    rng = np.random.default_rng(seed)
    ups, rates = [], []
    last = None
    for up, seconds in poses:
        direction = np.array(UP.get(up, up) if isinstance(up, str) else up, dtype=float)
        direction /= np.linalg.norm(direction)
        if last is not None and turn:
            turned, rate = _turn(last, direction, turn)
            ups.append(turned)
            rates.append(rate)
        n = round(seconds * RATE)
        ups.append(np.tile(direction, (n, 1)))
        rates.append(np.zeros((n, 3)))
        last = direction
    accel = GRAVITY * np.concatenate(ups) * [1.01, 0.99, 1.02] + [0.1, -0.2, 0.15]
    gyro = np.concatenate(rates) + np.radians([3, -5, 1])
    accel += rng.normal(0, 0.04 * noise, accel.shape)
    gyro += rng.normal(0, 0.001 * noise, gyro.shape)
    warmth = np.full((len(accel), 1), -2160.0)
    scale = 32768 / np.array([16 * GRAVITY, np.radians(2000)])
    return np.rint(np.hstack([accel * scale[0], warmth, gyro * scale[1]])).astype(int)


def _turn(start: np.ndarray, end: np.ndarray, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the up vector and the angular rate of a smooth turn, along the sensor's axes."""
    axis = np.cross(start, end)
    angle = np.arctan2(np.linalg.norm(axis), start @ end)
    if np.linalg.norm(axis) < 1e-6:
        # To the opposite side about any level axis; back to the same pose all the way round.
        axis, angle = np.cross(start, np.eye(3)[np.abs(start).argmin()]), angle or 2 * np.pi
    axis /= np.linalg.norm(axis)
    n = round(seconds * RATE)
    share = (np.arange(n)[:, np.newaxis] + 0.5) / n
    phase = angle * (1 - np.cos(np.pi * share)) / 2
    speed = angle * np.pi / 2 * np.sin(np.pi * share) / seconds
    up = (
        start * np.cos(phase)
        + np.cross(axis, start) * np.sin(phase)
        + axis * (axis @ start) * (1 - np.cos(phase))
    )
    return up, -speed * axis


def blocks(raw: np.ndarray, size: int = 7) -> Iterator[Block]:
    """Cut the counts as they come from a source."""
    t = np.arange(len(raw)) / RATE
    for k in range(0, len(raw), size):
        yield Block.from_counts(t[k : k + size], raw[k : k + size], Setup())
