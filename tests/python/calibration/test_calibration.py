"""Calibration recovers the errors of simulated sensors, and rejects unsuitable recordings."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import footnav
from calibration_recordings import (
    MPU6050,
    SIX_SIDES,
    known_sensor,
    quick_poses,
    rows,
    true_matrices,
    warmed,
)
from footnav import ConfigError, DataError, Recording
from footnav.calibration import (
    SensorCalibration,
    TemperatureModel,
    Triad,
    calibrate_accel,
    calibrate_gyro,
    calibrate_mag,
    calibrate_six_position,
    calibrate_temperature,
    simulate_poses,
)
from footnav.calibration.static import find_rests
from footnav.config import IDENTITY
from footnav.mpu6050 import Setup
from footnav.simulation import SensorErrors, TriadErrors


@pytest.fixture(scope="module")
def poses() -> Recording:
    """Record the sides and edges with an MPU6050 whose errors are known."""
    return quick_poses(known_sensor(1), 1)


@pytest.fixture(scope="module")
def calibration(poses) -> SensorCalibration:
    return calibrate_accel(poses, device="shoe-1")


def resting(**changes) -> Recording:
    """Two seconds flat on the table."""
    clean = simulate_poses([[0, 0, 1]], "ideal", rate_hz=100.0, initial=4.0)
    return replace(clean, name="rest.csv", **changes)


# Poses


def test_an_ideal_sensor_needs_no_correction():
    found = calibrate_accel(quick_poses("ideal"))
    for triad in (found.accel, found.gyro):
        np.testing.assert_allclose(triad.matrix, np.eye(3), atol=1e-9)
        np.testing.assert_allclose(triad.bias, 0.0, atol=1e-9)


def test_without_noise_the_errors_are_recovered_exactly():
    sensor = known_sensor(3, noise=0.0)
    found = calibrate_accel(quick_poses(sensor))
    accel, gyro = true_matrices(sensor)
    np.testing.assert_allclose(found.accel.matrix, accel, atol=1e-9)
    np.testing.assert_allclose(found.accel.bias, sensor.accel.bias, atol=1e-8)
    np.testing.assert_allclose(found.gyro.bias, sensor.gyro.bias, atol=1e-12)
    # The means of the gyroscope over intervals, and coning between them, are right to the fourth
    # order.
    np.testing.assert_allclose(found.gyro.matrix, gyro, atol=1e-6)


@pytest.mark.slow
def test_errors_lie_within_three_of_their_sigmas():
    """Of 100 runs 95 should have all 21 numbers inside.

    Fewer than 6 of 8 would come about once in 1000.
    """
    inside = 0
    for seed in range(8):
        sensor = known_sensor(seed)
        found = calibrate_accel(quick_poses(sensor, seed))
        accel, gyro = true_matrices(sensor)
        deviations = [
            (np.array(found.accel.matrix) - accel)[np.tril_indices(3)]
            / np.array(found.accel.matrix_std)[np.tril_indices(3)],
            (np.array(found.accel.bias) - sensor.accel.bias) / found.accel.bias_std,
            ((np.array(found.gyro.matrix) - gyro) / found.gyro.matrix_std).ravel(),
            (np.array(found.gyro.bias) - sensor.gyro.bias) / found.gyro.bias_std,
        ]
        inside += bool((np.abs(np.concatenate(deviations)) < 3).all())
    assert inside >= 6


def test_sigmas_are_not_idle(calibration):
    assert 1e-5 < np.array(calibration.accel.matrix_std).max() < 1e-3
    assert (
        1e-5
        < np.array(calibration.gyro.matrix_std).min()
        < np.array(calibration.gyro.matrix_std).max()
        < 2e-3
    )
    assert 1 <= calibration.accel.condition < 3
    assert 0 < calibration.accel.residual < 0.01


def test_an_outlier_among_the_poses_does_not_spoil_the_fit():
    sensor = known_sensor(5)
    clean = quick_poses(sensor, 5)
    rests = find_rests(clean)
    accel = clean.accel.copy()
    accel[rests.start[7] - 40 : rests.stop[7] + 40] *= 1.05
    found = calibrate_accel(replace(clean, accel=accel)).accel
    np.testing.assert_allclose(found.bias, sensor.accel.bias, atol=0.01)
    np.testing.assert_allclose(np.diag(found.matrix), np.diag(true_matrices(sensor)[0]), atol=1e-3)


@pytest.mark.slow
def test_calibrated_walks_close_five_times_better():
    """In the mean of four sensors.

    Where the errors of one happen to cancel around the square, less is gained.
    """
    config = footnav.Config.preset("mpu6050")
    errors = []
    for seed in range(1, 5):
        sensor = known_sensor(seed)
        found = calibrate_accel(quick_poses(sensor, seed))
        raw, truth = footnav.simulate(footnav.simulation.Route.square(6.0), "walk", sensor, seed)
        tracks = (footnav.track(recording, config) for recording in (raw, found.apply(raw)))
        errors.append([footnav.evaluate(track, truth).closing_error.spatial for track in tracks])
    before, after = np.mean(errors, axis=0)
    assert before > 5 * after


@given(order=st.permutations(range(18)))
@settings(max_examples=3, deadline=None)
def test_the_order_of_the_poses_does_not_matter(order):
    from footnav.calibration.simulation import SIDES_AND_EDGES

    sensor = known_sensor(4, noise=0.0)
    found = calibrate_accel(quick_poses(sensor, poses=SIDES_AND_EDGES[list(order)]))
    np.testing.assert_allclose(found.accel.matrix, true_matrices(sensor)[0], atol=1e-9)


def test_several_recordings_are_one(poses):
    half = find_rests(poses).stop[8] - 1
    parts = [
        Recording(poses.t[part], poses.accel[part], poses.gyro[part], name=f"part {k}")
        for k, part in enumerate((slice(0, half), slice(find_rests(poses).start[8], None)))
    ]
    found = calibrate_accel(parts)
    np.testing.assert_allclose(found.accel.bias, calibrate_accel(poses).accel.bias, atol=5e-3)


def test_gravity_comes_from_the_latitude_or_is_given(poses):
    equator = calibrate_accel(poses, latitude_deg=0.0)
    assert equator.gravity == pytest.approx(9.7803, abs=1e-4)
    ratio = (
        np.array(calibrate_accel(poses, gravity=9.7803).accel.matrix)[0, 0]
        / equator.accel.matrix[0][0]
    )
    assert ratio == pytest.approx(1.0, abs=1e-5)


def test_too_few_poses_name_those_that_are_missing():
    few = quick_poses("ideal", poses=[[0, 0, 1], [0, 1, 0], [1, 0, 0]])
    with pytest.raises(
        DataError,
        match=r"simulated poses 0: 3 rest\(s\) in 3 different pose\(s\); 9 or more.*no pose with -x",
    ):
        calibrate_accel(few)
    with pytest.raises(DataError, match=r"no pose with -z up, 6 more poses, such as edges down"):
        calibrate_accel(few)


def test_similar_poses_are_not_counted_twice():
    leaning = [[np.sin(a), np.sin(2 * a), 1] for a in np.linspace(0, 0.1, 12)]
    with pytest.raises(DataError, match=r"12 rest\(s\) in . different pose\(s\)"):
        calibrate_accel(quick_poses("ideal", poses=leaning))


def test_nine_poses_without_one_side_are_refused():
    from footnav.calibration.simulation import SIDES_AND_EDGES

    upper = SIDES_AND_EDGES[SIDES_AND_EDGES[:, 2] >= 0]
    with pytest.raises(DataError, match=r"missing: no pose with -z up$"):
        calibrate_accel(quick_poses("ideal", poses=upper))


def test_a_start_in_motion_is_refused_with_axis_value_and_limit(poses):
    moving = Recording(poses.t[200:], poses.accel[200:], poses.gyro[200:], name="walk.csv")
    with pytest.raises(
        DataError,
        match=r"walk.csv: not at rest: accel_[xyz] \w+ by [\d.]+ m/s\^2 at .* more than 0.1",
    ):
        calibrate_accel(moving)


def test_without_turns_the_gyroscope_has_its_bias_only(poses):
    one_by_one = [
        simulate_poses([pose], known_sensor(1), 1, initial=3.0, rate_hz=50.0)
        for pose in [*SIX_SIDES, [1, 1, 0], [1, 0, 1], [0, 1, 1], [-1, 1, 0]]
    ]
    found = calibrate_accel(one_by_one).gyro
    assert found.note.startswith("bias only: between its rests the recording turns too little")
    assert found.matrix_std is None
    np.testing.assert_allclose(found.bias, known_sensor(1).gyro.bias, atol=1e-3)


def test_a_turn_that_clips_is_refused(poses):
    clipping = replace(poses, gyro=np.clip(poses.gyro, -1.5, 1.5), gyro_range=1.5)
    with pytest.raises(
        DataError, match=r"simulated poses 1: gyro_[xyz] clips at 86 deg/s in a turn at .* slower"
    ):
        calibrate_accel(clipping)


def test_a_turn_with_a_gap_is_refused(poses):
    kept = np.r_[0:180, 200 : len(poses)]
    gappy = Recording(poses.t[kept], poses.accel[kept], poses.gyro[kept], name="gap.csv")
    with pytest.raises(
        DataError,
        match=r"gap.csv: 0.420 s without a sample in the turn at 3.58 s; record without gaps",
    ):
        calibrate_accel(gappy)


def test_no_recording_at_all_is_refused():
    with pytest.raises(DataError, match="there is no recording to calibrate from"):
        calibrate_accel([])


def test_recordings_at_two_ranges_are_refused(poses):
    other = replace(poses, name="b.csv", accel_range=2 * poses.accel_range)
    with pytest.raises(
        ConfigError, match=r"b.csv has accel_range 156.9, but simulated poses 1 has 78.45"
    ):
        calibrate_accel([poses, other])


def test_registers_inconsistent_with_the_recording_are_refused(poses):
    with pytest.raises(
        ConfigError,
        match=r"accel_range of the recording is 78.45, that of the given registers 156.9",
    ):
        calibrate_accel(poses, setup=Setup(accel_range_g=16, gyro_range_deg_s=1000))


# Misread MPU6050s


@pytest.mark.parametrize(
    ("factor", "text"), [(0.5, r"0.50 g .* is 1/2 of what"), (2.0, r"2.00 g .* is 2 times")]
)
def test_a_wrong_range_is_recognized(factor, text):
    clean = quick_poses("ideal")
    wrong = replace(clean)
    # A recording refuses twice gravity itself; one that does not know better stands in for it.
    object.__setattr__(wrong, "accel", clean.accel * factor)
    for calibrate in (calibrate_accel, calibrate_six_position):
        with pytest.raises(
            DataError, match=f"simulated poses 0: at rest the accelerometer reads {text}"
        ):
            calibrate(wrong)


def test_offsets_of_i2cdevlib_are_recognized():
    """One g too much on z: an upright sensor reads 2 g."""
    offset = quick_poses(SensorErrors(accel=TriadErrors(bias=(0.0, 0.0, 9.8))))
    with pytest.raises(
        DataError, match=r"accel_z reads \+1.00 g too much.*2.00 g.*i2cdevlib.*switch the power off"
    ):
        calibrate_accel(offset)


# Six positions


def test_six_positions_and_full_turns_give_the_errors_back():
    sensor = known_sensor(6, noise=0.0)
    turns = 2 * np.pi * np.eye(3)
    found = calibrate_six_position(quick_poses(sensor, poses=SIX_SIDES, turns=turns, move=6.0))
    np.testing.assert_allclose(found.accel.matrix, np.linalg.inv(sensor.accel.matrix), atol=1e-9)
    np.testing.assert_allclose(found.accel.bias, sensor.accel.bias, atol=1e-9)
    np.testing.assert_allclose(found.gyro.matrix, np.linalg.inv(sensor.gyro.matrix), atol=1e-9)
    np.testing.assert_allclose(found.gyro.bias, sensor.gyro.bias, atol=1e-12)


def test_six_positions_without_turns_are_noted():
    found = calibrate_six_position(quick_poses(known_sensor(6), poses=SIX_SIDES))
    assert found.gyro.note.startswith("bias only: turns of 360 deg about each axis")
    assert found.gyro.matrix_std is None


def test_a_missing_side_is_named():
    with pytest.raises(
        DataError, match="simulated poses 0: no rest with -x up; all six sides are needed"
    ):
        calibrate_six_position(quick_poses("ideal", poses=SIX_SIDES[:-1]))


def test_offsets_are_recognized_in_six_positions():
    offset = quick_poses(SensorErrors(accel=TriadErrors(bias=(6.0, 0.0, 0.0))), poses=SIX_SIDES)
    with pytest.raises(DataError, match=r"accel_x reads \+0.61 g too much"):
        calibrate_six_position(offset)


def test_the_result_is_that_of_imucal():
    imucal = pytest.importorskip("imucal")
    pandas = pytest.importorskip("pandas")
    sensor = known_sensor(7)
    order = [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    turns = 2 * np.pi * np.eye(3)
    recording = simulate_poses(order, sensor, 7, turns=turns, rest=6.0, move=4.0)
    rests = find_rests(recording)
    samples = np.column_stack([recording.accel, np.degrees(recording.gyro)])
    regions = {
        name: samples[rests.start[k] : rests.stop[k]]
        for k, name in enumerate(["x_p", "x_a", "y_p", "y_a", "z_p", "z_a"])
    }
    between = {
        name: samples[rests.stop[5 + k] : rests.start[6 + k]]
        for k, name in enumerate(["x", "y", "z"])
    }
    regions |= {f"{name}_rot": piece for name, piece in between.items()}
    table = pandas.concat(
        {
            name: pandas.DataFrame(
                piece, columns=["acc_x", "acc_y", "acc_z", "gyr_x", "gyr_y", "gyr_z"]
            )
            for name, piece in regions.items()
        },
        names=["part"],
    ).droplevel(1)
    gravity = footnav.Config().gravity
    theirs = imucal.FerrarisCalibration(grav=gravity, expected_angle=360.0).compute(
        imucal.ferraris_regions_from_df(table), 100.0, from_acc_unit="m/s^2", from_gyr_unit="deg/s"
    )
    ours = calibrate_six_position(recording)
    np.testing.assert_allclose(ours.accel.matrix, np.linalg.inv(theirs.K_a @ theirs.R_a), atol=1e-3)
    np.testing.assert_allclose(ours.accel.bias, theirs.b_a, atol=5e-3)
    np.testing.assert_allclose(ours.gyro.matrix, np.linalg.inv(theirs.K_g @ theirs.R_g), atol=1e-3)
    np.testing.assert_allclose(ours.gyro.bias, np.radians(theirs.b_g), atol=1e-4)


# Gyroscope at rest


def test_the_bias_at_rest_is_the_mean():
    bias = (0.02, -0.01, 0.005)
    found = calibrate_gyro(
        simulate_poses([[0, 0, 1]], SensorErrors(gyro=TriadErrors(bias=bias)), initial=3.0)
    )
    np.testing.assert_allclose(found.gyro.bias, bias, atol=1e-12)
    assert found.gyro.note == "bias only: the recording has no turns"
    assert found.gyro.range is None
    assert found.accel is None


def test_the_bias_lies_within_three_sigmas():
    sensor = known_sensor(8)
    found = calibrate_gyro(simulate_poses([[0, 0, 1]], sensor, 8, initial=20.0)).gyro
    assert (np.abs(np.subtract(found.bias, sensor.gyro.bias)) < 3 * np.array(found.bias_std)).all()
    assert max(found.bias_std) < 1e-4


@pytest.mark.parametrize(
    ("channel", "text"),
    [
        (
            "gyro",
            r"rest.csv: not at rest: gyro_y changes by 0.02 rad/s at .* more than 0.01; lay the sensor down",
        ),
        (
            "accel",
            r"rest.csv: not at rest: accel_y changes by 0.2 m/s\^2 at .* more than 0.1; lay the sensor down",
        ),
    ],
)
def test_movement_is_refused_with_axis_value_and_limit(channel, text):
    recording = resting()
    samples = getattr(recording, channel).copy()
    samples[300:350, 1] += {"gyro": 0.02, "accel": 0.2}[channel]
    with pytest.raises(DataError, match=text):
        calibrate_gyro(replace(recording, **{channel: samples}))


def test_trembling_is_refused():
    recording = resting()
    trembling = recording.gyro + 0.05 * np.cos(np.arange(len(recording)))[:, None] * [0.0, 0.0, 1.0]
    with pytest.raises(DataError, match=r"gyro_z scatters by 0.0\d+ rad/s at .* more than 0.03"):
        calibrate_gyro(replace(recording, gyro=trembling))


def test_a_rest_with_missing_samples_is_refused():
    recording = resting()
    t = recording.t + np.where(np.arange(len(recording)) < 300, 0.0, 1.5)
    with pytest.raises(DataError, match=r"rest.csv: not at rest: samples are missing at 2\.5\d s"):
        calibrate_gyro(Recording(t, recording.accel, recording.gyro, name="rest.csv"))


def test_a_rest_that_is_too_short_is_refused():
    recording = resting()
    brief = Recording(recording.t[:50], recording.accel[:50], recording.gyro[:50], name="brief.csv")
    with pytest.raises(
        DataError, match=r"brief.csv: 50 samples of rest are too few; 100, a second, are needed"
    ):
        calibrate_gyro(brief)


# Temperature

WARMING = np.linspace(10.0, 40.0, 3000)
BIAS = np.array([[2e-3, -1e-3, 3e-3], [2e-5, 1e-5, -3e-5]])
SCALE = np.array([[3e-4, -2e-4, 1e-4], [0.0, 2e-6, 1e-6]])
GYRO_BIAS = np.array([[2e-4, -3e-4, 1e-4], [1e-6, 0.0, -2e-6]])


def test_opposite_poses_separate_bias_and_scale_over_temperature():
    recordings = [
        warmed([pose], WARMING, BIAS, SCALE, GYRO_BIAS, k) for k, pose in enumerate(SIX_SIDES)
    ]
    base = SensorCalibration(accel=Triad(temperature=25.0))
    found = calibrate_temperature(recordings, base)
    accel, gyro = found.accel.thermal, found.gyro.thermal
    assert accel.reference == 25.0
    for thermal, label, truth in (
        (accel, "bias", BIAS),
        (accel, "scale", SCALE),
        (gyro, "bias", GYRO_BIAS),
    ):
        error = np.abs(np.array(getattr(thermal, label)) - truth)
        assert (error < 4 * np.array(getattr(thermal, f"{label}_std"))).all(), label
    corrected = found.apply(recordings[3])
    np.testing.assert_allclose(corrected.accel[::500].mean(axis=0), [9.806, 0, 0], atol=0.03)
    assert np.abs(corrected.gyro.reshape(10, -1, 3).mean(axis=1)).max() < 2e-4


def test_one_pose_gives_the_change_of_the_bias_only():
    recording = warmed([[0, 0, 1]], WARMING, BIAS, 0 * SCALE, GYRO_BIAS)
    found = calibrate_temperature(recording, order=2)
    assert found.accel.thermal.scale == ()
    corrected = found.apply(recording).accel.reshape(10, -1, 3).mean(axis=1)
    assert np.ptp(corrected, axis=0).max() < 0.01
    assert np.ptp(recording.accel.reshape(10, -1, 3).mean(axis=1), axis=0).max() > 0.05


def test_a_temperature_outside_the_span_is_refused_with_both_numbers():
    recording = warmed([[0, 0, 1]], WARMING, BIAS, SCALE, GYRO_BIAS)
    found = calibrate_temperature(recording)
    text = (
        r"hot.csv: gyroscope: sample 0: the temperature is 60.0 degC, but the calibration holds "
        r"from 8.6 to 40.6"
    )
    with pytest.raises(DataError, match=text):
        found.replace(accel=None).apply(
            replace(recording, name="hot.csv", temperature=np.full(3000, 60.0))
        )
    with pytest.raises(DataError, match=r"the temperature is -5.0 degC"):
        found.config(temperature=-5.0)


def test_a_calibration_that_follows_the_temperature_needs_one():
    recording = warmed([[0, 0, 1]], WARMING, BIAS, SCALE, GYRO_BIAS)
    found = calibrate_temperature(recording)
    cold = replace(recording, temperature=None, name="cold.csv")
    with pytest.raises(
        DataError, match=r"cold.csv: accelerometer: .* the recording has none; give the temperature"
    ):
        found.apply(cold)
    assert np.isfinite(found.apply(cold, temperature=20.0).accel).all()
    with pytest.raises(DataError, match="give the temperature of the sensor"):
        found.config()


@pytest.mark.parametrize(
    ("changes", "options", "error", "text"),
    [
        (
            {"temperature": None},
            {},
            DataError,
            "warm-up 0 has no temperature; record that of the sensor's die",
        ),
        (
            {"temperature": np.full(3000, 25.0)},
            {},
            DataError,
            r"goes from 25.0 to 25.0 degC only; 5 K are needed",
        ),
        ({}, {"order": 4}, ConfigError, "order is 4; expected 1 to 3"),
    ],
)
def test_recordings_without_a_span_of_temperature_are_refused(changes, options, error, text):
    recording = replace(warmed([[0, 0, 1]], WARMING, BIAS, SCALE, GYRO_BIAS), **changes)
    with pytest.raises(error, match=text):
        calibrate_temperature(recording, **options)


def test_a_rest_that_is_too_short_for_the_temperature_is_refused():
    clean = quick_poses("ideal", poses=[[0, 0, 1], [0, 1, 0]], initial=2.0, rest=1.6)
    with pytest.raises(DataError, match="there is no rest of 2 s or more"):
        calibrate_temperature(replace(clean, temperature=np.linspace(10, 30, len(clean))))


# Magnetometer


def magnetic(
    matrix=IDENTITY, bias=(0.0, 0.0, 0.0), noise=0.0, keep=lambda directions: directions
) -> Recording:
    """Turn a magnetometer with soft and hard iron through directions all around, in 50 uT."""
    k = np.arange(1500) + 0.5
    height, angle = 1 - 2 * k / 1500, np.pi * (1 + 5**0.5) * k
    level = np.sqrt(1 - height**2)
    directions = keep(np.column_stack([level * np.cos(angle), level * np.sin(angle), height]))
    disturbed = np.random.default_rng(0).normal(size=directions.shape) * noise
    mag = (50e-6 * directions) @ np.linalg.inv(matrix).T + np.array(bias) + disturbed
    rest = simulate_poses([[0, 0, 1]], "ideal", initial=len(mag) / 100)
    return replace(rest, mag=mag, name="around.csv")


SOFT = np.array([[1.1, 0.05, -0.02], [0.05, 0.95, 0.03], [-0.02, 0.03, 1.0]])
HARD = (20e-6, -35e-6, 10e-6)


def test_hard_and_soft_iron_are_recovered():
    found = calibrate_mag(magnetic(SOFT, HARD), field=50e-6).mag
    np.testing.assert_allclose(found.matrix, SOFT, atol=1e-9)
    np.testing.assert_allclose(found.bias, HARD, atol=1e-15)


@pytest.mark.slow
def test_a_corrected_magnetometer_reads_one_strength():
    recording = magnetic(SOFT, HARD, noise=2e-7)
    corrected = calibrate_mag(recording).apply(recording)
    strength = np.linalg.norm(corrected.mag, axis=1)
    assert strength.std() < 0.01 * strength.mean()
    assert (np.abs(np.subtract(calibrate_mag(recording, field=50e-6).mag.bias, HARD)) < 1e-7).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("recording", "text"),
    [
        (resting(), "rest.csv has no magnetometer"),
        (
            magnetic(keep=lambda d: d[d[:, 2] > 0.0]),
            r"around.csv: the directions cover too little: .* never pointed along -z",
        ),
        (
            magnetic(noise=1.5e-5),
            r"around.csv: after the fit the strength of the field still scatters by \d+ %",
        ),
        (
            replace(resting(), mag=np.outer(np.linspace(1e-5, 2e-5, 400), [1.0, 1.0, 1.0])),
            "the directions cover too",
        ),
    ],
    ids=["none", "half", "disturbed", "line"],
)
def test_unusable_magnetometer_recordings_are_refused(recording, text):
    with pytest.raises(DataError, match=text):
        calibrate_mag(recording)


# Applying


def test_applying_equals_the_calibration_of_the_navigator(calibration):
    raw, _ = footnav.simulate(
        footnav.simulation.Route.straight(4.0), sensor=known_sensor(1), seed=1
    )
    config = footnav.Config.preset("mpu6050")
    outside = footnav.track(calibration.apply(raw), config)
    inside = footnav.track(raw, config.replace(calibration=calibration.config()))
    np.testing.assert_allclose(outside.position, inside.position, atol=1e-9)


def test_another_device_is_refused(calibration, poses):
    assert calibration.apply(poses, device="shoe-1").name == poses.name
    with pytest.raises(
        ConfigError, match="is of device 'shoe-2', but the calibration is of 'shoe-1'"
    ):
        calibration.apply(poses, device="shoe-2")


@pytest.mark.parametrize(
    ("label", "text"),
    [
        (
            "accel_range",
            r"accel_range 156.9 m/s\^2, but the calibration at 78.45 m/s\^2; each range",
        ),
        ("gyro_range", r"gyro_range 34.91 rad/s, but the calibration at 17.45 rad/s; each range"),
    ],
)
def test_another_range_is_refused(calibration, poses, label, text):
    other = replace(poses, **{label: 2 * getattr(poses, label)})
    with pytest.raises(ConfigError, match=text):
        calibration.apply(other)


def test_clipped_samples_stay_clipped(poses):
    accel = poses.accel.copy()
    accel[200:203] = poses.accel_range * np.eye(3)
    accel[203:206] = -poses.accel_range * np.eye(3)
    full = replace(poses, accel=accel)
    corrected = calibrate_accel(poses).apply(full)
    assert (np.abs(corrected.accel[200:206]).max(axis=1) > 0.995 * corrected.accel_range).all()
    assert 0.9 * full.accel_range < corrected.accel_range < 1.05 * full.accel_range


matrices = st.lists(st.floats(-0.05, 0.05), min_size=9, max_size=9).map(
    lambda values: rows(np.eye(3) + np.array(values).reshape(3, 3))
)
vectors = st.tuples(*[st.floats(-1.0, 1.0)] * 3)


@given(matrix=matrices, bias=vectors, slope=vectors, celsius=st.floats(11.0, 39.0))
def test_correcting_undoes_the_errors_at_every_temperature(matrix, bias, slope, celsius):
    slope = np.array(slope) / 100
    thermal = TemperatureModel(
        reference=25.0, lowest=10.0, highest=40.0, bias=(tuple(slope),), scale=(tuple(slope / 10),)
    )
    truth = np.array([[1.0, -2.0, 9.0], [0.0, 5.0, -7.0]])
    excess = celsius - 25.0
    scaled = truth @ np.linalg.inv(matrix).T * (1 + slope / 10 * excess)
    raw = scaled + bias + slope * excess
    triad = Triad(matrix=matrix, bias=bias, thermal=thermal)
    np.testing.assert_allclose(triad.correct(raw, np.full(2, celsius)), truth, atol=1e-12)
    np.testing.assert_allclose(triad.at(celsius).correct(raw), truth, atol=1e-12)


# Simulated poses


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"poses": [0, 0, 1]}, r"poses have shape \(3,\); expected \(k, 3\)"),
        ({"poses": [[0, 0, 1], [0, 0, 0]]}, "pose 1 points nowhere"),
        ({"rest": -1.0}, "rest is -1.0; expected a positive number"),
    ],
)
def test_poses_that_are_impossible_are_refused(options, text):
    with pytest.raises(ConfigError, match=text):
        simulate_poses(**options)


def test_the_same_seed_is_the_same_sensor_as_of_a_walk():
    errors = MPU6050.replace(accel=MPU6050.accel.replace(noise_density=0.0, bias_walk=0.0))
    walk, truth = footnav.simulate(footnav.simulation.Route.straight(2.0), sensor=errors, seed=4)
    still = simulate_poses([[0, 0, 1]], errors, 4, initial=2.0)
    start = walk.accel[:100].mean(axis=0)
    assert np.linalg.norm(start) == pytest.approx(
        np.linalg.norm(still.accel.mean(axis=0)), abs=0.05
    )
    np.testing.assert_allclose(truth.gyro_bias[0], still.gyro.mean(axis=0), atol=0.03)


# A real sensor


@pytest.mark.filterwarnings("ignore:.*mag has:footnav.FootnavWarning")
def test_a_walk_is_no_calibration_recording(data_dir):
    walk = footnav.read(data_dir / "openshoe" / "Measurement_100521_2.npz")
    with pytest.raises(
        DataError, match=r"3 rest\(s\) in 1 different pose\(s\).*no pose with -z up, 8 more poses"
    ):
        calibrate_accel(walk)


@pytest.mark.filterwarnings("ignore:.*mag has:footnav.FootnavWarning")
def test_the_rest_before_a_walk_gives_the_bias(data_dir):
    walk = footnav.read(data_dir / "openshoe" / "Measurement_100521_2.npz")
    n = int(2.0 * walk.rate_hz)
    rest = Recording(walk.t[:n], walk.accel[:n], walk.gyro[:n])
    found = calibrate_gyro(rest).gyro
    np.testing.assert_allclose(found.bias, rest.gyro.mean(axis=0), atol=1e-4)
    assert max(found.bias_std) < 2e-3
