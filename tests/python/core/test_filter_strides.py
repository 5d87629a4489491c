"""Strides as the filter finds them, with their covariance.

In batch, as events of a stream, and in files.
"""

import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footnav import Config, Navigator, Recording, Strides, Trajectory, simulate, track
from footnav.config import Output, Smoother
from footnav.errors import ConfigError, DataError
from footnav.simulation import Route
from footnav.strides import find_strides
from footnav.trajectory import load_trajectory

GUIDE = Path(__file__).parents[3] / "docs" / "strides.md"
KEPT = Config(output=Output(strides=True))
COLUMNS = [f.name for f in dataclasses.fields(Strides)]


@pytest.fixture(scope="module")
def recording() -> Recording:
    """Record a square, with a rest at both ends."""
    return simulate(Route.square(5.0), seed=2, rate_hz=100.0)[0]


@pytest.fixture(scope="module")
def tracked(recording: Recording) -> Trajectory:
    """Track it, and keep the strides."""
    return track(recording, KEPT)


def assert_same(a: Strides, b: Strides) -> None:
    """Strides are equal to the bit."""
    for column in COLUMNS:
        np.testing.assert_array_equal(getattr(a, column), getattr(b, column))


def test_the_filter_finds_what_is_found_in_the_rows(tracked: Trajectory) -> None:
    """One rule for a stream, for a batch and for a finished track."""
    computed = find_strides(tracked.t, tracked.position, tracked.quaternion, tracked.zero_velocity)
    assert len(computed) > 12
    assert computed.covariance is None
    assert_same(dataclasses.replace(tracked.strides, covariance=None), computed)


def test_covariance_of_a_stride_is_one(tracked: Trajectory) -> None:
    """Symmetric, positive, and much smaller than what the place has become by then."""
    covariance = tracked.strides.covariance
    assert covariance is not None
    assert covariance.shape == (len(tracked.strides), 4, 4)
    np.testing.assert_array_equal(covariance, covariance.swapaxes(1, 2))
    assert (np.linalg.eigvalsh(covariance) > 0).all()
    last = np.sqrt(np.trace(covariance[-1, :2, :2]))
    assert last < 0.5 * np.hypot(*tracked.position_std[tracked.strides.end_index[-1], :2])


def test_strides_are_not_kept_unasked(recording: Recording) -> None:
    """The default track has the same strides without covariance, and a stream raises."""
    assert track(recording).strides.covariance is None
    with pytest.raises(ConfigError, match=r"strides are not tracked: set output\.strides = true"):
        Navigator().strides()


@settings(max_examples=10, deadline=None)
@given(cuts=st.lists(st.integers(0, 2500), max_size=8), stepwise=st.booleans())
def test_events_of_a_stream_are_the_strides_of_the_batch(
    recording: Recording, cuts: list[int], stepwise: bool
) -> None:
    """In any chunking, to the bit."""
    config = KEPT.replace(smoother=Smoother(kind="stepwise")) if stepwise else KEPT
    navigator = Navigator(config, rate_hz=recording.rate_hz)
    events = []
    for part in np.split(np.arange(len(recording)), sorted(cuts)):
        navigator.push_block(recording.t[part], recording.accel[part], recording.gyro[part])
        events += navigator.strides()
    navigator.flush()
    events += navigator.strides()
    assert not len(navigator.strides())
    batch = track(recording, config).strides
    assert len(events) == len(batch)
    for event, stride in zip(events, batch, strict=True):
        for column in COLUMNS:
            np.testing.assert_array_equal(getattr(event, column), getattr(stride, column))


def test_reset_forgets_the_strides(recording: Recording, tracked: Trajectory) -> None:
    """A second walk starts with none, and counts its rows from zero."""
    navigator = Navigator(KEPT, rate_hz=recording.rate_hz)
    navigator.push_block(recording.t[:1200], recording.accel[:1200], recording.gyro[:1200])
    navigator.reset()
    assert not len(navigator.strides())
    navigator.push_block(recording.t, recording.accel, recording.gyro)
    navigator.flush()
    assert [
        stride.end_index for stride in navigator.strides()
    ] == tracked.strides.end_index.tolist()


def test_one_stride_has_the_numbers_of_its_row(tracked: Trajectory) -> None:
    """A stride is a row of the strides, in SI units.

    Its frame is turned by the heading of its start.
    """
    strides = tracked.strides
    for k, stride in enumerate(strides):
        assert (stride.length, stride.height_change) == (
            strides.length[k],
            strides.height_change[k],
        )
        assert stride.duration == strides.duration[k] > 0.5
        np.testing.assert_array_equal(stride.local, strides.local[k])
        displacement = np.exp(1j * stride.start_heading) * complex(*stride.local[:2])
        np.testing.assert_allclose(
            [displacement.real, displacement.imag], stride.displacement[:2], atol=1e-12
        )
    # A foot walks where its toes point: along x of the frame of its stride.
    assert np.median(strides.local[:, 0] / strides.length) > 0.95
    with pytest.raises(ValueError, match="read-only"):
        next(iter(strides)).displacement[0] = 0


def test_archive_keeps_the_covariance(tracked: Trajectory, tmp_path: Path) -> None:
    """What the filter found comes back from .npz, and only if it was there."""
    tracked.save(tmp_path / "kept.npz")
    back = load_trajectory(tmp_path / "kept.npz")
    assert back.filter_strides is not None
    assert_same(back.filter_strides, tracked.strides)
    dataclasses.replace(tracked, filter_strides=None).save(tmp_path / "bare.npz")
    assert load_trajectory(tmp_path / "bare.npz").filter_strides is None


def test_parts_compute_their_strides_again(tracked: Trajectory) -> None:
    """Rows of a part are not those of the whole."""
    joined = Trajectory.concatenate([tracked[:900], tracked[900:]])
    assert_same(joined.strides, dataclasses.replace(tracked.strides, covariance=None))
    assert len(tracked[900:].strides) < len(tracked.strides)


@pytest.mark.parametrize(
    "change",
    [
        lambda traj: {"position": 2 * traj.position},
        lambda traj: {"t": traj.t + 1},
        lambda traj: {
            "filter_strides": dataclasses.replace(
                traj.strides, end_index=traj.strides.end_index + 10_000
            )
        },
        lambda traj: {
            "filter_strides": dataclasses.replace(
                traj.strides, start_index=traj.strides.start_index - 400
            )
        },
    ],
)
def test_strides_of_another_track_are_refused(tracked: Trajectory, change: Any) -> None:
    """Strides of other rows are rejected."""
    message = "filter_strides do not lie between rows of this track: leave them out to compute them"
    with pytest.raises(DataError, match=message):
        dataclasses.replace(tracked, **change(tracked))


def test_the_guide_rebuilds_the_track(capsys: pytest.CaptureFixture[str]) -> None:
    """The example of the guide runs, and its dead reckoning ends where the track does."""
    (example,) = re.findall(
        r"```python run\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.DOTALL
    )
    names: dict[str, Any] = {}
    exec(example, names)
    assert names["apart"] < 0.1
    assert "strides end" in capsys.readouterr().out


def test_errors_of_real_strides_agree_with_their_covariance(data_dir: Path) -> None:
    """Under motion capture the error of a stride's length is about one sigma in most recordings."""
    ratios = []
    for file in sorted((data_dir / "vicon").glob("*.npz"))[:12]:
        with np.load(file) as truth:
            rec, place = Recording(truth["t"], truth["accel"], truth["gyro"]), truth["position"]
        strides = track(rec, KEPT).strides
        assert strides.covariance is not None
        displacement = place[strides.end_index] - place[strides.start_index]
        ahead = strides.local[:, :2] / strides.length[:, None]
        sigma = np.sqrt(np.einsum("ki,kij,kj->k", ahead, strides.covariance[:, :2, :2], ahead))
        ratios.append(
            np.sqrt(
                np.mean(
                    ((np.hypot(displacement[:, 0], displacement[:, 1]) - strides.length) / sigma)
                    ** 2
                )
            )
        )
    assert 0.4 < np.median(ratios) < 1.2
    assert max(ratios) < 3
