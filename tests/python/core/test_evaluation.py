"""Errors against the truth: exact cases, invariances, and independent minimisation."""

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from analytic_tracks import walk
from footnav.errors import ConfigError, DataError, FootnavWarning
from footnav.evaluation import evaluate, find_alignment, path_length
from footnav.summary import Displacement
from footnav.trajectory import Trajectory

NUMBERS = [
    "armse",
    "euclidean_mean",
    "height_rms",
    "rmse_3d",
    "max",
    "distance",
    "percent_of_distance",
]


def moved(position: Any, yaw: float, shift: Any) -> Any:
    """Turn about the vertical, then shift."""
    return Rotation.from_euler("z", yaw).apply(np.array(position)) + shift


def drifting(traj: Trajectory) -> Trajectory:
    """Estimate whose yaw and scale go wrong as it walks."""
    x, y, z = traj.position.T
    yaw = 0.003 * traj.t
    drifted = np.column_stack(
        [x * np.cos(yaw) - y * np.sin(yaw), x * np.sin(yaw) + 1.02 * y * np.cos(yaw), 1.1 * z]
    )
    return dataclasses.replace(traj, position=drifted)


def numbers(evaluation: Any) -> list[float]:
    """All numbers of an evaluation."""
    end = evaluation.closing_error
    return [getattr(evaluation, name) for name in NUMBERS] + [
        end.horizontal,
        end.vertical,
        end.spatial,
    ]


@pytest.mark.parametrize("align", ["yaw", "umeyama-yaw", "start", "none"])
def test_truth_itself_has_no_error(align: str) -> None:
    """Whatever the alignment."""
    traj = walk()
    evaluation = evaluate(traj, traj, align=align)
    assert evaluation.max == pytest.approx(0, abs=1e-12)
    assert evaluation.distance == path_length(traj.t, traj.position)


def test_numbers_of_a_constant_error() -> None:
    """An offset of (3, 4, 12) m has a horizontal error of 5 m and one of 13 m in space."""
    traj = walk()
    evaluation = evaluate(traj, traj.position - [3.0, 4.0, 12.0], align="none")
    assert evaluation.armse == pytest.approx(5 / np.sqrt(2))
    assert evaluation.euclidean_mean == pytest.approx(5)
    assert evaluation.height_rms == pytest.approx(12)
    assert evaluation.rmse_3d == pytest.approx(13)
    assert evaluation.max == pytest.approx(13)
    assert evaluation.closing_error.horizontal == pytest.approx(5)
    assert evaluation.closing_error.vertical == pytest.approx(12)
    assert evaluation.closing_error.spatial == pytest.approx(13)
    assert evaluation.percent_of_distance == pytest.approx(500 / evaluation.distance)
    assert evaluate(traj, traj.position - [3.0, 4.0, 12.0], align="start").max == pytest.approx(
        0, abs=1e-12
    )


def test_numbers_agree_with_their_formulas() -> None:
    """Mean of the RMSE over both axes, and evo's rmse and max, written out sample by sample."""
    estimate, truth = drifting(walk()), walk().position
    difference = (estimate.position - truth).tolist()
    evaluation = evaluate(estimate, truth, align="none")
    n = len(difference)
    assert evaluation.armse == pytest.approx(
        sum(((x * x + y * y) / 2) ** 0.5 for x, y, _ in difference) / n
    )
    assert evaluation.euclidean_mean == pytest.approx(
        sum((x * x + y * y) ** 0.5 for x, y, _ in difference) / n
    )
    assert evaluation.height_rms == pytest.approx((sum(z * z for _, _, z in difference) / n) ** 0.5)
    assert evaluation.rmse_3d == pytest.approx(
        (sum(x * x + y * y + z * z for x, y, z in difference) / n) ** 0.5
    )
    assert evaluation.max == pytest.approx(
        max((x * x + y * y + z * z) ** 0.5 for x, y, z in difference)
    )


@given(
    yaw=st.floats(-np.pi, np.pi),
    shift=st.tuples(*[st.floats(-1e3, 1e3)] * 3),
    align=st.sampled_from(["yaw", "umeyama-yaw"]),
)
@settings(max_examples=40, deadline=None)
def test_turning_and_shifting_change_nothing(
    yaw: float, shift: tuple[float, float, float], align: str
) -> None:
    """Neither of the estimate nor of the truth."""
    estimate, truth = drifting(walk(10, 50)), walk(10, 50).position
    expected = numbers(evaluate(estimate, truth, align=align))
    turned = dataclasses.replace(estimate, position=moved(estimate.position, yaw, shift))
    assert numbers(evaluate(turned, truth, align=align)) == pytest.approx(expected, abs=1e-8)
    assert numbers(evaluate(estimate, moved(truth, yaw, shift), align=align)) == pytest.approx(
        expected, abs=1e-8
    )


def test_least_squares_are_least() -> None:
    """A general minimiser finds the same sum of squares, and yaw alone cannot do better."""
    estimate, truth = drifting(walk(10, 50)), moved(walk(10, 50).position, 2.0, [5.0, -3.0, 1.0])

    def cost(unknowns: Any) -> float:
        return float(np.sum((moved(estimate.position, unknowns[0], unknowns[1:]) - truth) ** 2))

    best = minimize(cost, [1.5, 0, 0, 0], options={"gtol": 1e-8})
    evaluation = evaluate(estimate, truth, align="umeyama-yaw")
    assert evaluation.rmse_3d == pytest.approx(np.sqrt(best.fun / len(truth)), rel=1e-9)
    assert evaluation.rmse_3d < evaluate(estimate, truth, align="yaw").rmse_3d


def test_yaw_is_taken_at_the_first_sample_beyond_the_distance() -> None:
    """The estimate goes east, turns off at 0.8 m; the truth goes north.

    From there on the two part.
    """
    along = np.column_stack([np.linspace(0, 0.8, 9), np.zeros(9), np.zeros(9)])
    off = along[-1] + np.column_stack([np.zeros(8), np.linspace(0.1, 0.8, 8), np.zeros(8)])
    estimate = np.vstack([along, off])
    truth = np.column_stack([np.zeros(17), np.linspace(0, 1.6, 17), np.zeros(17)])
    alignment = find_alignment(estimate, truth, "yaw")
    assert alignment.yaw == pytest.approx(np.pi / 2)
    np.testing.assert_allclose(alignment.apply(estimate)[:9], truth[:9], atol=1e-12)
    assert alignment.apply(estimate)[-1] == pytest.approx([-0.8, 0.8, 0])


@pytest.mark.parametrize("align", ["yaw", "umeyama-yaw", "start", "none"])
def test_alignment_can_be_undone(align: str) -> None:
    """To the truth and back."""
    estimate, truth = drifting(walk(10, 50)).position, walk(10, 50).position
    alignment = find_alignment(estimate, truth, align)
    np.testing.assert_allclose(alignment.undo(alignment.apply(estimate)), estimate, atol=1e-12)


def test_walk_on_the_spot_is_aligned_with_a_warning() -> None:
    """There is no sample 0.8 m away; the farthest one is used, with a warning."""
    traj = walk(10, 50)
    small = dataclasses.replace(traj, position=traj.position * 0.05)
    with pytest.warns(FootnavWarning, match=r"stays within 0\.\d\d m .*umeyama-yaw"):
        evaluation = evaluate(small, moved(small.position, 1.0, [1.0, 2.0, 3.0]))
    assert evaluation.max == pytest.approx(0, abs=1e-12)


def test_truth_with_its_own_stamps_is_interpolated() -> None:
    """Linear motion, sampled elsewhere, is met exactly; a Trajectory and a tuple are the same."""
    traj = walk(10, 50)
    position = np.outer(traj.t, [1.0, 2.0, 0.5])
    estimate = dataclasses.replace(traj, position=position)
    t = np.sort(np.concatenate([[-1.0, 1e3], np.random.default_rng(0).uniform(0, traj.t[-1], 300)]))
    truth = np.outer(t, [1.0, 2.0, 0.5])
    assert evaluate(estimate, (t, truth), align="none").max == pytest.approx(0, abs=1e-9)
    fine = walk(10, 200)
    assert numbers(evaluate(traj, fine)) == numbers(evaluate(traj, (fine.t, fine.position)))


def test_truth_is_never_extrapolated() -> None:
    """A truth that starts late or ends early is refused, but for the rounding of its stamps."""
    traj = walk(10, 50)
    t, position = traj.t, traj.position
    for part in (slice(1, None), slice(None, -1)):
        with pytest.raises(DataError, match=r"truth covers .* cut the track"):
            evaluate(traj, (t[part], position[part]))
    assert evaluate(traj, (np.round(t, 6) + 4e-7, position)).max == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize(
    ("truth", "message"),
    [
        (np.zeros((5, 3)), r"truth has shape \(5, 3\), expected \(701, 3\)"),
        (np.zeros((701, 2)), "one row for each sample"),
        ("truth.csv", "truth is not an array"),
        ((np.arange(3), np.zeros((3, 3)), 1), "tuple of 3"),
        ((np.arange(3), np.zeros((4, 3))), r"shapes \(3,\) and \(4, 3\)"),
        ((np.array([0.0, 9.0, 8.0]), np.zeros((3, 3))), "row 2: t goes back"),
        ((np.zeros(0), np.zeros((0, 3))), "truth is empty"),
        ((np.array([0.0, np.nan, 20.0]), np.zeros((3, 3))), "truth t, row 1"),
        (
            np.where(np.arange(701)[:, None] == 7, np.nan, np.zeros(3)),
            r"truth, row 7: .*\(1 such rows\)",
        ),
    ],
)
def test_truth_that_does_not_fit_is_refused(truth: Any, message: str) -> None:
    """The message names the error."""
    traj = walk(10, 50)
    assert len(traj) == 801
    with pytest.raises(DataError, match=message):
        evaluate(traj[:701], truth)


def test_estimate_that_cannot_be_evaluated_is_refused() -> None:
    """Too short, or not finite."""
    traj = walk(10, 50)
    with pytest.raises(DataError, match="the track has 1 samples"):
        evaluate(traj[:1], traj)
    position = traj.position.copy()
    position[3] = np.inf
    with pytest.raises(DataError, match="track, row 3"):
        evaluate(dataclasses.replace(traj, position=position), traj)
    with pytest.raises(ConfigError, match="align is 'sim3'"):
        evaluate(traj, traj, align="sim3")


def test_path_length_of_a_square() -> None:
    """Ten metres a side at 1 m/s, with a swing of the foot that is shorter than the sampling."""
    t = np.arange(4001) / 100
    side = np.clip(t[:, None] - [0, 10, 20, 30], 0, 10)
    position = np.column_stack([side[:, 0] - side[:, 2], side[:, 1] - side[:, 3], np.sin(t)])
    assert path_length(t, position) == pytest.approx(40)
    assert path_length(t, position + 0.02 * np.sin(2 * np.pi * t * 4)[:, None]) == pytest.approx(
        40, rel=1e-3
    )


def test_text_of_an_evaluation() -> None:
    """Metres, percent, and the alignment are named."""
    traj = walk()
    text = str(evaluate(traj, traj.position - [3.0, 4.0, 12.0], align="none"))
    assert "aligned by 'none'" in text
    assert "5.000 m (" in text
    assert "+12.000 m vertical" in text


def test_standing_still_has_no_percentage() -> None:
    """There is no distance to relate the error to."""
    traj = dataclasses.replace(walk(2), position=np.zeros((len(walk(2)), 3)))
    evaluation = evaluate(traj, traj, align="umeyama-yaw")
    assert evaluation.distance == 0
    assert np.isnan(evaluation.percent_of_distance)
    assert evaluation.closing_error == Displacement(0, 0)


def test_real_truth_seen_from_another_frame_is_met(data_dir: Path) -> None:
    """Motion-capture walks, turned, shifted and scaled by 1 %, err by the scale alone."""
    for file in sorted((data_dir / "vicon").glob("*.npz"))[:5]:
        with np.load(file) as recording:
            t, truth = recording["t"], recording["position"]
        n = len(t)
        zeros = np.zeros((n, 3))
        estimate = truth[0] + 1.01 * (truth - truth[0])
        position = moved(estimate, 2.5, [7.0, 8.0, 9.0])
        level = np.tile([0.0, 0.0, 0.0, 1.0], (n, 1))
        traj = Trajectory(
            t,
            position,
            zeros,
            level,
            np.zeros(n, bool),
            zeros,
            zeros,
            zeros,
            np.zeros(n, np.uint16),
        )
        away = np.hypot(*(truth - truth[0])[:, :2].T)
        assert evaluate(traj, truth).euclidean_mean == pytest.approx(0.01 * away.mean(), rel=1e-9)
