"""Strides: the detector's flags joined into stances, and the displacement between them."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from analytic_tracks import places, walk
from footnav.evaluation import path_length
from footnav.strides import find_stances, find_strides

LEVEL = [0.0, 0.0, 0.0, 1.0]
LONGEST_BRIDGED_MOTION = 0.1
SHORTEST_STRIDE = 0.05


def hops(
    points: Any, rest: float = 0.5, move: float = 0.5, rate_hz: float = 100.0
) -> tuple[Any, Any, Any, Any]:
    """Foot that stands on each point for `rest` s and glides to the next one in `move` s."""
    stand, glide = round(rest * rate_hz), round(move * rate_hz)
    position, flag = [], []
    for a, b in pairwise(points):
        position += [np.tile(a, (stand, 1)), np.linspace(a, b, glide)]
        flag += [np.ones(stand, bool), np.zeros(glide, bool)]
    position.append(np.tile(points[-1], (stand, 1)))
    flag.append(np.ones(stand, bool))
    whole = np.concatenate(position)
    return (
        np.arange(len(whole)) / rate_hz,
        whole,
        np.tile(LEVEL, (len(whole), 1)),
        np.concatenate(flag),
    )


def slow_stances(t: Any, flag: Any) -> list[tuple[int, int]]:
    """Join sample by sample, as the definition reads."""
    stances: list[list[int]] = []
    for k in np.flatnonzero(flag):
        if stances and (
            k == stances[-1][1] + 1 or round(t[k] - t[stances[-1][1]], 6) < LONGEST_BRIDGED_MOTION
        ):
            stances[-1][1] = int(k)
        else:
            stances.append([int(k), int(k)])
    return [(a, b) for a, b in stances]


def test_strides_of_a_known_walk() -> None:
    """Number, displacement, times and indices are those that the walk was made with."""
    traj = walk()
    strides = traj.strides
    assert len(strides) == 40
    np.testing.assert_allclose(strides.displacement, np.diff(places(), axis=0), atol=1e-6)
    np.testing.assert_allclose(strides.height_change, 1 / 40, atol=1e-6)
    np.testing.assert_allclose(strides.duration[1:-1], 1.2, atol=0.011)
    np.testing.assert_array_equal(strides.start, traj.t[strides.start_index])
    np.testing.assert_array_equal(strides.end_index[1:-2], strides.start_index[2:-1])
    assert traj.zero_velocity[strides.start_index].all()
    assert traj.zero_velocity[strides.end_index].all()


def test_turn_does_not_depend_on_the_mounting() -> None:
    """A sensor on its side or upside down sees the same turns, left positive."""
    t, position, _, flag = hops(np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float))
    yaw = np.radians(90.0) * np.floor(np.minimum(t + 0.25, 3.0))
    for mounting in Rotation.random(8, rng=np.random.default_rng(3)):
        quaternion = (Rotation.from_euler("z", yaw[:, None]) * mounting).as_quat()
        np.testing.assert_allclose(
            find_strides(t, position, quaternion, flag).heading_change,
            np.radians([90, 90, 90]),
            atol=1e-9,
        )


@given(yaw=st.floats(-np.pi, np.pi), turn=st.floats(-3.1, 3.1), sign=st.sampled_from([-1, 1]))
def test_turn_is_wrapped(yaw: float, turn: float, sign: int) -> None:
    """Neither crossing north nor the quaternion's sign changes the turn."""
    t, position, _, flag = hops(np.array([[0, 0, 0], [1, 0, 0]], float))
    angles = np.where(t < 0.75, yaw, yaw + turn)
    quaternion = (
        Rotation.from_euler("z", angles[:, None]).as_quat() * np.where(t < 0.75, 1, sign)[:, None]
    )
    np.testing.assert_allclose(
        find_strides(t, position, quaternion, flag).heading_change, [turn], atol=1e-9
    )


@pytest.mark.slow
@given(
    flags=st.lists(st.tuples(st.booleans(), st.integers(1, 15)), max_size=12),
    rate_hz=st.sampled_from([100, 200, 397]),
)
def test_stances_agree_with_their_definition(flags: list[tuple[bool, int]], rate_hz: int) -> None:
    """The vectorised search finds what a loop over the samples finds."""
    flag = np.array([value for value, count in flags for _ in range(count)], bool)
    t = np.arange(len(flag)) / rate_hz
    first, last = find_stances(t, flag)
    assert list(zip(first.tolist(), last.tolist(), strict=True)) == slow_stances(t, flag)


@pytest.mark.parametrize("clock", [0.0, 1.7e9])
def test_limits_do_not_depend_on_the_clock(clock: float) -> None:
    """A motion of exactly the longest bridged duration separates two stances, at any offset."""
    flag = np.array([True] * 4 + [False] * 9 + [True] * 4)
    first, last = find_stances(clock + np.arange(17) / 100, flag)
    assert (first.tolist(), last.tolist()) == ([0, 13], [3, 16])
    first, last = find_stances(clock + np.arange(17) / 101, flag)
    assert (first.tolist(), last.tolist()) == ([0], [16])


def test_standing_still_makes_no_slow_stride() -> None:
    """Half a second of a long rest, at the most, belongs to the stride on each side."""
    t, position, quaternion, flag = hops(
        np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0]], float), rest=20
    )
    strides = find_strides(t, position, quaternion, flag)
    assert ((strides.duration >= 0.5) & (strides.duration <= 1.5)).all()
    np.testing.assert_allclose(strides.length, 1)


@pytest.mark.parametrize(
    ("displacement", "counted"),
    [
        ((SHORTEST_STRIDE * 0.98, 0, 0), 0),
        ((SHORTEST_STRIDE * 1.02, 0, 0), 1),
        ((0, 0, -SHORTEST_STRIDE * 0.98), 0),
        ((0, 0, -SHORTEST_STRIDE * 1.02), 1),
        ((0.04, 0.04, 0), 1),
    ],
)
def test_shuffles_are_not_counted(displacement: tuple[float, float, float], counted: int) -> None:
    """A stride goes somewhere: along, up or down."""
    assert len(find_strides(*hops(np.array([[0, 0, 0], displacement], float)))) == counted


@pytest.mark.parametrize("flag", [np.zeros(0, bool), np.zeros(50, bool), np.ones(50, bool)])
def test_no_stride_without_two_stances(flag: Any) -> None:
    """Nothing, always moving, and always at rest have no strides."""
    n = len(flag)
    strides = find_strides(np.arange(n) / 100, np.zeros((n, 3)), np.tile(LEVEL, (n, 1)), flag)
    assert (len(strides), strides.displacement.shape, strides.length.shape) == (0, (0, 3), (0,))


def test_strides_are_read_only() -> None:
    """They belong to the track."""
    with pytest.raises(ValueError, match="read-only"):
        walk(2).strides.displacement[0] = 0


def test_strides_of_real_walks_add_up_to_the_path(data_dir: Path) -> None:
    """Under motion capture, the strides between rests are as long as the path sampled at 2 Hz."""
    ratios = []
    for file in sorted((data_dir / "vicon").glob("*.npz")):
        with np.load(file) as recording:
            t, position = recording["t"], recording["position"]
        speed = np.linalg.norm(np.gradient(position, t, axis=0), axis=1)
        strides = find_strides(t, position, np.tile(LEVEL, (len(t), 1)), speed < 0.15)
        ratios.append(strides.length.sum() / path_length(t, position))
    assert len(ratios) > 20
    assert np.median(ratios) == pytest.approx(1, abs=0.05)
