"""Real recordings with the default settings.

Finite tracks, the documented accuracy, and correct health.
"""

import warnings

import numpy as np
import pytest

from footnav import Config, FootnavWarning, Navigator, Recording, Trajectory, evaluate, read, track
from footnav.config import Filter
from footnav.detectors import AdaptiveShoe
from footnav.evaluation import path_length
from footnav.health import Flag, Status
from footnav.tracking import with_ranges_of

ACCEL_RANGES = (2, 4, 8, 16)
GYRO_RANGES = (250, 500, 1000, 2000)


def track_without_warnings(recording, config=None):
    """Track, with the default settings if no others are given.

    Warnings are tested elsewhere.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FootnavWarning)
        return track(recording, config)


def archives(folder):
    """Yield recording and truth, if there is one, of every archive in a folder."""
    for path in sorted(folder.glob("*.npz")):
        with np.load(path) as file:
            recording = Recording(file["t"], file["accel"], file["gyro"], name=path.stem)
            yield recording, file.get("position")


def mpu6050_pairs(folder):
    """Yield recording and whether its ranges hold a walking foot, for both feet of every walk."""
    for path in sorted(folder.glob("conf-*.csv")):
        accel_left, gyro_left, accel_right, gyro_right = map(int, path.name[5:9])
        for foot, a, g in (("left", accel_left, gyro_left), ("right", accel_right, gyro_right)):
            ranges = {"accel_range": ACCEL_RANGES[a], "gyro_range": GYRO_RANGES[g]}
            yield read(path, format="mpu6050-pair", foot=foot, **ranges), a > 0 and g > 0


def armse(states, truth):
    """Return the ARMSE, m: starts joined, yaw aligned 0.8 m from the start.

    Wagstaff et al. 2019; a track that stays nearer is aligned at its sample 300.
    """
    estimate, reference = (
        p[:, 0] - p[0, 0] + 1j * (p[:, 1] - p[0, 1]) for p in (states.position, truth)
    )
    far = np.flatnonzero(np.abs(estimate) >= 0.8)
    k = far[0] if far.size else min(300, len(estimate) - 1)
    turn = np.exp(1j * (np.angle(reference[k]) - np.angle(estimate[k])))
    value = np.abs(turn * estimate - reference).mean() / np.sqrt(2)
    if far.size:
        assert evaluate(states, truth).armse == pytest.approx(value)
    return value


def horizontal_closing(states):
    """Return the horizontal distance from start to end, m, and in percent of the distance."""
    error = np.hypot(*(states.position[-1] - states.position[0])[:2])
    return error, 100 * error / path_length(states.t, states.position)


def assert_valid(states, recording):
    """One finite row per sample, in the order of time, with quaternions that are rotations."""
    np.testing.assert_array_equal(states.t, recording.t)
    for column in ("position", "velocity", "quaternion", "position_std", "gyro_bias", "accel_bias"):
        assert np.isfinite(getattr(states, column)).all(), f"{recording.name}: {column}"
    np.testing.assert_allclose(np.linalg.norm(states.quaternion, axis=1), 1.0, atol=1e-9)
    assert (states.position_std >= 0).all()


@pytest.fixture(scope="module")
def vicon(data_dir):
    """Track the recordings with the truth of optical motion capture."""
    return [
        (recording, truth, track_without_warnings(recording))
        for recording, truth in archives(data_dir / "vicon")
    ]


@pytest.fixture(scope="module")
def openshoe(data_dir):
    """Track the closed walks."""
    return [
        (recording, track_without_warnings(recording))
        for recording, _ in archives(data_dir / "openshoe")
    ]


@pytest.fixture(scope="module")
def mpu6050(data_dir):
    """Track the closed walks of an MPU6050, and return whether their ranges suffice."""
    return [
        (recording, holds, track_without_warnings(recording))
        for recording, holds in mpu6050_pairs(data_dir / "mpu6050")
    ]


@pytest.fixture(scope="module")
def xio(data_dir):
    """Track a closed walk with repeated stamps and gaps."""
    recording = read(data_dir / "xio" / "short_walk.csv")
    return recording, track_without_warnings(recording)


def test_vicon_is_sound_and_as_accurate_as_documented(vicon):
    assert len(vicon) == 28
    for recording, _, states in vicon:
        assert_valid(states, recording)
    assert np.mean([armse(states, truth) for _, truth, states in vicon]) <= 0.10


def test_carrying_the_covariance_over_several_samples_at_once_moves_the_track_by_less_than_it_errs(
    vicon,
):
    step_by_step = Config(filter=Filter(covariance_interval=0.0))
    moved, errors = [], []
    for recording, truth, states in vicon:
        other = track_without_warnings(recording, step_by_step)
        moved.append(np.linalg.norm(states.position - other.position, axis=1).max())
        errors.append(armse(states, truth) - armse(other, truth))
        np.testing.assert_allclose(states.position_std, other.position_std, rtol=0.01)
    assert np.median(moved) < 1e-3
    assert abs(np.mean(errors)) < 1e-4


def test_openshoe_is_sound_and_closes_as_documented(openshoe):
    assert len(openshoe) == 7
    for recording, states in openshoe:
        assert_valid(states, recording)
        assert path_length(states.t, states.position) == pytest.approx(79, rel=0.1)
    assert np.median([horizontal_closing(states)[1] for _, states in openshoe]) <= 0.25


def test_mpu6050_is_sound_and_closes_as_documented_where_nothing_clips(mpu6050):
    assert len(mpu6050) == 14
    for recording, _, states in mpu6050:
        assert_valid(states, recording)
    held = [horizontal_closing(states)[1] for _, holds, states in mpu6050 if holds]
    assert len(held) >= 4
    assert np.median(held) <= 1.0


def test_mpu6050_that_clips_is_counted_and_flagged(mpu6050):
    for recording, holds, states in mpu6050:
        limits = [(recording.accel, recording.accel_range), (recording.gyro, recording.gyro_range)]
        at_the_end = any((np.abs(values) > 0.9999 * limit).any() for values, limit in limits)
        assert holds or at_the_end, recording.name
        assert (states.health.counters.clipped > 0) == at_the_end, recording.name
        assert (Flag.CLIPPED in states.health.flags) == at_the_end, recording.name


def test_xio_is_sound_and_closes_as_documented(xio):
    recording, states = xio
    assert_valid(states, recording)
    assert horizontal_closing(states)[0] <= 0.08


def test_xio_counts_defects_of_its_stamps(xio):
    recording, states = xio
    intervals = np.diff(recording.t)
    counters = states.health.counters
    assert counters.repeated == (intervals == 0).sum() == 205
    assert (
        counters.gaps
        == (intervals > Config().health.gap_intervals * np.median(intervals[intervals > 0])).sum()
    )
    assert states.health.status is Status.DEGRADED
    with pytest.warns(FootnavWarning, match=r"205 samples repeat.*missing"):
        track(recording)


def test_live_is_less_than_three_tenths_of_a_second_late_and_as_accurate_as_documented(
    vicon, openshoe, mpu6050, xio
):
    live = Config(detector=AdaptiveShoe.live())
    recordings = [recording for recording, *_ in (*vicon, *openshoe, *mpu6050, xio)]
    for rate in {60.0, 100.0, 200.0, 800.0} | {recording.rate_hz for recording in recordings}:
        assert Navigator(live, rate).latency / rate <= 0.3
    errors = []
    for recording, truth, _ in vicon:
        navigator = Navigator(live, recording.rate_hz)
        parts = [
            navigator.push_block(recording.t, recording.accel, recording.gyro),
            navigator.flush(),
        ]
        errors.append(armse(Trajectory.concatenate(parts), truth))
    assert np.mean(errors) <= 0.10


def test_a_start_in_motion_is_flagged_in_the_middle_of_a_walk(vicon):
    """Cut every walk where the foot turns fastest: the start that is left cannot be one at rest."""
    for recording, _, _ in vicon:
        turning = np.linalg.norm(recording.gyro, axis=1)
        start = 200 + int(turning[200:-800].argmax())
        cut = Recording(
            recording.t[start:],
            recording.accel[start:],
            recording.gyro[start:],
            name=recording.name,
        )
        with pytest.warns(FootnavWarning, match=f"^{recording.name}: .*motion"):
            states = track(cut)
        assert Flag.MOVING_START in states.health.flags, recording.name


def test_a_start_at_rest_by_the_truth_is_not_flagged(vicon):
    still = 0
    for recording, truth, states in vicon:
        first = recording.t <= recording.t[0] + Config().alignment.duration
        if np.linalg.norm(truth[first] - truth[0], axis=1).max() < 0.02:
            still += 1
            assert Flag.MOVING_START not in states.health.flags, recording.name
    assert still >= 20


@pytest.mark.parametrize("kind", ["vicon", "openshoe", "mpu6050", "xio"])
def test_streaming_is_the_batch_to_the_bit(kind, request):
    found = request.getfixturevalue(kind)
    recording, *_, states = found if kind == "xio" else found[0]
    navigator = Navigator(with_ranges_of(recording, Config()), recording.rate_hz)
    cuts = np.sort(np.random.default_rng(5).integers(0, len(recording), 50))
    blocks = zip(
        *(np.split(column, cuts) for column in (recording.t, recording.accel, recording.gyro)),
        strict=True,
    )
    streamed = Trajectory.concatenate(
        [*(navigator.push_block(*block) for block in blocks), navigator.flush()]
    )
    for column in (
        "t",
        "position",
        "velocity",
        "quaternion",
        "zero_velocity",
        "position_std",
        "gyro_bias",
        "flags",
    ):
        np.testing.assert_array_equal(
            getattr(streamed, column), getattr(states, column), err_msg=column
        )
    assert navigator.health.counters == states.health.counters
