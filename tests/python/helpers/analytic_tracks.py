"""Tracks in closed form."""

import dataclasses
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from footnav import Health, Trajectory
from footnav.health import Counters, Flag, Status

REST, SWING, STANCE = 2.0, 0.7, 0.5


def places(strides: int = 40) -> Any:
    """Stances on a figure of eight that rises by 1 m, (strides + 1, 3)."""
    lap = np.arange(strides + 1) / strides
    return np.column_stack([8 * np.sin(2 * np.pi * lap), 4 * np.sin(4 * np.pi * lap), lap])


def walk(strides: int = 40, rate_hz: float = 100.0, **options: Any) -> Trajectory:
    """Walk through `places`.

    2 s of rest at both ends, 0.7 s of swing and 0.5 s of stance for each stride.

    The foot rolls all the time, and turns least in the middle of each stance.
    """
    t = np.arange(round((2 * REST + strides * (SWING + STANCE)) * rate_hz) + 1) / rate_hz
    cycle = np.clip((t - REST) / (SWING + STANCE), 0, strides - 1e-9)
    swing = np.clip((cycle % 1) * (SWING + STANCE) / SWING, 0, 1)
    at, stood = places(strides), cycle.astype(int)
    blend = (swing**3 * (10 - 15 * swing + 6 * swing**2))[:, None]
    position = at[stood] + (at[stood + 1] - at[stood]) * blend
    position[:, 2] += 0.12 * np.sin(np.pi * swing) ** 2
    velocity = np.gradient(position, t, axis=0)
    lap = cycle / strides
    yaw = np.arctan2(np.cos(4 * np.pi * lap), np.cos(2 * np.pi * lap))
    pitch = 0.5 * np.cos(2 * np.pi * (t - REST + STANCE / 2) / (SWING + STANCE))
    quaternion = (
        Rotation.from_euler("z", yaw[:, None]) * Rotation.from_euler("y", pitch[:, None])
    ).as_quat()
    zero_velocity = (swing <= 0) | (swing >= 1)
    std = np.column_stack([0.01 * np.sqrt(t), 0.02 * np.sqrt(t), 0.005 * np.sqrt(t)])
    bias = np.full((len(t), 3), 1e-3)
    flags = np.where(t < 1, Flag.ALIGNING, 0).astype(np.uint16)
    return Trajectory(
        t, position, velocity, quaternion, zero_velocity, std, bias, 2 * bias, flags, **options
    )


HEALTH = Health(
    Status.DEGRADED, Flag.GAP | Flag.CLIPPED, Counters(samples=5201, gaps=2, clipped=7), 0.05, 0.02
)
SINGLE = ("health", "name", "origin", "frame", "heading_known", "filter_strides")
COLUMNS = [f.name for f in dataclasses.fields(Trajectory) if f.name not in SINGLE]


def assert_same(a: Trajectory, b: Trajectory) -> None:
    """Two tracks are equal to the bit."""
    for column in COLUMNS:
        np.testing.assert_array_equal(getattr(a, column), getattr(b, column), strict=True)
    assert (a.name, a.origin, a.frame) == (b.name, b.origin, b.frame)
