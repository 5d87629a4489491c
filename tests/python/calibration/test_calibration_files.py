"""Files of a calibration.

Its own TOML, Kalibr's imu.yaml, imucal's JSON, and the registers of an MPU6050.
"""

import json

import msgspec
import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from footnav import ConfigError, FootnavWarning
from footnav import mpu6050 as chip
from footnav.calibration import (
    SensorCalibration,
    TemperatureModel,
    Triad,
    load_calibration,
    load_imucal,
    load_kalibr,
    mpu6050,
    read_calibration,
    save_kalibr,
)
from footnav.config import Sensor
from footnav.mpu6050 import Setup

LOWER = ((1.02, 0.0, 0.0), (0.01, 0.97, 0.0), (-0.02, 0.03, 1.01))
FULL = ((0.99, 0.01, -0.02), (0.02, 1.03, 0.01), (-0.01, 0.015, 0.98))
SETUP = Setup(accel_range_g=8, gyro_range_deg_s=1000, dlpf_cfg=3, smplrt_div=4)
THERMAL = TemperatureModel(reference=25.0, lowest=10.0, highest=40.0, bias=((1e-3, 0.0, -2e-3),))
WHOLE = SensorCalibration(
    device="shoe-1",
    gravity=9.81,
    mpu6050=SETUP,
    accel=Triad(
        matrix=LOWER,
        bias=(0.1, -0.2, 0.3),
        matrix_std=LOWER,
        bias_std=(1e-3,) * 3,
        range=78.5,
        thermal=THERMAL,
    ),
    gyro=Triad(matrix=FULL, bias=(0.01, -0.02, 0.03), range=17.45, date="2026-01-31"),
    mag=Triad(bias=(2e-5, 0.0, -1e-5)),
)


# TOML


def test_a_calibration_round_trips_through_its_file(tmp_path):
    path = tmp_path / "shoe.toml"
    WHOLE.save(path)
    assert load_calibration(path) == WHOLE


def written(tmp_path, text):
    path = tmp_path / "shoe.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[acel]\n", r"shoe.toml: unknown setting 'acel'.*did you mean 'accel'"),
        ("[accel]\nbias = [1.0]\n", r"shoe.toml: accel.bias: Expected `array` of length 3"),
        (
            "[gyro]\nmatrix = [[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]\n",
            r"shoe.toml: gyro.matrix = .*three rows",
        ),
        (
            "[mag.thermal]\nreference = 20.0\nlowest = 30.0\nhighest = 10.0\n",
            r"shoe.toml: mag.thermal.lowest = 30: expected",
        ),
        (
            "[mpu6050]\naccel_range_g = 3\ngyro_range_deg_s = 250\n",
            r"accel_range_g is 3; an MPU6050 has 2, 4, 8, 16",
        ),
        ("device =", r"shoe.toml: not a TOML file"),
    ],
)
def test_a_file_that_is_impossible_is_refused_by_name(tmp_path, text, message):
    with pytest.raises(ConfigError, match=message):
        load_calibration(written(tmp_path, text))


def test_a_missing_file_is_refused_by_name(tmp_path):
    with pytest.raises(ConfigError, match=r"none.toml: No such file"):
        load_calibration(tmp_path / "none.toml")


# Merging


def test_an_update_replaces_the_sensors_that_it_has():
    newer = SensorCalibration(device="shoe-1", mag=Triad(bias=(3e-5, 0.0, 0.0)))
    merged = WHOLE.update(newer)
    assert merged.mag == newer.mag
    assert merged.replace(mag=WHOLE.mag) == WHOLE


def test_a_newer_bias_keeps_scale_and_misalignment():
    old = SensorCalibration(gyro=Triad(matrix=FULL, matrix_std=FULL, residual=0.1))
    merged = old.update(SensorCalibration(gyro=Triad(bias=(0.1, 0.2, 0.3), note="bias only")))
    assert merged.gyro == Triad(matrix=FULL, matrix_std=FULL, residual=0.1, bias=(0.1, 0.2, 0.3))


@pytest.mark.parametrize(
    ("newer", "message"),
    [
        (
            SensorCalibration(device="shoe-2"),
            r"has device 'shoe-1', the new one 'shoe-2'; keep two files",
        ),
        (
            SensorCalibration(mpu6050=SETUP.replace(dlpf_cfg=0)),
            r"has mpu6050 Setup.*dlpf_cfg=3.*dlpf_cfg=0",
        ),
        (
            SensorCalibration(accel=Triad(range=156.9)),
            r"accelerometer is for a full scale of 78.5, the new one for 156.9",
        ),
    ],
)
def test_calibrations_that_do_not_belong_together_are_not_merged(newer, message):
    with pytest.raises(ConfigError, match=message):
        WHOLE.update(newer)


# Kalibr

KALIBR = {
    "accelerometer_noise_density": 4e-3,
    "accelerometer_random_walk": 1e-4,
    "gyroscope_noise_density": 2e-4,
    "gyroscope_random_walk": 1e-5,
    "rostopic": "/imu0",
    "update_rate": 200.0,
}


def write_yaml(tmp_path, content):
    path = tmp_path / "imu.yaml"
    path.write_text(yaml.safe_dump(content))
    return path


def test_noise_figures_are_those_of_kalibr(tmp_path):
    imu = load_kalibr(write_yaml(tmp_path, KALIBR))
    assert (imu.rate_hz, imu.topic, imu.calibration) == (200.0, "/imu0", None)
    expected = Sensor(
        gyro_noise_density=2e-4, accel_noise_density=4e-3, gyro_bias_walk=1e-5, accel_bias_walk=1e-4
    )
    assert imu.sensor == expected
    assert load_kalibr(write_yaml(tmp_path, {"imu0": KALIBR})).sensor == expected


def test_kalibr_round_trip(tmp_path):
    path = tmp_path / "imu.yaml"
    save_kalibr(path, Sensor(), 100.0, WHOLE, "/foot")
    imu = load_kalibr(path)
    assert (imu.rate_hz, imu.topic, imu.sensor) == (100.0, "/foot", Sensor())
    np.testing.assert_allclose(imu.calibration.accel.matrix, LOWER, atol=1e-12)
    np.testing.assert_allclose(imu.calibration.gyro.matrix, FULL, atol=1e-12)
    content = yaml.safe_load(path.read_text())
    scale, turn = (np.array(content["gyroscopes"][key]) for key in ("M", "C_gyro_i"))
    np.testing.assert_allclose(np.triu(scale, 1), 0.0, atol=1e-12)
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1.0)


def test_kalibr_has_no_place_for_a_full_accelerometer_matrix(tmp_path):
    with pytest.raises(
        ConfigError, match="not lower triangular, as Kalibr's is; calibrate it from poses"
    ):
        save_kalibr(
            tmp_path / "imu.yaml", Sensor(), 100.0, SensorCalibration(accel=Triad(matrix=FULL))
        )
    assert not (tmp_path / "imu.yaml").exists()


INTRINSICS = {
    "accelerometers": {"M": np.eye(3).tolist()},
    "gyroscopes": {
        "M": np.eye(3).tolist(),
        "C_gyro_i": np.eye(3).tolist(),
        "A": np.zeros((3, 3)).tolist(),
    },
}


def test_sensitivity_to_acceleration_is_left_out_with_a_warning(tmp_path):
    coupled = (
        KALIBR
        | INTRINSICS
        | {"gyroscopes": INTRINSICS["gyroscopes"] | {"A": (1e-3 * np.eye(3)).tolist()}}
    )
    with pytest.warns(FootnavWarning, match=r"imu.yaml: gyroscopes.A, up to 0.001 .* is left out"):
        load_kalibr(write_yaml(tmp_path, coupled))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (KALIBR | {"update_rate": -1}, r"imu.yaml: update_rate is -1; expected a positive number"),
        ({"update_rate": 100}, r"accelerometer_noise_density is None; expected a positive number"),
        ([1, 2], r"imu.yaml: expected keys such as update_rate: this is not Kalibr's imu.yaml"),
        (
            KALIBR | INTRINSICS | {"accelerometers": {"M": [1, 2]}},
            r"accelerometers.M is \[1, 2\]; expected three rows of three numbers",
        ),
        (
            KALIBR | INTRINSICS | {"accelerometers": {"M": np.zeros((3, 3)).tolist()}},
            r"imu.yaml: M cannot be inverted",
        ),
    ],
)
def test_other_files_than_kalibrs_are_refused(tmp_path, content, message):
    with pytest.raises(ConfigError, match=message):
        load_kalibr(write_yaml(tmp_path, content))


def test_invalid_yaml_is_refused(tmp_path):
    path = tmp_path / "imu.yaml"
    path.write_text("a: [1,\nb")
    with pytest.raises(ConfigError, match=r"imu.yaml: not a YAML file"):
        load_kalibr(path)
    with pytest.raises(ConfigError, match=r"none.yaml: No such file"):
        load_kalibr(tmp_path / "none.yaml")


# imucal


def imucal_content(**changes):
    """Return what imucal writes for scale 2 % too much on x, and a bias."""
    content = {
        "cal_type": "Ferraris",
        "_format_version": "2.0.0",
        "acc_unit": "m/s^2",
        "gyr_unit": "deg/s",
        "from_acc_unit": "m/s^2",
        "from_gyr_unit": "deg/s",
        "comment": None,
        "K_a": np.diag([1.02, 1.0, 1.0]).tolist(),
        "R_a": np.eye(3).tolist(),
        "b_a": [0.1, 0.0, -0.2],
        "K_g": np.diag([1.0, 0.99, 1.0]).tolist(),
        "R_g": np.eye(3).tolist(),
        "b_g": [1.0, 2.0, -3.0],
        "K_ga": np.zeros((3, 3)).tolist(),
    }
    return content | changes


def write_json(tmp_path, content):
    path = tmp_path / "cal.json"
    path.write_text(json.dumps(content))
    return path


def test_the_suffix_selects_the_format(tmp_path):
    """Each as its own reader reads it."""
    calibration = load_imucal(write_json(tmp_path, imucal_content()))
    calibration.save(tmp_path / "shoe.toml")
    assert read_calibration(tmp_path / "shoe.toml") == load_calibration(tmp_path / "shoe.toml")
    assert read_calibration(write_json(tmp_path, imucal_content())) == calibration
    save_kalibr(tmp_path / "imu.yaml", Sensor(), 200.0, calibration)
    assert read_calibration(tmp_path / "imu.yaml") == load_kalibr(tmp_path / "imu.yaml").calibration


def test_files_without_a_calibration_are_refused(tmp_path):
    with pytest.raises(
        ConfigError, match=r"imu.yaml: holds noise figures, but no scale or misalignment"
    ):
        read_calibration(write_yaml(tmp_path, KALIBR))
    with pytest.raises(
        ConfigError,
        match=r"shoe.txt: unknown suffix '.txt', expected .toml, .yaml .Kalibr. or .json",
    ):
        read_calibration(tmp_path / "shoe.txt")


def test_imucal_is_converted_to_si_units(tmp_path):
    found = load_imucal(write_json(tmp_path, imucal_content()))
    np.testing.assert_allclose(found.accel.matrix, np.diag([1 / 1.02, 1.0, 1.0]))
    np.testing.assert_allclose(found.gyro.matrix, np.diag([1.0, 1 / 0.99, 1.0]))
    np.testing.assert_allclose(found.gyro.bias, np.radians([1.0, 2.0, -3.0]))


@pytest.mark.parametrize("unit", ["g", "m/s^2"])
def test_imucal_itself_agrees(tmp_path, unit):
    imucal = pytest.importorskip("imucal")
    path = write_json(tmp_path, imucal_content(from_acc_unit=unit, R_a=FULL, R_g=LOWER))
    raw = np.array([[0.3, -0.5, 1.1], [9.0, 2.0, -4.0]])
    theirs = imucal.CalibrationInfo.from_json_file(path).calibrate(raw, raw, unit, "deg/s")
    ours = load_imucal(path)
    scale = 9.80665 if unit == "g" else 1.0
    np.testing.assert_allclose(ours.accel.correct(raw * scale), theirs[0])
    np.testing.assert_allclose(ours.gyro.correct(np.radians(raw)), np.radians(theirs[1]))


def test_imucal_sensitivity_to_acceleration_is_left_out_with_a_warning(tmp_path):
    path = write_json(tmp_path, imucal_content(K_ga=(0.1 * np.eye(3)).tolist()))
    with pytest.warns(
        FootnavWarning, match=r"cal.json: K_ga, up to 0.1 deg/s per m/s\^2, is left out"
    ):
        load_imucal(path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"cal_type": "Magic"}, r"cal.json: cal_type is 'Magic'; expected Ferraris or Turntable"),
        ({"b_a": [1.0]}, r"cal.json: b_a is \[1.0\]; expected numbers of shape \(3,\)"),
        ({"K_g": [["a"] * 3] * 3}, r"cal.json: K_g is .*; expected numbers of shape \(3, 3\)"),
        (
            {"from_acc_unit": "a.u."},
            r"from_acc_unit is 'a.u.'; expected one of m/s\^2, g, mg: a calibration of raw counts",
        ),
        ({"K_a": np.zeros((3, 3)).tolist()}, r"cal.json: K_a times R_a cannot be inverted"),
    ],
)
def test_other_files_than_imucals_are_refused(tmp_path, changes, message):
    with pytest.raises(ConfigError, match=message):
        load_imucal(write_json(tmp_path, imucal_content(**changes)))


def test_invalid_json_is_refused(tmp_path):
    path = tmp_path / "cal.json"
    path.write_text("{")
    with pytest.raises(ConfigError, match=r"cal.json: not a JSON file"):
        load_imucal(path)
    with pytest.raises(ConfigError, match=r"none.json: No such file"):
        load_imucal(tmp_path / "none.json")


# Registers of the MPU6050


def test_sensitivities_are_those_of_the_data_sheet():
    """PS-MPU-6000A, tables 6.1 and 6.2, rounded as there."""
    for full_scale, counts in ((2, 16384), (4, 8192), (8, 4096), (16, 2048)):
        assert chip.accel_range_g(counts) == full_scale
        assert SETUP.replace(accel_range_g=full_scale).accel_counts_per_g == counts
    for full_scale, counts in ((250, 131), (500, 65.5), (1000, 32.8), (2000, 16.4)):
        assert chip.gyro_range_deg_s(counts) == full_scale
        assert SETUP.replace(gyro_range_deg_s=full_scale).gyro_counts_per_deg_s == pytest.approx(
            counts, abs=0.08
        )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: chip.accel_range_g(1000),
            r"1000 counts per g: an MPU6050 has 16384, 8192, 4096, 2048",
        ),
        (
            lambda: chip.gyro_range_deg_s(14.375),
            r"14.375 counts per deg/s: an MPU6050 has 131.07, 65.536, 32.768",
        ),
        (lambda: SETUP.replace(dlpf_cfg=7), r"dlpf_cfg is 7; an MPU6050 has 0 to 6"),
        (lambda: SETUP.replace(smplrt_div=256), r"smplrt_div is 256; an MPU6050 has 0 to 255"),
        (
            lambda: mpu6050.factory_trim([1, 2, 3]),
            r"self-test registers are \[1, 2, 3\]; expected the four bytes",
        ),
    ],
)
def test_settings_that_the_chip_lacks_are_refused(call, message):
    with pytest.raises(ConfigError, match=message):
        call()


def test_rate_and_delays_follow_from_the_registers():
    assert (SETUP.rate_hz, SETUP.accel_filter.bandwidth_hz, SETUP.gyro_filter.delay) == (
        200.0,
        44.0,
        4.8e-3,
    )
    assert Setup(accel_range_g=2, gyro_range_deg_s=250, dlpf_cfg=0, smplrt_div=7).rate_hz == 1000.0
    assert SETUP.replace(dlpf_cfg=0).accel_lag == pytest.approx(-0.98e-3)
    assert SETUP.replace(dlpf_cfg=2).accel_lag == pytest.approx(0.2e-3)


def test_the_temperature_of_the_die():
    np.testing.assert_allclose(
        chip.temperature_degc([0, -3920, 340]), [36.53, 25.0, 37.53], atol=1e-2
    )


def test_the_factory_trim_is_decoded_as_in_the_register_map():
    """Accelerometer x is 10110 (upper bits in register 13, lower ones in 16), gyroscope x 00001."""
    accel, gyro = mpu6050.factory_trim([0b101_00001, 0b001_11111, 0, 0b00_10_01_00])
    assert accel[0] == pytest.approx(4096 * 0.34 * (0.92 / 0.34) ** (21 / 30))
    assert accel[1] == pytest.approx(4096 * 0.34 * (0.92 / 0.34) ** (4 / 30))
    assert gyro == pytest.approx((25 * 131, -25 * 131 * 1.046**30, 0.0))
    assert accel[2] == 0.0


@given(change=st.floats(-0.5, 0.5))
def test_a_part_passes_within_fourteen_percent(change):
    registers = [0b101_00001, 0b001_11111, 0b110_01000, 0b00_10_01_01]
    accel, gyro = (np.array(trim) for trim in mpu6050.factory_trim(registers))
    result = mpu6050.self_test(registers, accel * (1 + change), gyro)
    np.testing.assert_allclose(result.accel_change, change, atol=1e-12)
    assert result.passed == (max(map(abs, result.accel_change)) <= 0.14)
    assert ("passed" if result.passed else "failed") in str(result)


def test_a_part_without_factory_trim_does_not_pass():
    assert not mpu6050.self_test([0, 0, 0, 0], [0.0] * 3, [0.0] * 3).passed


@pytest.mark.parametrize("in_g", [0.25, 0.5, 2.0, 4.0, 8.0])
def test_a_wrong_range_shows_at_rest(in_g):
    factor = f"{in_g:g} times" if in_g > 1 else f"1/{1 / in_g:g} of"
    assert f"accel_range is {factor} what the sensor was set to" in mpu6050.explain_rest(
        in_g * 9.80665 * 1.05
    )


@pytest.mark.parametrize("in_g", [0.0, 0.9, 1.1, 1.4, 2.8, 32.0])
def test_a_level_that_no_range_explains_has_no_message(in_g):
    assert mpu6050.explain_rest(in_g * 9.80665) is None


def test_settings_of_the_chip_are_settings():
    assert msgspec.json.decode(msgspec.json.encode(SETUP), type=Setup) == SETUP
