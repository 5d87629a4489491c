"""The diagnosis finds what was put into a signal, and nothing else."""

import re

import numpy as np
import pytest

from footnav.diagnosis import diagnose
from footnav.io import read
from footnav.recording import STANDARD_GRAVITY, Recording

RATE = 200
REST = 1.5


def walk(seconds=12.0, rate=RATE, seed=1):
    """Return stamps and samples of a foot that rests, then swings for half of every second."""
    t = np.arange(round(seconds * rate)) / rate
    noise = np.random.default_rng(seed)
    phase = np.where(t < REST, 0.0, np.minimum((t - REST) % 1.0, 0.5) * 2)
    swing, bounce = np.sin(2 * np.pi * phase), np.sin(4 * np.pi * phase)
    accel = np.column_stack([30 * swing, 5 * swing, STANDARD_GRAVITY + 10 * bounce])
    gyro = np.column_stack([0.5 * swing, 8 * swing, -swing]) + np.radians([0.5, -0.3, 0.1])
    return t, accel + noise.normal(0, 0.02, accel.shape), gyro + noise.normal(0, 0.002, gyro.shape)


def test_a_sound_recording_has_no_findings():
    t, accel, gyro = walk()
    diagnosis = diagnose(Recording(t, accel, gyro, name="sound"))
    assert diagnosis.findings == ()
    assert diagnosis.clipping == ()
    assert (diagnosis.samples, diagnosis.repeated, diagnosis.gaps) == (2400, 0, 0)
    assert diagnosis.rate_hz == pytest.approx(RATE)
    assert diagnosis.jitter == pytest.approx(0.0, abs=1e-12)
    assert np.isnan(diagnosis.longest_gap)
    assert str(diagnosis).startswith("sound\n")


def test_the_rest_at_the_start_is_measured():
    rest = diagnose(Recording(*walk())).rest
    assert rest.duration == pytest.approx(REST, abs=0.11)
    assert rest.specific_force == pytest.approx(STANDARD_GRAVITY, abs=0.005)
    np.testing.assert_allclose(np.degrees(rest.gyro_bias), [0.5, -0.3, 0.1], atol=0.03)
    np.testing.assert_allclose(rest.accel_noise, 0.02, rtol=0.2)
    np.testing.assert_allclose(rest.gyro_noise, 0.002, rtol=0.2)


def test_text_gives_degrees_and_g_with_their_units():
    text = str(diagnose(Recording(*walk())))
    assert re.search(r"gyro bias +\+0\.5\d\d -0\.[23]\d\d \+0\.[01]\d\d deg/s at rest", text)
    assert re.search(r"\|accel\| 9\.8\d\d m/s\^2 \((0\.999|1\.000)\d g\)", text)


def test_moving_start_is_found():
    t, accel, gyro = walk()
    diagnosis = diagnose(Recording(t[310:], accel[310:], gyro[310:]))
    assert not diagnosis.at_rest_at_start
    assert any("stand still" in finding for finding in diagnosis.findings)


def test_a_recording_at_rest_throughout_is_all_rest():
    t, accel, gyro = walk(REST)
    assert diagnose(Recording(t, accel, gyro)).rest.duration == pytest.approx(REST, abs=0.11)


def test_a_very_short_recording_has_no_rest():
    t, accel, gyro = walk()
    assert diagnose(Recording(t[:2], accel[:2], gyro[:2])).rest is None


@pytest.mark.parametrize(
    "full_scale", [2 * STANDARD_GRAVITY, None], ids=["range known", "flat tops"]
)
def test_clipped_accelerometer_is_counted(full_scale):
    t, accel, gyro = walk()
    clipped = np.clip(accel, -2 * STANDARD_GRAVITY, 2 * STANDARD_GRAVITY)
    expected = np.abs(clipped[:, 0]) >= 0.995 * 2 * STANDARD_GRAVITY
    clipped[:, 2] = accel[:, 2].clip(max=15)
    diagnosis = diagnose(Recording(t, clipped, gyro, accel_range=full_scale))
    found = {clip.channel: clip for clip in diagnosis.clipping}
    assert found["accel_x"].samples == expected.sum()
    assert found["accel_x"].level == pytest.approx(2 * STANDARD_GRAVITY)
    # z was cut at 15 m/s^2, which the known range contradicts and the shape alone gives away.
    assert ("accel_z" in found) == (full_scale is None)


def test_finding_says_which_range_to_choose():
    t, accel, gyro = walk()
    limit, turn = 2 * STANDARD_GRAVITY, np.radians(250)
    clipped = Recording(
        t, accel.clip(-limit, limit), gyro.clip(-turn, turn), accel_range=limit, gyro_range=turn
    )
    count = (np.abs(clipped.accel) >= 0.995 * limit).any(axis=1).sum()
    first, second = diagnose(clipped).findings
    assert (
        first
        == f"the accelerometer clips at 19.6 m/s^2 in {count} samples (x, z): choose a range of 8 g or more"
    )
    assert "the gyroscope clips at 250 deg/s" in second
    assert "1000 deg/s or more" in second


def test_clip_smeared_by_a_calibration_is_found():
    t, accel, gyro = walk()
    limit = np.radians(400)
    smeared = gyro.clip(-limit, limit) @ np.array([[1, 0.002, 0], [0.001, 1, 0.001], [0, 0.001, 1]])
    assert [clip.channel for clip in diagnose(Recording(t, accel, smeared)).clipping] == ["gyro_y"]


@pytest.mark.parametrize("rate", [100, 400, 1600])
@pytest.mark.parametrize("step", [1e-3, 0.05])
def test_smooth_peaks_do_not_count_as_clipping(rate, step):
    t, accel, gyro = walk(rate=rate)
    gyro = np.round(gyro / step) * step
    assert diagnose(Recording(t, accel, gyro)).clipping == ()


def test_quantized_rest_and_steady_turn_do_not_count_as_clipping():
    t, accel, gyro = walk(6.0)
    noise = np.random.default_rng(2)
    rest = np.round(
        np.tile([0.0, 0.0, STANDARD_GRAVITY], (len(t), 1)) + noise.normal(0, 0.05, accel.shape), 1
    )
    turn = np.round(np.tile([0.0, 0.0, 3.0], (len(t), 1)) + noise.normal(0, 0.02, gyro.shape), 2)
    assert diagnose(Recording(t, rest, turn)).clipping == ()


def test_repeated_stamps_and_gaps_are_counted():
    t, accel, gyro = walk()
    t[100], t[200] = t[99], t[199]
    t[1000:] += 0.25
    diagnosis = diagnose(Recording(t, accel, gyro))
    # The step after a repeated stamp is two intervals long.
    assert (diagnosis.repeated, diagnosis.gaps) == (2, 3)
    assert diagnosis.longest_gap == pytest.approx(0.255)
    assert diagnosis.longest_gap_at == pytest.approx(999 / RATE)
    assert any("2 samples with the stamp" in finding for finding in diagnosis.findings)
    assert any("3 gaps" in finding for finding in diagnosis.findings)


def test_jitter_is_measured_without_gaps():
    t, accel, gyro = walk()
    noise = np.random.default_rng(3).normal(0, 1e-4, len(t))
    t = t + noise
    t[1000:] += 1.0
    assert diagnose(Recording(t, accel, gyro)).jitter == pytest.approx(np.sqrt(2) * 1e-4, rel=0.1)


def test_low_rate_bias_and_scale_are_found():
    t, accel, gyro = walk(rate=50)
    findings = " ".join(diagnose(Recording(t, 0.95 * accel, gyro + np.radians(5))).findings)
    assert "50 Hz is slow" in findings
    assert "-5.0 % from gravity" in findings
    assert "reads 5.5 deg/s" in findings


@pytest.mark.filterwarnings("ignore:.*mag has:footnav.errors.FootnavWarning")
def test_openshoe_walks_start_at_rest_and_do_not_clip(data_dir):
    paths = sorted((data_dir / "openshoe").glob("*.npz"))
    assert paths
    for path in paths:
        diagnosis = diagnose(read(path))
        assert diagnosis.at_rest_at_start
        assert diagnosis.clipping == ()


def test_x_io_walk_has_the_repeated_stamps_that_its_logger_left(data_dir):
    diagnosis = diagnose(read(data_dir / "xio" / "short_walk.csv"))
    assert diagnosis.repeated == 205
    assert diagnosis.clipping == ()


def test_flat_tops_find_the_raw_recordings_that_clip(data_dir):
    paths = sorted((data_dir / "mpu6050").glob("conf-*.csv"))
    assert paths
    for path in paths:
        left = [int(index) for index in path.name[5:7]]
        accel_range, gyro_range = 2 << left[0], 250 << left[1]
        known = read(path, foot="left", accel_range=accel_range, gyro_range=gyro_range)
        shape = diagnose(Recording(known.t, known.accel, known.gyro))
        sensors = {clip.channel[:-2] for clip in shape.clipping}
        expected = {"accel": accel_range == 2, "gyro": gyro_range == 250}
        assert sensors == {sensor for sensor, clips in expected.items() if clips}
