"""Rest detection, and that `footnav info` decides as `footnav track` does."""

import warnings

import numpy as np
import pytest

from footnav import Config, FootnavWarning, Recording, read, simulate, track
from footnav.config import Alignment, HealthLimits
from footnav.diagnosis import diagnose
from footnav.health import Flag
from footnav.rest_detection import (
    ALLAN,
    CALIBRATION,
    CAPTURE,
    RestDetector,
    RestLimits,
    alignment_limits,
    detect_rest,
    longest_run,
    runs,
)
from footnav.simulation import Gait, Route

RATE = 200


def walk(rest=1.0, rate_hz=RATE, jitter=0.0, seed=4):
    """Simulate a short walk after some rest, s."""
    gait = Gait.preset("walk").replace(rest_before=rest)
    return simulate(Route.straight(6.0), gait, "mpu6050", seed, rate_hz=rate_hz, jitter=jitter)[0]


def part(recording, rows):
    """Return some rows of a recording."""
    return Recording(
        recording.t[rows], recording.accel[rows], recording.gyro[rows], name=recording.name
    )


def without(recording, *lost):
    """Return a recording in which samples are lost."""
    return part(recording, np.delete(np.arange(len(recording)), lost))


def tracked_health(recording, config=None):
    """Return the health of a track, whose warnings repeat it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FootnavWarning)
        return track(recording, config).health


def check_agreement(recording, config=None):
    """Compare start and gaps of the data-quality report and of the track; return both."""
    health, diagnosis = tracked_health(recording, config), diagnose(recording, config)
    assert diagnosis.at_rest_at_start == (Flag.MOVING_START not in health.flags)
    assert (diagnosis.gaps, diagnosis.repeated) == (health.counters.gaps, health.counters.repeated)
    assert any("gap" in finding for finding in diagnosis.findings) == (health.counters.gaps > 0)
    return diagnosis.at_rest_at_start, diagnosis.gaps


@pytest.mark.parametrize("rate_hz", [100, 104, 200, 833])
@pytest.mark.parametrize("rest", [0.0, 0.1, 0.3, 1.0])
def test_info_and_track_agree_about_the_rest_at_the_start(rest, rate_hz):
    at_rest, gaps = check_agreement(walk(rest, rate_hz))
    assert gaps == 0
    assert at_rest or rest < 0.2


@pytest.mark.parametrize("jitter", [0.1, 0.24])
@pytest.mark.parametrize("rest", [0.1, 0.15, 0.2, 0.25, 0.3])
def test_info_and_track_agree_with_jittered_stamps(rest, jitter):
    for seed in range(3):
        check_agreement(walk(rest, jitter=jitter, seed=seed))


@pytest.mark.parametrize("start", range(600, 770, 10))
def test_info_and_track_agree_about_a_start_in_motion(start):
    at_rest, _ = check_agreement(part(walk(3.0), slice(start, None)))
    assert not at_rest or start < 650


def test_info_and_track_agree_with_stamps_on_arrival():
    """Late by up to a sample, so that some intervals are gaps and some stamps are repeated."""
    recording = walk(0.3)
    for seed in range(10):
        late = np.random.default_rng(seed).exponential(0.3, len(recording)).clip(max=1.0) / RATE
        t = np.maximum.accumulate(np.round(recording.t + late, 3))
        check_agreement(Recording(t, recording.accel, recording.gyro))


@pytest.mark.parametrize("rate_hz", [100.0, 104.3, 208.6, 833.4])
@pytest.mark.parametrize(
    ("lost", "gaps"), [((), 0), ((150,), 1), ((150, 151), 1), ((150, 160), 2), ((20,), 1)]
)
def test_info_and_track_count_the_same_lost_samples(lost, gaps, rate_hz):
    recording = walk(1.0, round(rate_hz))
    exact = Recording(
        np.arange(len(recording)) / rate_hz, recording.accel, recording.gyro, name="exact"
    )
    assert check_agreement(without(exact, *lost)) == (True, gaps)


def test_a_single_lost_sample_is_reported():
    diagnosis = diagnose(without(walk(), 500))
    assert any(finding.startswith("1 gap of 0.01 s") for finding in diagnosis.findings)
    assert "no problems found" in str(diagnose(walk()))


def test_the_settings_decide_for_both():
    recording = without(walk(0.3), 500)
    strict = Config(
        alignment=Alignment(rest_gyro_std=0.002), health=HealthLimits(gap_intervals=2.5)
    )
    assert check_agreement(recording) == (True, 1)
    assert check_agreement(recording, strict) == (False, 0)


@pytest.mark.filterwarnings("ignore::footnav.errors.FootnavWarning")
def test_info_and_track_agree_about_real_recordings(data_dir):
    paths = [
        *sorted((data_dir / "openshoe").glob("*.npz")),
        *sorted((data_dir / "vicon").glob("*.npz"))[:8],
        *sorted((data_dir / "footprints").glob("*.npz"))[:4],
        data_dir / "xio" / "short_walk.csv",
    ]
    for path in paths:
        recording = read(path)
        check_agreement(recording)
        # The same walks from a later moment, most of them in motion.
        for start in (len(recording) // 3, len(recording) // 2):
            check_agreement(part(recording, slice(start, None)))


# The detector


def resting(seconds=10.0, rate_hz=100.0, seed=1):
    """Record white noise of 0.02 m/s² and 0.002 rad/s at rest."""
    t = np.arange(round(seconds * rate_hz) + 1) / rate_hz
    noise = np.random.default_rng(seed).normal(0.0, 1.0, (2, len(t), 3))
    return Recording(t, [0.0, 0.0, 9.81] + 0.02 * noise[0], 0.002 * noise[1])


def test_statistics_are_those_of_the_samples_of_each_block():
    recording = resting()
    blocks = detect_rest(recording, CALIBRATION)
    assert len(blocks) == 20
    assert blocks.at_rest.all()
    np.testing.assert_array_equal(blocks.first[1:], blocks.last[:-1])
    for k in range(len(blocks)):
        rows = slice(blocks.first[k] + 1, blocks.last[k] + 1)
        np.testing.assert_allclose(blocks.accel[k], recording.accel[rows].mean(axis=0), rtol=1e-12)
        np.testing.assert_allclose(blocks.gyro_std[k], recording.gyro[rows].std(axis=0), rtol=1e-6)
        so_far = recording.gyro[1 : blocks.first[k] + 1]
        drift = blocks.gyro[k] - so_far.mean(axis=0) if k else np.zeros(3)
        np.testing.assert_allclose(blocks.gyro_drift[k], drift, atol=1e-12)


@pytest.mark.parametrize("size", [1, 7, 64, 1000])
def test_pieces_of_any_length_give_the_same_blocks(size):
    recording = walk(2.0)
    whole = detect_rest(recording, CAPTURE)
    detector = RestDetector(CAPTURE, recording.rate_hz)
    rows = [slice(start, start + size) for start in range(0, len(recording), size)]
    pieces = [
        detector.push_block(recording.t[r], recording.accel[r], recording.gyro[r]) for r in rows
    ]
    joined = pieces[0]
    for piece in pieces[1:]:
        joined += piece
    for name in ("first", "last", "at_rest", "accel", "gyro_std"):
        np.testing.assert_array_equal(getattr(joined, name), getattr(whole, name))


def test_the_incomplete_block_at_the_end_is_returned_once_it_is_asked_for():
    recording = resting(2.3)
    detector = RestDetector(ALLAN, recording.rate_hz)
    assert len(detector.finish()) == 0
    assert len(detector.push_block(recording.t, recording.accel, recording.gyro)) == 2
    tail = detector.finish()
    assert (tail.first.tolist(), tail.last.tolist()) == ([200], [230])
    assert tail.at_rest.all()


def test_motion_a_gap_and_a_drift_separate_rests():
    recording = resting(10.0)
    gyro, t = recording.gyro.copy(), recording.t.copy()
    gyro[201:250] += np.sin(np.arange(49.0))[:, None]
    gyro[501:] += 0.02
    t[800:] += 0.8
    blocks = detect_rest(Recording(t, recording.accel, gyro), CALIBRATION)
    starts = [float(t[blocks.first[rest.start]]) for rest in blocks.rests()]
    assert starts == pytest.approx([0.0, 2.5, 5.5, 8.8], abs=0.01)


def test_limits_of_the_alignment_are_those_of_the_settings():
    limits = alignment_limits(
        Config(alignment=Alignment(rest_accel_std=0.4, rest_gyro_std=0.1, duration=0.1))
    )
    assert limits == RestLimits(
        block=0.1,
        max_span=0.2,
        min_duration=0.05,
        accel_std=0.4,
        gyro_std=0.1,
        accel_drift=0.4,
        gyro_drift=0.1,
    )
    assert alignment_limits(Config()).min_duration == pytest.approx(0.15)


def test_runs_of_true():
    starts, stops = runs(np.array([True, False, True, True, False, True]))
    assert (starts.tolist(), stops.tolist()) == ([0, 2, 5], [1, 4, 6])
    assert longest_run(np.array([True, False, True, True])) == slice(2, 4)
    assert longest_run(np.zeros(3, dtype=bool)) == slice(0, 0)
