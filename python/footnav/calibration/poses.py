"""Poses of a sensor, and those that a calibration lacks."""

from __future__ import annotations

import numpy as np

from footnav.recording import Floats

SIDES = ("+x", "-x", "+y", "-y", "+z", "-z")

DIRECTIONS: Floats = np.repeat(np.eye(3), 2, axis=0) * np.tile([1.0, -1.0], 3)[:, None]
"""Unit vectors of `SIDES`, shape (6, 3)."""

WIDTH_DEG = 40.0
"""A direction within this angle of an axis counts as that side: an edge, at 45 degrees, counts as
none.
"""

DISTINCT_DEG = 10.0
"""Minimum angle between two distinct poses, degrees."""


def sides(vectors: Floats) -> list[str | None]:
    """Name the side that each of k vectors, shape (k, 3), points to; None in between."""
    cosines = _unit(vectors) @ DIRECTIONS.T
    best = cosines.argmax(axis=1)
    near = cosines.max(axis=1) >= np.cos(np.radians(WIDTH_DEG))
    return [SIDES[side] if close else None for side, close in zip(best, near, strict=True)]


def missing_sides(vectors: Floats) -> list[str]:
    """Return the sides that none of k vectors, shape (k, 3), points to."""
    found = set(sides(vectors))
    return [side for side in SIDES if side not in found]


def count_distinct(vectors: Floats) -> int:
    """Count the vectors, shape (k, 3), that differ by `DISTINCT_DEG` or more from one another."""
    kept: list[Floats] = []
    for unit in _unit(vectors):
        if all(unit @ other < np.cos(np.radians(DISTINCT_DEG)) for other in kept):
            kept.append(unit)
    return len(kept)


def _unit(vectors: Floats) -> Floats:
    units: Floats = vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-300)
    return units
