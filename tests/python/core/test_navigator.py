"""Streaming: the numbers of the batch in any chunking, with a fixed latency."""

import dataclasses
import io
import itertools
import os
import pickle
import subprocess
import sys
import threading

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from foot_swings import COLUMNS, assert_same, swings
from footnav import Config, Navigator, Recording, Trajectory, track
from footnav.config import Alignment, Filter, Mechanization
from footnav.detectors import AdaptiveShoe, MagnitudeVariance, Shoe
from footnav.errors import BusyError, ConfigError, DataError
from footnav.health import Flag, Status

RATE = 100.0
CONFIGS = {
    "default": Config(),
    "fixed": Config(detector=Shoe(), mechanization=Mechanization(kind="single-sample")),
    "variance": Config(
        detector=MagnitudeVariance(), mechanization=Mechanization(kind="first-order")
    ),
}


def walk():
    """Return stamps, force and rate of rest, four swings of a foot, and rest, with white noise.

    Exact in single precision, so that the same walk can be given as float32.
    """
    t = np.arange(750) / 128 * 1.28
    accel, gyro = swings(t)
    return tuple(column.astype(np.float32).astype(np.float64) for column in (t, accel, gyro))


def rough_walk():
    """Return the walk with three samples missing twice and some stamps repeated."""
    t, accel, gyro = walk()
    t[[250, 251, 420]] = t[[249, 249, 419]]
    keep = np.ones(len(t), bool)
    keep[300:303] = keep[500:503] = False
    return t[keep], accel[keep], gyro[keep]


def rest(n=300):
    """Return stamps, specific force and angular rate of a level sensor without noise."""
    return np.arange(n) / RATE, np.tile([0.0, 0.0, Config().gravity], (n, 1)), np.zeros((n, 3))


def in_blocks(navigator, samples, cuts):
    """Push the samples in blocks that end at `cuts`, flush, and return all states."""
    edges = [0, *sorted(cuts), len(samples[0])]
    blocks = itertools.starmap(slice, itertools.pairwise(edges))
    parts = [navigator.push_block(*(column[block] for column in samples)) for block in blocks]
    return Trajectory.concatenate([*parts, navigator.flush()])


def push_all(navigator, samples):
    """Push sample by sample; return the result of each push and the newest state after it."""
    rows = np.column_stack(samples).tolist()
    return [
        (navigator.push(*row), navigator.t, navigator.position, navigator.quaternion)
        for row in rows
    ]


@pytest.fixture(scope="module")
def batch():
    """Tracks of the rough walk by all configurations."""
    samples = rough_walk()
    with pytest.warns(UserWarning, match="repeat"):
        return {name: track(Recording(*samples), config) for name, config in CONFIGS.items()}


@pytest.mark.slow
@given(st.lists(st.integers(0, 744), max_size=12), st.sampled_from(sorted(CONFIGS)))
@example([], "default")
@example([0, 0, 744, 744], "default")
@example([1, 2, 3, 249, 250, 251, 252], "default")
@example(list(range(1, 744)), "default")
@settings(max_examples=40, deadline=None)
def test_any_chunking_gives_the_batch_to_the_bit(batch, cuts, name):
    samples = rough_walk()
    navigator = Navigator(CONFIGS[name], Recording(*samples).rate_hz)
    states = in_blocks(navigator, samples, cuts)
    assert_same(states, batch[name])
    assert states.health.counters == batch[name].health.counters
    assert navigator.health == states.health


@pytest.mark.parametrize("name", CONFIGS)
def test_state_k_is_output_with_push_k_plus_latency(batch, name):
    samples = rough_walk()
    navigator = Navigator(CONFIGS[name], Recording(*samples).rate_hz)
    expected = batch[name]
    for k, (came_out, t, position, quaternion) in enumerate(push_all(navigator, samples)):
        row = k - navigator.latency
        assert came_out == (row >= 0)
        if came_out:
            assert t == expected.t[row]
            np.testing.assert_array_equal(position, expected.position[row])
            np.testing.assert_array_equal(quaternion, expected.quaternion[row])
    assert_same(navigator.flush(), expected[len(expected) - navigator.latency :])
    assert navigator.t == expected.t[-1]
    np.testing.assert_array_equal(navigator.position, expected.position[-1])


@pytest.mark.parametrize("n", [1, 2, 99, 100, 101, 300])
@pytest.mark.parametrize("name", CONFIGS)
def test_as_many_rows_as_samples_after_flush(n, name):
    navigator = Navigator(CONFIGS[name], RATE)
    states = in_blocks(navigator, tuple(column[:n] for column in walk()), [])
    np.testing.assert_array_equal(states.t, walk()[0][:n])
    assert navigator.health.counters.samples == n


def test_no_samples_give_no_states():
    navigator = Navigator(rate_hz=RATE)
    assert len(navigator.push_block(np.empty(0), np.empty((0, 3)), np.empty((0, 3)))) == 0
    assert len(navigator.flush()) == 0


@pytest.mark.parametrize("seconds", [0.1, 0.25, 0.6])
def test_latency_is_the_look_ahead_and_half_a_window(seconds):
    detector = AdaptiveShoe(window=0.07, look_ahead=seconds)
    assert Navigator(Config(detector=detector), RATE).latency == round(seconds * RATE) + 3


def test_there_is_no_state_before_the_first_output():
    navigator = Navigator(rate_hz=RATE)
    attributes = (
        "t",
        "position",
        "velocity",
        "quaternion",
        "zero_velocity",
        "gyro_bias",
        "accel_bias",
        "covariance",
    )
    assert navigator.now() is None
    for row in np.column_stack(walk())[: navigator.latency].tolist():
        assert not navigator.push(*row)
        assert [getattr(navigator, name) for name in attributes] == [None] * len(attributes)
    assert navigator.push(*np.column_stack(walk())[navigator.latency].tolist())
    assert [name for name in attributes if getattr(navigator, name) is None] == ["covariance"]
    assert navigator.health.status is Status.INVALID


def test_states_stay_at_the_origin_while_the_start_is_aligned():
    states = in_blocks(Navigator(rate_hz=RATE), walk(), [])
    aligning = states.flags & Flag.ALIGNING > 0
    assert np.array_equal(aligning, states.t - states.t[0] < Config().alignment.duration + 1e-9)
    assert not states.position[aligning].any()
    assert not states.velocity[aligning].any()


def test_attributes_are_the_row_that_is_output():
    samples = walk()
    navigator = Navigator(rate_hz=RATE)
    states = navigator.push_block(*(column[:500] for column in samples))
    for name in (
        "t",
        "position",
        "velocity",
        "quaternion",
        "zero_velocity",
        "gyro_bias",
        "accel_bias",
    ):
        np.testing.assert_array_equal(
            getattr(navigator, name), getattr(states, name)[-1], err_msg=name
        )


@pytest.mark.parametrize(("interval", "tolerance"), [(0.0, 1e-12), (0.02, 1e-3)])
def test_position_errors_agree_with_the_covariance(interval, tolerance):
    navigator = Navigator(Config(filter=Filter(covariance_interval=interval)), rate_hz=RATE)
    t, accel, gyro = walk()
    compared = 0
    for start in range(0, len(t), 7):
        block = slice(start, start + 7)
        states = navigator.push_block(t[block], accel[block], gyro[block])
        if navigator.covariance is not None:
            std = np.sqrt(np.diag(navigator.covariance)[:3])
            np.testing.assert_allclose(std, states.position_std[-1], rtol=tolerance)
            health, (x, y, z) = navigator.health, states.position_std[-1]
            assert (health.horizontal_std, health.vertical_std) == (
                pytest.approx(np.hypot(x, y)),
                z,
            )
            compared += 1
    assert compared > 50


def test_attributes_given_out_earlier_do_not_change():
    navigator = Navigator(rate_hz=RATE)
    navigator.push_block(*(column[:500] for column in walk()))
    position, covariance = navigator.position, navigator.covariance
    before = position.copy(), covariance.copy()
    navigator.push_block(*(column[500:] for column in walk()))
    assert not np.array_equal(navigator.position, before[0])
    np.testing.assert_array_equal(position, before[0])
    np.testing.assert_array_equal(covariance, before[1])


def test_covariance_is_symmetric_and_positive_along_a_walk():
    navigator = Navigator(rate_hz=RATE)
    seen = 0
    for row in np.column_stack(rough_walk()).tolist():
        navigator.push(*row)
        covariance = navigator.covariance
        if covariance is not None:
            seen += 1
            std = np.sqrt(np.diag(covariance))
            np.testing.assert_array_equal(covariance, covariance.T)
            assert np.linalg.eigvalsh(covariance / np.outer(std, std)).min() > 0
    assert seen > 400


def test_now_at_rest_is_the_state_at_the_newest_stamp():
    t, accel, gyro = rest()
    navigator = Navigator(rate_hz=RATE)
    for k in range(len(t)):
        navigator.push(t[k], *accel[k], *gyro[k])
        now = navigator.now()
        assert now.t == t[k]
        np.testing.assert_allclose(now.position, 0, atol=1e-9)
        np.testing.assert_allclose(now.velocity, 0, atol=1e-9)
        np.testing.assert_allclose(now.quaternion, [0, 0, 0, 1], atol=1e-9)
    assert now.t - navigator.t == pytest.approx(navigator.latency / RATE)


def test_now_is_the_newest_state_extrapolated_by_the_strapdown():
    t, accel, gyro = rest(400)
    accel[350:, 0] = 0.8
    navigator = Navigator(rate_hz=RATE)
    navigator.push_block(t, accel, gyro)
    assert navigator.t < t[350]
    moving = t[-1] - t[350]
    np.testing.assert_allclose(navigator.now().velocity[0], 0.8 * moving, atol=0.8 * 2 / RATE)
    np.testing.assert_allclose(
        navigator.now().position[0], 0.4 * moving**2, atol=0.8 * moving * 2 / RATE
    )


def test_now_changes_nothing(batch):
    samples = rough_walk()
    navigator = Navigator(rate_hz=Recording(*samples).rate_hz)
    parts = []
    for start in range(0, len(samples[0]), 50):
        parts.append(navigator.push_block(*(column[start : start + 50] for column in samples)))
        navigator.now()
    assert_same(Trajectory.concatenate([*parts, navigator.flush()]), batch["default"])


def test_now_after_flush_is_the_last_state():
    navigator = Navigator(rate_hz=RATE)
    states = in_blocks(navigator, walk(), [])
    assert navigator.now().t == states.t[-1]
    np.testing.assert_array_equal(navigator.now().position, states.position[-1])


@pytest.mark.parametrize("after", [0, 40, 500, 750])
def test_reset_restarts_the_navigator(after):
    samples = walk()
    fresh = in_blocks(Navigator(rate_hz=RATE), samples, [])
    navigator = Navigator(rate_hz=RATE)
    navigator.push_block(*(column[:after] for column in samples))
    navigator.reset()
    assert navigator.now() is navigator.t is navigator.covariance is None
    assert navigator.health == Navigator(rate_hz=RATE).health
    again = in_blocks(navigator, samples, [])
    assert_same(again, fresh)
    assert again.health == fresh.health


def test_data_that_were_ended_take_no_more_until_reset():
    t, accel, gyro = walk()
    navigator = Navigator(rate_hz=RATE)
    in_blocks(navigator, (t, accel, gyro), [])
    for use in (
        navigator.flush,
        lambda: navigator.push(99.0, *accel[0], *gyro[0]),
        lambda: navigator.push_block(t + 99, accel, gyro),
    ):
        with pytest.raises(DataError, match=r"reset\(\)"):
            use()
    navigator.reset()
    assert len(in_blocks(navigator, (t, accel, gyro), [])) == len(t)


@pytest.mark.parametrize("at", [0, 1, 60, 400, 749])
@pytest.mark.parametrize(
    ("column", "value", "named"),
    [
        (0, np.nan, "time"),
        (0, np.inf, "time"),
        (1, np.nan, "accel_x"),
        (3, -np.inf, "accel_z"),
        (5, np.nan, "gyro_y"),
    ],
)
def test_a_sample_that_is_not_finite_is_refused_and_counted(at, column, value, named):
    samples = walk()
    expected = in_blocks(Navigator(rate_hz=RATE), samples, [])
    navigator = Navigator(rate_hz=RATE)
    first = navigator.push_block(*(part[:at] for part in samples))
    bad = [samples[0][at], *samples[1][at], *samples[2][at]]
    bad[column] = value
    with pytest.raises(DataError, match=f"sample {at}.*{named}"):
        navigator.push(*bad)
    rest_of_it = navigator.push_block(*(part[at:] for part in samples))
    states = Trajectory.concatenate([first, rest_of_it, navigator.flush()])
    assert_same(states, expected, [name for name in COLUMNS if name != "flags"])
    assert navigator.health.counters == dataclasses.replace(expected.health.counters, refused=1)


@pytest.mark.parametrize("back", [-1e-9, -5.0, -1e9])
def test_a_sample_back_in_time_is_refused_and_flagged(back):
    t, accel, gyro = walk()
    navigator = Navigator(rate_hz=RATE)
    navigator.push_block(t, accel, gyro)
    with pytest.raises(DataError, match=f"sample {len(t)}: time goes back"):
        navigator.push(t[-1] + back, *accel[0], *gyro[0])
    assert navigator.health.counters.refused == 1
    assert navigator.push(t[-1] + 0.01, *accel[-1], *gyro[-1])
    assert Flag.REFUSED in Flag(int(navigator.flush().flags[-1]))


@pytest.mark.parametrize("at", [0, 1, 100, 349])
@pytest.mark.parametrize(
    ("column", "value"), [("t", np.nan), ("t", -1.0), ("accel", np.inf), ("gyro", np.nan)]
)
def test_a_block_with_one_bad_sample_leaves_the_navigator_untouched(column, value, at):
    samples = walk()
    expected = in_blocks(Navigator(rate_hz=RATE), samples, [])
    navigator = Navigator(rate_hz=RATE)
    first = navigator.push_block(*(part[:400] for part in samples))
    bad = dict(zip(("t", "accel", "gyro"), (part[400:].copy() for part in samples), strict=True))
    bad[column][at] = value
    with pytest.raises(DataError, match=f"sample {400 + at}"):
        navigator.push_block(**bad)
    second = navigator.push_block(*(part[400:] for part in samples))
    assert_same(Trajectory.concatenate([first, second, navigator.flush()]), expected)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda t, accel, gyro: (t, accel[:-1], gyro),
        lambda t, accel, gyro: (t, accel, gyro[:-1]),
        lambda t, accel, gyro: (t[:-1], accel, gyro),
        lambda t, accel, gyro: (t, accel.T, gyro),
        lambda t, accel, gyro: (t, accel[:, :2], gyro),
        lambda t, accel, gyro: (t, accel, np.column_stack([gyro, gyro])),
        lambda t, accel, gyro: (t[:, None], accel, gyro),
        lambda t, accel, gyro: (t[0], accel[0], gyro[0]),
        lambda t, accel, gyro: (t, accel.ravel(), gyro),
        lambda t, accel, gyro: (t, accel[None], gyro),
        lambda t, accel, gyro: (t, None, gyro),
        lambda t, accel, gyro: (t, "walk", gyro),
        lambda t, accel, gyro: (t, [[1.0, 2.0, 3.0], [1.0]], gyro),
    ],
)
def test_a_wrong_shape_is_a_data_error_and_leaves_the_navigator_untouched(spoil):
    samples = walk()
    navigator = Navigator(rate_hz=RATE)
    with pytest.raises(DataError, match=r"shape|number"):
        navigator.push_block(*spoil(*samples))
    assert navigator.health.counters.samples == 0
    assert_same(in_blocks(navigator, samples, []), in_blocks(Navigator(rate_hz=RATE), samples, []))


def read_only(array):
    """Return a copy that cannot be written."""
    copy = array.copy()
    copy.flags.writeable = False
    return copy


@pytest.mark.parametrize(
    "convert",
    [
        np.ndarray.tolist,
        lambda a: a.astype(np.float32),
        lambda a: a.astype(np.longdouble),
        lambda a: a.astype(">f8"),
        np.asfortranarray,
        read_only,
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a[::-1].copy()[::-1],
        lambda a: np.frombuffer(b"\0" + a.tobytes(), dtype=np.float64, offset=1).reshape(a.shape),
    ],
    ids=[
        "list",
        "float32",
        "longdouble",
        "bigendian",
        "fortran",
        "readonly",
        "strided",
        "reversed",
        "unaligned",
    ],
)
def test_array_likes_give_the_same_numbers(convert):
    samples = walk()
    states = in_blocks(Navigator(rate_hz=RATE), samples, [])
    navigator = Navigator(rate_hz=RATE)
    part = navigator.push_block(*map(convert, samples))
    assert_same(Trajectory.concatenate([part, navigator.flush()]), states)


def test_a_column_of_a_block_is_made_once_and_cannot_be_written():
    block = Navigator(rate_hz=RATE).push_block(*walk())
    assert block.position is block.position
    assert block.health is block.health
    assert (block.name, block.filter_strides) == ("", None)
    for name in COLUMNS:
        assert not getattr(block, name).flags.writeable
    with pytest.raises(AttributeError, match="Trajectory' object has no attribute 'positions'"):
        block.positions  # noqa: B018
    assert_same(pickle.loads(pickle.dumps(block)), block)
    named = dataclasses.replace(block, name="block")
    assert_same(named, block)
    assert (named.name, named.frame, named.health) == ("block", block.frame, block.health)


def test_input_arrays_are_not_written():
    samples = walk()
    before = tuple(column.copy() for column in samples)
    in_blocks(Navigator(rate_hz=RATE), samples, [])
    for column, copy in zip(samples, before, strict=True):
        np.testing.assert_array_equal(column, copy)


@pytest.mark.parametrize("rate_hz", [0.0, -100.0, 1.0, 1e6, np.nan, np.inf])
def test_a_rate_out_of_range_is_a_config_error(rate_hz):
    with pytest.raises(ConfigError, match="rate_hz"):
        Navigator(rate_hz=rate_hz)


def test_settings_are_remembered():
    config = Config(alignment=Alignment(duration=2.0))
    navigator = Navigator(config, rate_hz=128.0)
    assert (navigator.config, navigator.rate_hz) == (config, 128.0)
    assert Navigator().rate_hz == 200.0


@pytest.fixture
def eager_threads():
    """Let threads take turns far more often than usual."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(interval)


@pytest.mark.usefixtures("eager_threads")
def test_two_threads_on_one_navigator_get_an_error_or_a_correct_result():
    """One pushes the walk and tries again when it is turned away.

    The other reads, and pushes samples that must be refused.
    """
    samples = walk()
    expected = in_blocks(Navigator(rate_hz=RATE), samples, [])
    navigator = Navigator(rate_hz=RATE)
    parts = [navigator.push_block(*(column[:10] for column in samples))]
    unexpected, done = [], threading.Event()

    def disturb():
        while not done.is_set():
            try:
                position, covariance, now = (
                    navigator.position,
                    navigator.covariance,
                    navigator.now(),
                )
                assert position is None or np.isfinite(position).all()
                assert covariance is None or np.array_equal(covariance, covariance.T)
                assert np.isfinite(now.position).all()
                navigator.push_block([-1.0], [[0.0, 0.0, 9.8]], [[0.0, 0.0, 0.0]])
            except (BusyError, DataError):
                continue
            except BaseException as error:
                unexpected.append(error)
                return

    def push(block):
        while True:
            try:
                return navigator.push_block(*(column[block] for column in samples))
            except BusyError:
                continue

    thread = threading.Thread(target=disturb)
    thread.start()
    try:
        parts += [push(slice(start, start + 20)) for start in range(10, len(samples[0]), 20)]
    finally:
        done.set()
        thread.join()
    assert not unexpected
    states = Trajectory.concatenate([*parts, navigator.flush()])
    assert_same(states, expected, [name for name in COLUMNS if name != "flags"])


def test_a_concurrent_call_raises_and_changes_nothing():
    """A detector that reads its own navigator takes the place of the other thread.

    It always comes at the wrong moment.
    """
    errors = []

    class Nosy:
        latency = 0

        def push(self, t, accel, gyro):
            for attempt in (
                lambda: navigator.position,
                lambda: navigator.push(t, *accel, *gyro),
                navigator.reset,
            ):
                with pytest.raises(
                    BusyError, match=r"another call is at work.*its own navigator"
                ) as error:
                    attempt()
                errors.append(error)
            return False

        def reset(self):
            pass

    navigator = Navigator(rate_hz=RATE, detector=Nosy())
    samples = [column[:5] for column in walk()]
    assert len(navigator.push_block(*samples)) == 5
    assert len(errors) == 15
    assert navigator.health.counters.samples == 5


@pytest.mark.slow
def test_the_portable_kernel_gives_the_same_track():
    """The kernel is chosen once per process, so the other one runs in a process of its own."""
    program = (
        "import sys, numpy as np, footnav;"
        "recording, _ = footnav.simulate([[0, 0], [8, 0]], seed=3);"
        "np.save(sys.stdout.buffer, footnav.track(recording).position)"
    )

    def positions(kernel):
        environment = {**os.environ, "FOOTNAV_KERNEL": kernel}
        run = subprocess.run(
            [sys.executable, "-c", program], env=environment, capture_output=True, check=True
        )
        return np.load(io.BytesIO(run.stdout))

    np.testing.assert_allclose(positions("plain"), positions(""), rtol=0, atol=1e-9)
