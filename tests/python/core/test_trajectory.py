"""The track of the shoe: its checks, its parts, its summary."""

import dataclasses
import pickle
import subprocess
import sys
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analytic_tracks import COLUMNS, HEALTH, STANCE, SWING, assert_same, places, walk
from footnav.errors import ConfigError, DataError
from footnav.geodesy import check_origin
from footnav.health import Flag
from footnav.summary import Displacement
from footnav.trajectory import Trajectory


def test_arrays_are_read_only_copies() -> None:
    """Neither the track nor the array of its construction can change the other."""
    traj = walk(2)
    t = traj.t.copy()
    copy = dataclasses.replace(traj, t=t)
    t[-1] += 1
    assert_same(copy, traj)
    for column in COLUMNS:
        with pytest.raises(ValueError, match="read-only"):
            getattr(copy, column)[0] = 0


def test_read_only_arrays_are_shared() -> None:
    """A slice of a long track costs no memory."""
    traj = walk(2)
    assert np.shares_memory(traj[10:20].position, traj.position)


@pytest.mark.parametrize("column", COLUMNS[1:])
def test_wrong_shape_names_the_column(column: str) -> None:
    """One row too few is refused."""
    traj = walk(2, name="walk.csv")
    with pytest.raises(DataError, match=rf"walk\.csv: {column} has shape"):
        dataclasses.replace(traj, **{column: getattr(traj, column)[:-1]})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"position": [[1, 2, 3], [4, 5]]}, "position is ragged"),
        (
            {"position": np.zeros((3, 3), complex)},
            "position is of type complex128: expected float64",
        ),
        ({"t": ["a", "b", "c"]}, "t is of type"),
        ({"zero_velocity": [0, 1, 2]}, "zero_velocity has values that do not fit bool"),
        ({"flags": [0, 1, 70_000]}, "flags has values that do not fit uint16"),
        ({"flags": [0, 1, -1]}, "flags has values that do not fit uint16"),
        ({"t": [0.0, 2.0, 1.0]}, r"row 2: t goes back from 2\.0 s to 1\.0 s"),
        ({"t": [0.0, np.nan, 1.0]}, "row 1: t is nan"),
    ],
)
def test_unusable_arrays_are_refused(changes: dict[str, Any], message: str) -> None:
    """What is not what it should be is named, never converted in silence."""
    with pytest.raises(DataError, match=message):
        dataclasses.replace(walk(2)[:3], **changes)


@pytest.mark.parametrize(
    "origin",
    [(91, 0, 0), (0, -181, 0), (0, 0, np.inf), (np.nan, 0, 0), (1, 2), (1, 2, 3, 4), "abc", 5],
)
def test_impossible_origins_are_refused(origin: Any) -> None:
    """An origin is three numbers that name a place on Earth."""
    with pytest.raises(ConfigError, match="origin"):
        dataclasses.replace(walk(2), origin=origin)


def test_origin_becomes_floats() -> None:
    """The poles and the antimeridian belong to the Earth."""
    assert check_origin([90, -180, 5]) == (90.0, -180.0, 5.0)


def test_unknown_frame_is_refused() -> None:
    """Only the two frames of the design exist."""
    with pytest.raises(ConfigError, match="frame is 'nwu'"):
        walk(2, frame="nwu")


@given(cuts=st.lists(st.integers(0, 641), max_size=5))
@settings(max_examples=30, deadline=None)
def test_any_cut_concatenates_to_the_whole(cuts: list[int]) -> None:
    """Slicing and concatenating are inverse, empty parts included."""
    traj = walk(2, name="eight", origin=(43.66, -79.39, 100.0), frame="ned")
    bounds = [0, *sorted(cuts), len(traj)]
    parts = [traj[a:b] for a, b in pairwise(bounds)]
    assert_same(Trajectory.concatenate(parts), traj)


def test_health_belongs_to_the_whole_run() -> None:
    """A part has none; a concatenation has that of the last part."""
    traj = dataclasses.replace(walk(2), health=HEALTH)
    head, tail = traj[:10], dataclasses.replace(traj[10:], health=HEALTH)
    assert head.health is None
    assert Trajectory.concatenate([head, tail]).health == HEALTH


def test_parts_that_do_not_follow_each_other_are_refused() -> None:
    """Time, origin and frame have to go on."""
    traj = walk(2)
    with pytest.raises(DataError, match="t goes back"):
        Trajectory.concatenate([traj[10:], traj[:10]])
    with pytest.raises(DataError, match="part 1 has origin None and frame 'ned'"):
        Trajectory.concatenate([traj[:10], dataclasses.replace(traj[10:], frame="ned")])
    with pytest.raises(DataError, match="no parts"):
        Trajectory.concatenate([])


def test_a_row_is_no_part() -> None:
    """An index is not a slice."""
    with pytest.raises(TypeError, match=r"not 3"):
        walk(2)[3]  # type: ignore[index]


def test_pickled_track_is_the_same() -> None:
    """Worker processes hand tracks back unchanged, and still read-only."""
    traj = dataclasses.replace(walk(2, name="eight", origin=(1.0, 2.0, 3.0)), health=HEALTH)
    copy = pickle.loads(pickle.dumps(traj))
    assert_same(copy, traj)
    assert copy.health == HEALTH
    assert not copy.position.flags.writeable


def test_repr_is_one_line() -> None:
    """It names the track and what is in it."""
    text = repr(walk(name="eight"))
    assert "\n" not in text
    assert "'eight': 5,201 samples, 52.00 s" in text
    assert repr(walk(2)[:0]) == "<Trajectory: empty>"


def test_summary_of_a_known_walk() -> None:
    """Every number follows from the way the walk was made."""
    traj = dataclasses.replace(walk(name="eight"), health=HEALTH)
    summary = traj.summary()
    lengths = np.hypot(*np.diff(places(), axis=0)[:, :2].T)
    assert summary.samples == 5201
    assert summary.duration == pytest.approx(52)
    assert summary.rate_hz == pytest.approx(100)
    assert summary.strides == 40
    assert summary.distance == pytest.approx(lengths.sum(), rel=1e-12)
    assert summary.stride_length == pytest.approx(lengths.mean(), rel=1e-12)
    assert summary.cadence == pytest.approx(60 / (SWING + STANCE), rel=1e-3)
    assert summary.closing.horizontal == pytest.approx(0, abs=1e-6)
    assert summary.closing.vertical == pytest.approx(1, abs=1e-6)
    assert summary.closing_percent.spatial == pytest.approx(100 / lengths.sum(), rel=1e-6)
    assert (summary.lowest, summary.highest) == pytest.approx((0, 1), abs=1e-6)
    assert summary.zero_velocity_share == pytest.approx((40 * 0.5 + 4) / 52, abs=0.01)
    assert summary.greatest_speed == pytest.approx(np.linalg.norm(traj.velocity, axis=1).max())
    assert summary.horizontal_std == pytest.approx(np.sqrt((0.01**2 + 0.02**2) * 52))
    assert summary.vertical_std == pytest.approx(0.005 * np.sqrt(52))


def test_summary_prints_the_main_figures() -> None:
    """Distance, closing error in m and %, strides and health are in the text."""
    text = str(dataclasses.replace(walk(name="eight"), health=HEALTH).summary())
    assert text.startswith("eight: 5,201 samples, 52.00 s at 100.0 Hz\n")
    assert "in 40 strides" in text
    assert "+1.000 m" in text
    assert "Samples are missing." in text


def test_distance_ignores_the_wiggling_foot() -> None:
    """Noise on every sample adds metres to the path, but not to the distance."""
    traj = walk()
    noise = np.random.default_rng(1).normal(0, 0.005, traj.position.shape)
    noisy = dataclasses.replace(traj, position=traj.position + noise)
    wiggling = np.linalg.norm(np.diff(noisy.position[:, :2], axis=0), axis=1).sum()
    assert wiggling > traj.distance + 10
    assert noisy.distance == pytest.approx(traj.distance, rel=2e-3)


@pytest.mark.parametrize("samples", [0, 1])
def test_summary_of_next_to_nothing_is_nan_not_an_error(samples: int) -> None:
    """A stream that has not begun can be asked."""
    summary = walk(2)[:samples].summary()
    assert (summary.samples, summary.strides, summary.distance, summary.duration) == (
        samples,
        0,
        0,
        0,
    )
    assert np.isnan([summary.rate_hz, summary.stride_length, summary.cadence]).all()
    assert "0.00 m in 0 strides" in str(summary)


def test_displacement_in_space() -> None:
    """A 3-4-12 triangle."""
    way = Displacement.of(np.array([3.0, -4.0, -12.0]))
    assert (way.horizontal, way.vertical, way.spatial) == (5, -12, 13)
    assert way.percent_of(50).vertical == -24


def test_reasons_are_described() -> None:
    """Each bit has its sentence, no bit has one too."""
    sentences = [reason.describe() for reason in Flag]
    assert len(set(sentences)) == len(Flag) == 8
    assert (Flag.GAP | Flag.MOVING_START).describe() == f"{sentences[1]} {sentences[4]}"
    assert Flag(0).describe() not in sentences
    assert "DEGRADED" in str(HEALTH)
    assert "5,201 samples: 0 repeated, 2 gaps, 7 clipped" in str(HEALTH)


def test_nothing_heavy_is_imported() -> None:
    """Importing stays cheap: the heavy libraries load where they are used."""
    script = (
        "import sys, footnav.trajectory, footnav.export, footnav.evaluation, footnav.plot\n"
        "heavy = {'matplotlib', 'scipy', 'gpxpy', 'pymap3d', 'pyarrow'} & set(sys.modules)\n"
        "sys.exit(repr(heavy) if heavy else 0)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
