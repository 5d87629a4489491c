"""The experiments of the papers, with few walks: what holds whatever the walk."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from footnav.errors import ConfigError, DataError, FootnavWarning
from footnav.simulation import Route, SensorErrors, simulate
from footnav.tracking import track
from papers import PAPERS, abdulrahim, experiments_of, wang_liu, wu
from papers.command import main
from papers.experiment import Experiment, Simulated, Walk, closing_error, gait_at
from papers.picture import draw
from papers.report import Row, write_json
from papers.run import Outcome, run

pytestmark = pytest.mark.slow

SEEDS = 3
KEYS = {
    "reference": str,
    "experiment": str,
    "approach": str,
    "paper": float | None,
    "ours_median": float | None,
    "ours_p90": float | None,
    "unit": str,
    "distance": float | None,
    "limit": float | None,
    "met": bool | None,
    "seeds": int,
    "note": str,
}


def outcomes(
    paper: str, chosen: Callable[[Experiment], bool], seeds: int = SEEDS
) -> dict[tuple[str, str], Outcome]:
    """Run some of a paper's experiments: outcomes by title and approach."""
    found = run([experiment for experiment in experiments_of(paper) if chosen(experiment)], seeds)
    return {(outcome.experiment.title, outcome.approach.name): outcome for outcome in found}


def test_p1_is_within_its_limit_and_diverges_unaided() -> None:
    """A calibrated sensor, both routes.

    More walks than elsewhere, since a median of three is none.
    """
    found = outcomes("P1", lambda experiment: "uncalibrated" not in experiment.title, seeds=8)
    for title in ("19 m north, calibrated sensor", "17 m square, calibrated sensor"):
        assert found[title, "ZUPT"].met is True
        assert found[title, "ZUPT"].median <= 0.9
    unaided = found["17 m square, calibrated sensor", "INS alone"]
    # In percent of 68 m.
    assert min(unaided.figures) > 10
    assert unaided.met is None


def test_p2_without_the_gyros_bias_is_as_wrong_as_the_paper_and_iaa_is_no_cure() -> None:
    """Trial 5: tens of metres; IAA does not reach the paper's 4 m, a rest at the start nearly."""
    found = outcomes("P2", lambda experiment: experiment.title.startswith("trial 5"))
    figure = {approach: outcome.median for (_, approach), outcome in found.items()}
    assert 15 < figure["ZUPT"] < 120
    assert figure["ZUPT + IAA"] > 15
    assert figure["ZUPT, gyro averaged"] < 15


def test_p3_the_corrections_help_dead_reckoning_and_not_the_filter() -> None:
    """The paper's order of the first three, in the median.

    Where a bias of the gyroscope is lost, walks differ.
    """
    found = outcomes("P3", lambda experiment: experiment.title.endswith("not clipped"), seeds=6)
    median = {approach: outcome.median for (_, approach), outcome in found.items()}
    assert median["DR"] > 2 * median["DR+LWI"] > 2 * median["DR+RV"]
    assert median["DR"] > 2 * median["KF"]
    for corrected in ("KF+LWI", "KF+RV"):
        assert abs(median[corrected] - median["KF"]) < 5


def test_p3_clipping_invalidates_dead_reckoning() -> None:
    """Kilometres, as in the paper; the filter errs by far less."""
    found = outcomes("P3", lambda experiment: experiment.title.endswith("lift, clipped"), seeds=1)
    figures = {approach: outcome.median for (_, approach), outcome in found.items()}
    assert figures["DR"] > 1000
    assert figures["KF"] < figures["DR"] / 20


def test_p4_is_within_its_limit() -> None:
    """All three routes with a sensor that holds the foot's motion."""
    found = outcomes("P4", lambda experiment: "clipped" not in experiment.title, seeds=SEEDS)
    assert len(found) == 3
    for outcome in found.values():
        assert outcome.met is True
        assert outcome.median <= 2.0


def test_the_indoor_route_is_closed_and_takes_six_minutes() -> None:
    """By stairs up, by lift down."""
    walks = abdulrahim.experiments()[0].walks
    walk = walks.load(0)
    assert walk.truth is not None
    assert np.linalg.norm(walk.truth[-1] - walk.truth[0]) < 0.01
    assert walk.truth[:, 2].max() == pytest.approx(4 * 20 * 0.17, abs=0.2)
    assert walk.recording.duration == pytest.approx(360, rel=0.1)
    assert np.abs(walk.recording.gyro).max() == pytest.approx(np.radians(300))


@pytest.mark.parametrize("paper", PAPERS)
def test_every_experiment_states_its_figures(paper: str) -> None:
    """Names are unique, distances are those of the routes, percentages have a distance."""
    experiments = experiments_of(paper)
    assert len({experiment.title for experiment in experiments}) == len(experiments)
    for experiment in experiments:
        names = [approach.name for approach in experiment.approaches]
        assert len(set(names)) == len(names)
        assert experiment.unit == "m" or experiment.distance
        assert isinstance(experiment.walks, Simulated)
        corners = np.array([waypoint.position[:2] for waypoint in experiment.walks.route.waypoints])
        length = np.linalg.norm(np.diff(corners, axis=0), axis=1).sum()
        assert experiment.distance == pytest.approx(length)


def test_p1_walks_as_many_steps_as_the_paper() -> None:
    """32 steps are 16 strides of the foot that carries the sensor."""
    _, truth = simulate(Route.straight(wu.NORTH), wu.GAIT, "ideal", 1)
    assert len(truth.strides) == wu.STEPS / 2


@pytest.mark.parametrize("speed", [0.7, 1.25, 2.05, 2.41])
def test_a_gait_walks_at_its_speed(speed: float) -> None:
    """Within the strides at both ends, which are half ones."""
    gait = gait_at(speed)
    recording, _ = simulate(Route.straight(60.0), gait, "ideal", 1, rate_hz=50)
    walking = recording.duration - gait.rest_before - gait.rest_after
    assert 60 / (walking - gait.stride_duration) == pytest.approx(speed, rel=0.05)


def test_closing_error_is_horizontal() -> None:
    """A track that is the truth, moved and lifted at its end."""
    recording, truth = simulate(Route.straight(3.0), sensor=SensorErrors(), seed=1, rate_hz=50)
    assert closing_error(truth, Walk(recording, truth.position + np.array([5.0, 1.0, 2.0]))) < 1e-12
    ramp = np.linspace(0, 1, len(truth))[:, None]
    assert closing_error(
        truth, Walk(recording, truth.position + ramp * [0.3, 0.4, 2.0])
    ) == pytest.approx(0.5)
    assert closing_error(truth, Walk(recording, None)) == pytest.approx(3.0, abs=0.05)


def test_median_percentile_and_limit() -> None:
    """Of known figures."""
    experiment = wu.experiments()[0]
    outcome = Outcome(experiment, experiment.approaches[0], tuple(0.1 * k for k in range(1, 12)))
    assert (outcome.median, outcome.p90, outcome.met) == (
        pytest.approx(0.6),
        pytest.approx(1.0),
        True,
    )
    assert Outcome(experiment, experiment.approaches[0], (1.0,)).met is False
    assert Outcome(experiment, experiment.approaches[1], (1.0,)).met is None


def test_p2_starts_without_the_mean_of_the_gyroscope() -> None:
    """Its bias is not known at the start, and nothing shows the one about the vertical."""
    walk = wang_liu.experiments()[0].walks.load(0)
    with pytest.warns(FootnavWarning, match="starts in motion"):
        bias = track(walk.recording, wang_liu.ZUPT).gyro_bias[
            : round(wang_liu.REST * wang_liu.RATE_HZ), 2
        ]
    assert np.abs(bias).max() < np.radians(0.05)


def test_rows_of_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One for each experiment and approach, with every key; skipped ones have a note."""
    monkeypatch.delenv("FOOTNAV_DATA", raising=False)
    path = tmp_path / "out.json"
    assert main(["--paper", "P3", "--seeds", "1", "--json", str(path)]) == 0
    rows = json.loads(path.read_text())
    assert len(rows) == sum(len(experiment.approaches) for experiment in experiments_of("P3")) + 1
    for row in rows:
        assert list(row) == list(KEYS)
        for key, kind in KEYS.items():
            assert isinstance(row[key], kind), key
    table_1 = {row["approach"]: row["paper"] for row in rows if row["paper"] is not None}
    assert table_1 == {
        "DR": 3148,
        "DR+LWI": 25.84,
        "DR+RV": 6.16,
        "KF": 2.04,
        "KF+LWI": 1.89,
        "KF+RV": 1.81,
    }
    assert rows[-1]["note"].startswith("skipped: no recordings; name their folder with --data")
    assert rows[-1]["ours_median"] is rows[-1]["met"] is None
    out, err = capsys.readouterr()
    assert "P3 four floors" in out
    assert err == (
        "P3: warning: real recordings skipped: no recordings; "
        "name their folder with --data or in the environment variable FOOTNAV_DATA\n"
    )


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["--paper", "P5"], 2, "unknown paper 'P5': the known ones are P1, P2, P3, P4"),
        (["--seeds", "0"], 2, "--seeds is 0: expected 1 or more"),
        (["--paper", "P3", "--data", "nowhere"], 1, "openshoe: no recordings (*.npz) there"),
    ],
)
def test_misuse_is_reported(
    arguments: list[str], status: int, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """In one line, before anything is run."""
    assert main(arguments) == status
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err
    assert err.count("\n") == 1


def test_unknown_names_and_folders_raise() -> None:
    """For callers of the library, too."""
    with pytest.raises(ConfigError, match="unknown paper 'p1'"):
        experiments_of("p1")
    with pytest.raises(DataError, match="no recordings"):
        experiments_of("P3", Path("nowhere"))
    assert experiments_of("P1", Path("nowhere"))


def test_a_picture_of_an_experiment(tmp_path: Path) -> None:
    """A PNG that is named after it."""
    found = run([wu.experiments()[0]], 1)
    path = draw(found, tmp_path)
    assert path.name == "p1-19-m-north-calibrated-sensor.png"
    assert path.read_bytes().startswith(b"\x89PNG")


def test_rows_are_written(tmp_path: Path) -> None:
    """And an experiment that was skipped has nothing but a note."""
    row = Row.skipped("P3", "real", "why")
    write_json([row], tmp_path / "rows.json")
    assert json.loads((tmp_path / "rows.json").read_text())[0]["note"] == "skipped: why"


def test_recordings_are_clipped(tmp_path: Path) -> None:
    """At the ranges of the paper's sensor, which they carry.

    A walk without a truth is a closed one.
    """
    recording, truth = simulate(Route.straight(5.0), "run", "ideal", 1)
    for folder in ("openshoe", "vicon"):
        (tmp_path / folder).mkdir()
    columns = {"t": recording.t, "accel": recording.accel, "gyro": recording.gyro}
    np.savez(tmp_path / "openshoe" / "a.npz", **columns)
    np.savez(tmp_path / "vicon" / "b.npz", **columns, position=truth.position)
    openshoe, vicon = abdulrahim.recorded(tmp_path)
    walk = openshoe.walks.load(0)
    assert walk.truth is None
    assert np.abs(walk.recording.gyro).max() == walk.recording.gyro_range == np.radians(300)
    assert np.abs(walk.recording.accel).max() == walk.recording.accel_range
    assert walk.recording.name == "a.npz"
    np.testing.assert_array_equal(vicon.walks.load(0).truth, truth.position)


def test_real_recordings_keep_the_order_of_dead_reckoning(data_dir: Path) -> None:
    """On closed walks clipped afterwards, each correction improves on the one before."""
    found = {
        outcome.approach.name: outcome for outcome in run(abdulrahim.recorded(data_dir)[:1], 1)
    }
    assert found["DR"].median > found["DR+LWI"].median > found["DR+RV"].median
    assert found["KF, ranges known"].median < found["KF"].median
