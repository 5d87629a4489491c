"""Pictures: what they show, and how they are written."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from analytic_tracks import REST, walk
from footnav.detection import Detection
from footnav.detectors import ThreeCondition
from footnav.errors import ConfigError, DataError, FootnavError
from footnav.plot import (
    overview,
    plot_conditions,
    plot_detector,
    plot_height,
    plot_track,
    plot_velocity,
    save_overview,
)
from footnav.recording import Recording
from footnav.trajectory import Trajectory


@pytest.fixture(scope="module")
def traj() -> Trajectory:
    """Walk a figure of eight."""
    return walk(name="figure of eight")


def truth_of(traj: Trajectory) -> Any:
    """Truth in a frame of its own, that the track leaves slowly."""
    x, y, z = traj.position.T
    return np.column_stack([-y * 1.02 + 30, x - 10, 0.97 * z])


def detection_of(traj: Trajectory) -> Detection:
    """Statistic as of a SHOE detector."""
    noise = np.random.default_rng(2).lognormal(0, 0.6, len(traj))
    statistic = np.where(traj.zero_velocity, 2e4, 3e7) * noise
    return Detection(
        t=traj.t, statistic=statistic, threshold=2e5 * noise, decision=traj.zero_velocity
    )


def lines(ax: Any) -> dict[str, Any]:
    """Points of each labelled line."""
    return {line.get_label(): line.get_xydata() for line in ax.get_lines()}


def test_track_is_drawn_from_above(traj: Trajectory) -> None:
    """Every sample, every stance, equal scales."""
    ax = plot_track(traj)
    np.testing.assert_array_equal(lines(ax)["track"], traj.position[:, :2])
    assert len(lines(ax)["stance"]) == 41
    assert ax.get_aspect() == 1
    np.testing.assert_array_equal(lines(ax)["start"], traj.position[:1, :2])
    np.testing.assert_array_equal(lines(ax)["end"], traj.position[-1:, :2])
    assert "(m)" in ax.get_xlabel()


def test_truth_is_brought_to_the_track(traj: Trajectory) -> None:
    """A truth in another frame lies on the track, and is dashed."""
    x, y, z = traj.position.T
    ax = plot_track(traj, np.column_stack([30 - y, x - 10, z + 2]))
    np.testing.assert_allclose(lines(ax)["truth"], traj.position[:, :2], atol=1e-9)
    dashed = next(line for line in ax.get_lines() if line.get_label() == "truth")
    assert dashed.is_dashed()


def test_height_and_speed_over_time(traj: Trajectory) -> None:
    """Against the stamps, from the first to the last."""
    height, speed = plot_height(traj, traj), plot_velocity(traj)
    np.testing.assert_array_equal(height.get_lines()[0].get_ydata(), traj.position[:, 2])
    np.testing.assert_array_equal(height.get_lines()[1].get_ydata(), traj.position[:, 2])
    np.testing.assert_allclose(
        np.asarray(speed.get_lines()[0].get_ydata()), np.sqrt((traj.velocity**2).sum(1))
    )
    assert height.get_xlim() == speed.get_xlim() == (0, 52)


def test_rest_is_shaded(traj: Trajectory) -> None:
    """One band for each stance, the first one the rest before the walk."""
    (shade,) = plot_velocity(traj).collections
    bands = [np.asarray(polygon) for path in shade.get_paths() for polygon in path.to_polygons()]
    assert len(bands) == 41
    assert min(band[:, 0].max() for band in bands) == pytest.approx(REST, abs=0.011)


def test_detector_is_logarithmic(traj: Trajectory) -> None:
    """With its threshold as a labelled line."""
    detection = detection_of(traj)
    detection.statistic[:3] = 0
    detection.threshold[-2:] = np.nan
    ax = plot_detector(detection)
    statistic, threshold = (np.asarray(line.get_ydata()) for line in ax.get_lines())
    assert ax.get_yscale() == "log"
    assert np.isnan(statistic[:3]).all()
    np.testing.assert_array_equal(statistic[3:], detection.statistic[3:])
    np.testing.assert_array_equal(threshold, detection.threshold)
    assert [text.get_text() for text in ax.texts] == ["threshold"]


@pytest.mark.parametrize(
    ("statistic", "threshold"),
    [([], []), ([0.0, -1.0], [1.0, 1.0]), ([1.0] * 2, [0.0] * 2), ([np.nan], [np.nan])],
)
def test_detector_that_cannot_be_drawn_is_refused(statistic: Any, threshold: Any) -> None:
    """There is no sample, or nothing is positive."""
    columns = (
        np.arange(float(len(statistic))),
        np.array(statistic),
        np.array(threshold),
        np.ones(len(statistic), bool),
    )
    with pytest.raises(DataError, match="nothing to draw"):
        plot_detector(Detection(*columns))


def test_empty_track_is_refused(traj: Trajectory) -> None:
    """There is nothing to draw."""
    for plot in (plot_track, plot_height, plot_velocity, overview):
        with pytest.raises(DataError, match="the track is empty"):
            plot(traj[:0])


@pytest.mark.slow
@pytest.mark.parametrize("samples", [1, 2, 150])
def test_short_tracks_are_drawn(traj: Trajectory, samples: int) -> None:
    """One sample, and a rest without a stride, do not trip matplotlib."""
    overview(traj[:samples]).draw_without_rendering()


def test_given_axes_are_used(traj: Trajectory) -> None:
    """And returned."""
    ax = Figure().add_subplot()
    assert plot_velocity(traj, ax) is ax
    assert plot_track(traj, ax=ax) is ax
    assert len(ax.figure.axes) == 1


def test_overview_has_a_panel_for_each_view(traj: Trajectory) -> None:
    """Track, height, speed, and the detector on demand; the time axes are one."""
    assert len(overview(traj).axes) == 3
    figure = overview(traj, truth_of(traj), detection_of(traj), title="A walk")
    assert figure.get_suptitle() == "A walk"
    assert len(figure.axes) == 4
    figure.axes[1].set_xlim(3, 4)
    assert figure.axes[3].get_xlim() == (3, 4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("suffix", "start"),
    [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF"), (".PNG", b"\x89PNG")],
)
def test_pictures_are_written(traj: Trajectory, tmp_path: Path, suffix: str, start: bytes) -> None:
    """In the format that the suffix names."""
    save_overview(traj[:1000], tmp_path / f"walk{suffix}")
    assert (tmp_path / f"walk{suffix}").read_bytes().startswith(start)


def test_unknown_picture_is_refused(traj: Trajectory, tmp_path: Path) -> None:
    """Before anything is drawn."""
    with pytest.raises(ConfigError, match=r"unknown suffix '\.bmp', expected one of \.png"):
        save_overview(traj, tmp_path / "walk.bmp")


def test_old_picture_is_unchanged_after_a_failure(
    traj: Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk leaves what was there."""

    def full(*_: Any, **__: Any) -> None:
        raise OSError(28, "No space left on device")

    path = tmp_path / "walk.png"
    path.write_text("old")
    monkeypatch.setattr(Figure, "savefig", full)
    with pytest.raises(FootnavError, match=r"walk\.png: cannot be written: No space left"):
        save_overview(traj, path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_missing_matplotlib_names_its_cure(
    traj: Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The message is a command that helps."""
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(FootnavError, match=r"matplotlib is missing: pip install footnav\[plot\]"):
        overview(traj)


@pytest.mark.slow
def test_pyplot_is_not_used(tmp_path: Path) -> None:
    """A program that has chosen its own backend keeps it."""
    walk(2).save(tmp_path / "walk.npz")
    script = (
        "import sys; from footnav.trajectory import load_trajectory; from footnav.plot import save_overview\n"
        f"save_overview(load_trajectory({str(tmp_path / 'walk.npz')!r}), {str(tmp_path / 'walk.png')!r})\n"
        "sys.exit('matplotlib.pyplot' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_each_condition_has_a_panel_in_units_of_its_threshold() -> None:
    """And the last one is their conjunction."""
    rng = np.random.default_rng(5)
    moving = np.repeat([0.0, 1.0, 0.0], 100)[:, None]
    accel = np.array([0.0, 0.0, 9.81]) + (0.01 + 3 * moving) * rng.normal(size=(300, 3))
    rec = Recording(np.arange(300) / 100, accel, (0.01 + 2 * moving) * rng.normal(size=(300, 3)))
    panels = plot_conditions(rec, ThreeCondition(rate_threshold=0.7)).axes
    assert [ax.get_ylabel() for ax in panels] == ["magnitude", "variance", "rate", "all"]
    *alone, together = (np.asarray(ax.get_lines()[0].get_ydata()) for ax in panels)
    np.testing.assert_allclose(together, np.max(alone, axis=0))
    inside = np.isfinite(together)
    np.testing.assert_allclose(alone[2][inside], np.linalg.norm(rec.gyro, axis=1)[inside] / 0.7)
