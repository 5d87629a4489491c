"""Bad input through the public interface.

An error of footnav or a finite result, no panic, no nan in silence.
"""

import contextlib
import subprocess
import sys
import warnings

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import footnav
from footnav import Config, Navigator, Recording, track
from footnav.config import Alignment
from footnav.detectors import AdaptiveShoe, MagnitudeVariance, Shoe
from footnav.errors import DataError, FootnavError, FootnavWarning, NumericalError

RATE = 100.0
COLUMNS = ("t", "position", "velocity", "quaternion", "position_std", "gyro_bias", "accel_bias")
QUICK = Alignment(duration=0.2)
CONFIGS = (
    Config(alignment=QUICK),
    Config(alignment=QUICK, detector=Shoe()),
    Config(alignment=QUICK, detector=MagnitudeVariance()),
)

extremes = st.sampled_from(
    [
        0.0,
        -0.0,
        5e-324,
        -1e-310,
        1e-30,
        1e18,
        -1e18,
        1e150,
        -1e160,
        1e300,
        -1e308,
        sys.float_info.max,
    ]
)
values = extremes | st.floats(allow_nan=False, allow_infinity=False) | st.floats(-50, 50)
rows = st.tuples(*[values] * 6)
configs = st.sampled_from(CONFIGS)


def rest(n, start=0.0):
    """Return stamps, specific force and angular rate of a level sensor with a little noise."""
    noise = 0.01 * np.random.default_rng(n).normal(size=(2, n, 3))
    return start + np.arange(n) / RATE, noise[0] + [0.0, 0.0, 9.81], 0.1 * noise[1]


def with_rows(bad, at=60, n=160):
    """Return a recording at rest with these six values in the place of some samples."""
    t, accel, gyro = rest(n)
    bad = np.array(bad, dtype=float).reshape(-1, 6)
    accel[at : at + len(bad)], gyro[at : at + len(bad)] = bad[:, :3], bad[:, 3:]
    return t, accel, gyro


def assert_finite(states):
    """Check that every number of every row is finite and every quaternion a rotation."""
    for column in COLUMNS:
        assert np.isfinite(getattr(states, column)).all(), column
    np.testing.assert_allclose(np.linalg.norm(states.quaternion, axis=1), 1.0, atol=1e-6)


def assert_valid(navigator):
    """Check that the outputs are finite or absent, and that `now` is finite or raises."""
    for name in ("position", "velocity", "quaternion", "gyro_bias", "accel_bias", "covariance"):
        value = getattr(navigator, name)
        assert value is None or np.isfinite(value).all(), name
    try:
        now = navigator.now()
    except NumericalError:
        return
    assert now is None or all(
        np.isfinite(part).all() for part in (now.position, now.velocity, now.quaternion)
    ), "now"


def assert_finite_or_refused(navigator, samples):
    """Push a block and end the data.

    A filter that failed raises in every call until reset.
    """
    try:
        assert_finite(navigator.push_block(*samples))
        assert_valid(navigator)
        assert_finite(navigator.flush())
        assert_valid(navigator)
    except DataError:
        assert_valid(navigator)
    except NumericalError:
        with pytest.raises(FootnavError):
            navigator.push_block(*samples)
        navigator.reset()
        assert_finite(navigator.push_block(*rest(160)))


@pytest.mark.slow
@given(st.lists(rows, min_size=1, max_size=40), configs)
@example([(1e300, 0.0, 0.0, 0.0, 0.0, 0.0)], CONFIGS[0])
@example([(0.0, 0.0, 0.0, 1e300, 0.0, 0.0)], CONFIGS[1])
@example([(0.0,) * 6] * 40, CONFIGS[1])
@example([(1e18,) * 6] * 40, CONFIGS[2])
@settings(max_examples=80, deadline=None)
def test_a_block_of_extreme_samples(bad, config):
    navigator = Navigator(config, RATE)
    assert_finite_or_refused(navigator, with_rows(bad))


@given(st.lists(rows, min_size=1, max_size=40), configs, st.integers(0, 60))
@settings(max_examples=30, deadline=None)
def test_extreme_samples_one_by_one_and_reset_heals(bad, config, at):
    navigator = Navigator(config, RATE)
    for k, row in enumerate(np.column_stack(with_rows(bad, at)).tolist()):
        try:
            navigator.push(*row)
        except DataError:
            continue
        except NumericalError:
            break
        if k % 10 == 0:
            assert_valid(navigator)
    navigator.reset()
    assert_finite(navigator.push_block(*rest(160)))
    assert_valid(navigator)


@pytest.mark.slow
@given(st.lists(rows, min_size=1, max_size=40), configs)
@settings(max_examples=60, deadline=None)
def test_a_recording_of_extreme_samples(bad, config):
    try:
        recording = Recording(*with_rows(bad))
    except DataError:
        return
    with warnings.catch_warnings(), contextlib.suppress(FootnavError):
        warnings.simplefilter("ignore", FootnavWarning)
        assert_finite(track(recording, config))


steps = st.floats(0.0, 1e300) | st.sampled_from([0.0, 5e-324, 1e-12, 0.5, 1e3, 1e9, 1e18, 1e300])


@pytest.mark.slow
@given(
    st.lists(steps, min_size=1, max_size=20),
    st.sampled_from([0.0, -1e9, 1.7e9, -1e300, 1e300]),
    configs,
)
@settings(max_examples=80, deadline=None)
def test_extreme_stamps(intervals, start, config):
    _, accel, gyro = rest(60 + len(intervals))
    t = np.concatenate([start + np.arange(60) / RATE, start + 0.6 + np.cumsum(intervals)])
    t = np.clip(np.maximum.accumulate(t), -sys.float_info.max, sys.float_info.max)
    navigator = Navigator(config, RATE)
    assert_finite_or_refused(navigator, (t, accel, gyro))


@given(rows, configs)
@settings(max_examples=40, deadline=None)
def test_extreme_samples_from_the_start(row, config):
    t, accel, gyro = rest(100)
    accel[:], gyro[:] = row[:3], row[3:]
    navigator = Navigator(config, RATE)
    assert_finite_or_refused(navigator, (t, accel, gyro))


@pytest.mark.parametrize("value", [0.0, 1e-300, 1e300])
def test_a_constant_that_is_no_specific_force_is_an_error_or_degraded(value):
    """The direction of up is unobservable: the attitude must not have status OK."""
    t, accel, gyro = rest(200)
    accel[:] = value
    navigator = Navigator(Config(), RATE)
    try:
        navigator.push_block(t, accel, gyro)
        navigator.flush()
    except FootnavError:
        return
    assert navigator.health.status is not footnav.health.Status.OK


@pytest.mark.parametrize("position", [1, 2])
def test_masked_samples_are_not_taken_for_samples(position):
    """Masked values are invalid, whatever the array holds below the mask."""
    samples = list(rest(200))
    hidden = np.zeros(samples[position].shape, bool)
    hidden[150] = True
    samples[position] = np.ma.masked_array(samples[position], hidden)
    samples[position].data[150] = 1000.0
    with pytest.raises(DataError):
        Navigator(rate_hz=RATE).push_block(*samples)


@pytest.mark.parametrize(
    "convert",
    [
        lambda a: a + 1j,
        lambda a: a.astype(str),
        lambda a: a.astype("datetime64[s]"),
        lambda a: a.astype(object) * None,
    ],
    ids=["complex", "text", "dates", "objects"],
)
def test_values_other_than_real_numbers_are_data_errors(convert):
    t, accel, gyro = rest(50)
    try:
        accel = convert(accel)
    except TypeError:
        accel = np.full(accel.shape, None)
    with pytest.raises(DataError):
        Navigator(rate_hz=RATE).push_block(t, accel, gyro)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        (
            {"accel": np.zeros((3, 50))},
            "50 stamps need accel and gyro of shape (50, 3); got [3, 50] and [50, 3]",
        ),
        (
            {"gyro": np.zeros((49, 3))},
            "50 stamps need accel and gyro of shape (50, 3); got [50, 3] and [49, 3]",
        ),
        ({"t": np.zeros((50, 1))}, "t has shape (50, 1); expected (n,)"),
        ({"accel": np.zeros(150)}, "accel has shape (150,); expected (n, 3)"),
        ({"gyro": np.zeros((50, 3, 1))}, "gyro has shape (50, 3, 1); expected (n, 3)"),
        (
            {"accel": [[1.0, 2.0, 3.0], [1.0]]},
            "accel is ragged: every row needs the same number of values",
        ),
        ({"t": ["0.0"] * 50}, "t holds <U3 values; expected real numbers"),
        ({"gyro": np.zeros((50, 3), bool)}, "gyro holds bool values; expected real numbers"),
    ],
)
def test_a_block_of_the_wrong_shape_or_kind_is_rejected_by_name(changed, message):
    block = dict(zip(("t", "accel", "gyro"), rest(50), strict=True))
    navigator = Navigator(rate_hz=RATE)
    with pytest.raises(DataError) as error:
        navigator.push_block(**(block | changed))
    assert str(error.value) == message
    assert navigator.health.counters.samples == 0


@pytest.mark.parametrize("kind", [np.int8, np.int64, np.uint16, np.float16])
def test_numbers_of_any_kind_are_numbers(kind):
    t, accel, gyro = np.arange(200) / RATE, np.tile([0, 0, 10], (200, 1)), np.zeros((200, 3))
    of_floats, of_kind = Navigator(rate_hz=RATE), Navigator(rate_hz=RATE)
    expected = of_floats.push_block(t, accel.astype(float), gyro)
    states = of_kind.push_block(t, accel.astype(kind), gyro.astype(kind))
    for column in COLUMNS:
        np.testing.assert_array_equal(getattr(states, column), getattr(expected, column))


@pytest.mark.parametrize("argument", ["1.0", None, [1.0], 1j])
def test_a_sample_that_is_no_number_is_a_type_error_and_changes_nothing(argument):
    navigator = Navigator(rate_hz=RATE)
    with pytest.raises(TypeError):
        navigator.push(0.0, argument, 0.0, 9.8, 0.0, 0.0, 0.0)
    assert navigator.health.counters.samples == 0


def test_the_process_outlives_everything():
    """A panic that aborts cannot be caught here, so another interpreter runs into it."""
    script = """
import numpy as np, footnav
for value in (0.0, 5e-324, 1e18, 1e154, 1e300, 1.7976931348623157e308, float("inf"), float("nan")):
    for detector in (footnav.detectors.AdaptiveShoe(), footnav.detectors.Shoe(),
    footnav.detectors.MagnitudeVariance()):
        for n in (0, 1, 2, 150, 400):
            navigator = footnav.Navigator(footnav.Config(detector=detector), 100.0)
            accel = np.tile([0.0, 0.0, 9.81], (n, 1))
            accel[n // 2 :] = value
            try:
                navigator.push_block(np.arange(n) / 100, accel, accel)
                navigator.now()
                navigator.flush()
            except footnav.FootnavError:
                pass
            navigator.health, navigator.covariance, navigator.reset()
print("alive")
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout) == (0, "alive\n"), done.stderr


@pytest.mark.parametrize("rate_hz", [20.0, 20_000.0])
@pytest.mark.parametrize(
    "detector", [AdaptiveShoe(window=10.0), AdaptiveShoe(look_ahead=0.0, look_behind=0.0), Shoe()]
)
def test_the_ends_of_the_rates_and_windows(rate_hz, detector):
    navigator = Navigator(Config(detector=detector), rate_hz)
    n = int(2 * rate_hz)
    states = navigator.push_block(
        np.arange(n) / rate_hz, np.tile([0.0, 0.0, 9.806], (n, 1)), np.zeros((n, 3))
    )
    assert len(states) + len(navigator.flush()) == n
    assert_valid(navigator)
