"""Stances that a user decides on: decisions given as an array, and a detector of one's own."""

import warnings

import numpy as np
import pytest

import footnav
from foot_swings import assert_same, swings
from footnav import Config, Navigator, Recording, Trajectory, detect, track
from footnav.errors import ConfigError, DataError

RATE = 100.0


def walk():
    """Return rest, four swings of a foot, and rest, with white noise."""
    t = np.arange(700) / RATE
    accel, gyro = swings(t)
    return Recording(t, accel, gyro, name="walk")


class Energy:
    """The rule of `footnav.detectors.AngularRateEnergy`, by the book."""

    def __init__(self, window, threshold):
        self.window, self.threshold, self.energies = window, threshold, []

    @property
    def latency(self):
        return self.window // 2

    def push(self, t, accel, gyro):
        self.energies.append(sum(rate**2 for rate in gyro))
        if len(self.energies) <= self.latency:
            return None
        if len(self.energies) < self.window:
            return False
        return bool(np.mean(self.energies[-self.window :]) <= self.threshold)

    def reset(self):
        self.energies = []


class Scripted:
    """Gives scripted decisions for any samples."""

    def __init__(self, answers, latency=0):
        self.answers, self.latency, self.pushed = answers, latency, 0

    def push(self, t, accel, gyro):
        self.pushed += 1
        answer = self.answers(self.pushed - 1)
        if isinstance(answer, BaseException):
            raise answer
        return answer

    def reset(self):
        self.pushed = 0


BUILT_IN = footnav.detectors.AngularRateEnergy(window=0.07, threshold=0.3)
TWIN = {"window": 7, "threshold": 0.3}


@pytest.fixture(scope="module")
def expected():
    """Track by the detector of the core."""
    return track(walk(), Config(detector=BUILT_IN))


def test_given_decisions_are_followed_like_those_of_a_detector(expected):
    rec = walk()
    decision = detect(rec, BUILT_IN).decision
    assert 0 < decision.sum() < len(rec)
    assert_same(track(rec, detector=decision), expected)
    assert_same(track(rec, detector=decision.tolist()), expected)


def test_other_decisions_make_another_track(expected):
    rec = walk()
    with pytest.warns(footnav.FootnavWarning, match="not seen at rest"):
        nowhere = track(rec, detector=np.arange(len(rec)) < 150)
    assert not nowhere.zero_velocity[150:].any()
    assert np.linalg.norm(nowhere.position[-1] - expected.position[-1]) > 0.1


@pytest.mark.parametrize("n", [0, 699, 701])
def test_a_wrong_number_of_decisions_names_both_lengths(n):
    with pytest.raises(DataError, match=rf"walk: detector has shape \({n},\); expected \(700,\)"):
        track(walk(), detector=np.ones(n, bool))


@pytest.mark.parametrize("decisions", [np.ones(700), np.ones(700, int), ["yes"] * 700])
def test_decisions_must_be_bools(decisions):
    with pytest.raises(DataError, match=r"walk: detector is an array of .*; expected bool"):
        track(walk(), detector=decisions)


def test_a_detector_of_ones_own_equals_the_built_in_one(expected):
    rec = walk()
    assert_same(track(rec, detector=Energy(**TWIN)), expected)
    result = detect(rec, Energy(**TWIN))
    np.testing.assert_array_equal(result.decision, detect(rec, BUILT_IN).decision)
    assert np.isnan(result.statistic).all()
    assert np.isnan(result.threshold).all()


def test_it_equals_it_in_a_navigator_too(expected):
    rec = walk()
    navigator = Navigator(rate_hz=RATE, detector=Energy(**TWIN))
    assert navigator.latency == 3
    parts = []
    for row in np.column_stack([rec.t, rec.accel, rec.gyro])[:400].tolist():
        if navigator.push(*row):
            parts.append(navigator.zero_velocity)
    np.testing.assert_array_equal(parts, expected.zero_velocity[:397])
    rest = navigator.push_block(rec.t[400:], rec.accel[400:], rec.gyro[400:])
    np.testing.assert_array_equal(
        Trajectory.concatenate([rest, navigator.flush()]).position, expected.position[397:]
    )


def test_the_same_object_gives_the_same_track_again(expected):
    rec, detector = walk(), Energy(**TWIN)
    for _ in range(2):
        assert_same(track(rec, detector=detector), expected)
    navigator = Navigator(rate_hz=RATE, detector=detector)
    navigator.push_block(rec.t[:300], rec.accel[:300], rec.gyro[:300])
    navigator.reset()
    states = [navigator.push_block(rec.t, rec.accel, rec.gyro), navigator.flush()]
    assert_same(Trajectory.concatenate(states), expected)


def test_it_is_given_calibrated_samples():
    rec, seen = walk(), []

    class Listener(Scripted):
        def push(self, t, accel, gyro):
            seen.append((t, *accel, *gyro))
            return False

    config = Config(
        calibration=footnav.config.Calibration(
            accel_bias=(0.1, 0.2, 0.3), gyro_bias=(0.01, 0.02, 0.03)
        )
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", footnav.FootnavWarning)
        track(rec, config, detector=Listener(None))
    corrected = np.column_stack([rec.t, rec.accel - [0.1, 0.2, 0.3], rec.gyro - [0.01, 0.02, 0.03]])
    np.testing.assert_allclose(seen, corrected, rtol=1e-12)


@pytest.mark.parametrize(
    "error", [ZeroDivisionError("mine"), KeyboardInterrupt("stop"), footnav.FootnavError("ours")]
)
def test_its_exception_propagates_unchanged(error):
    failing = Scripted(lambda k: error if k == 333 else False)
    with pytest.raises(type(error), match=str(error)):
        track(walk(), detector=failing)
    assert failing.pushed == 334
    with pytest.raises(type(error), match=str(error)):
        detect(walk(), failing)


def test_the_first_exception_stays_until_a_reset():
    rec = walk()
    failing = Scripted(lambda k: ValueError(f"at {k}") if k >= 40 else False)
    navigator = Navigator(rate_hz=RATE, detector=failing)
    calls = [
        lambda: navigator.push_block(rec.t[:100], rec.accel[:100], rec.gyro[:100]),
        lambda: navigator.push_block(rec.t[100:], rec.accel[100:], rec.gyro[100:]),
        lambda: navigator.push(100.0, 0.0, 0.0, 9.8, 0.0, 0.0, 0.0),
        navigator.flush,
    ]
    for call in calls:
        with pytest.raises(ValueError, match=r"^at 40$"):
            call()
    navigator.reset()
    assert navigator.push(0.0, 0.0, 0.0, 9.8, 0.0, 0.0, 0.0)


def test_an_exception_in_push_propagates_from_push():
    navigator = Navigator(rate_hz=RATE, detector=Scripted(lambda k: ValueError("at once")))
    with pytest.raises(ValueError, match="at once"):
        navigator.push(0.0, 0.0, 0.0, 9.8, 0.0, 0.0, 0.0)


def test_an_exception_in_reset_propagates():
    class Stubborn(Scripted):
        def reset(self):
            raise RuntimeError("no")

    with pytest.raises(RuntimeError, match="no"):
        Navigator(rate_hz=RATE, detector=Stubborn(lambda k: False))


@pytest.mark.parametrize(
    ("answers", "latency", "message"),
    [
        (
            lambda k: None,
            0,
            "sample 0: .* returned None; expected a bool, since its latency is 0 samples",
        ),
        (lambda k: False if k < 5 else 1.0, 0, r"sample 5: .* returned 1\.0; expected a bool"),
        (
            lambda k: False,
            2,
            "sample 0: .* returned False; expected None, since its latency is 2 samples",
        ),
        (
            lambda k: None,
            2,
            "sample 2: .* returned None; expected a bool, since its latency is 2 samples",
        ),
    ],
)
def test_a_decision_at_the_wrong_time_is_refused(answers, latency, message):
    with pytest.raises(ConfigError, match=message):
        detect(walk(), Scripted(answers, latency))
    with pytest.raises(ConfigError, match="walk: " + message):
        track(walk(), detector=Scripted(answers, latency))


def test_a_numpy_bool_is_a_bool():
    assert detect(walk(), Scripted(lambda k: np.bool_(True))).decision.all()


@pytest.mark.parametrize("latency", [-1, 2.5, None, 10**9])
def test_a_latency_that_is_impossible_is_refused(latency):
    with pytest.raises(ConfigError, match=f"latency is {latency}; expected a whole number"):
        Navigator(rate_hz=RATE, detector=Scripted(lambda k: None, latency))


@pytest.mark.parametrize("detector", [3, lambda *_: True, footnav.detectors.Shoe(), "shoe"])
def test_objects_without_the_members_of_a_detector_are_refused(detector):
    with pytest.raises(ConfigError, match="has no latency; expected latency, push and reset"):
        track(walk(), detector=detector)


def test_the_end_counts_as_moving():
    late = Scripted(lambda k: None if k < 10 else True, latency=10)
    decision = detect(walk(), late).decision
    assert decision[:-10].all()
    assert not decision[-10:].any()
