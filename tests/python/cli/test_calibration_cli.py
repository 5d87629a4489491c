"""`footnav calibrate` and `footnav track --calibration`: what they write, print and refuse."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import footnav
from calibration_recordings import SIX_SIDES, known_sensor, quick_poses, warmed
from footnav.calibration import (
    SensorCalibration,
    TemperatureModel,
    Triad,
    load_calibration,
    simulate_poses,
)
from footnav.cli import main

RANGES = ("--accel-range", 8, "--gyro-range", 1000)
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run a command in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run_command(*arguments: object) -> tuple[int, str, str]:
        return main([str(argument) for argument in arguments]), *capsys.readouterr()

    return run_command


@pytest.fixture(scope="module")
def poses() -> footnav.Recording:
    """Record the sides and edges with an MPU6050 whose errors are known."""
    return quick_poses(known_sensor(1), 1)


def test_accel_writes_both_sensors_and_prints_them(run, poses):
    poses.save("poses.csv")
    status, out, err = run(
        "calibrate", "accel", "poses.csv", *RANGES, "--device", "shoe-1", "--out", "shoe.toml"
    )
    found = load_calibration("shoe.toml")
    assert (status, err) == (0, "")
    assert found.device == "shoe-1"
    assert found.accel.range == pytest.approx(8 * 9.80665)
    assert found.mpu6050 is None
    for text in (
        "accel_x",
        "gyro_z",
        "+-",
        "accelerometer: 18 observations, residual 0.00",
        "gyroscope: 17 observations",
    ):
        assert text in out
    assert out.endswith("shoe.toml: accelerometer, gyroscope\n")
    np.testing.assert_allclose(found.accel.bias, known_sensor(1).accel.bias, atol=0.01)


def test_registers_are_kept_with_the_calibration(run, poses):
    poses.save("poses.csv")
    status, _, _ = run(
        "calibrate", "accel", "poses.csv", *RANGES, "--dlpf-cfg", 2, "--smplrt-div", 4
    )
    setup = load_calibration("calibration.toml").mpu6050
    assert status == 0
    assert (setup.accel_range_g, setup.gyro_range_deg_s, setup.rate_hz) == (8, 1000, 200.0)


@pytest.mark.parametrize(
    ("options", "text"),
    [
        (
            ("--dlpf-cfg", 2),
            "--dlpf-cfg and --smplrt-div need each other, and --accel-range and --gyro-range",
        ),
        (("--dlpf-cfg", 2, "--smplrt-div", 4), "--dlpf-cfg and --smplrt-div need each other"),
        (
            (*RANGES[:3], 999.5, "--dlpf-cfg", 2, "--smplrt-div", 4),
            "--gyro-range is 999.5; an MPU6050 has whole ones",
        ),
        (("--gravity", 99), "mechanization.gravity = 99: expected between 9 and 10.5"),
    ],
)
def test_options_that_are_impossible_are_misuse(run, poses, options, text):
    poses.save("poses.csv")
    status, out, err = run("calibrate", "accel", "poses.csv", *options)
    assert (status, out) == (2, "")
    assert text in err
    assert not Path("calibration.toml").exists()


def test_six_positions_on_the_command_line(run):
    turned = quick_poses(known_sensor(1), 1, poses=SIX_SIDES, turns=4 * np.pi * np.eye(3), move=8.0)
    turned.save("box.npz")
    status, out, _ = run("calibrate", "accel", "box.npz", "--six-position", "--turn-deg", 720)
    assert status == 0
    assert "gyroscope: 3 observations" in out
    matrix = np.array(load_calibration("calibration.toml").gyro.matrix)
    np.testing.assert_allclose(matrix, np.linalg.inv(known_sensor(1).gyro.matrix), atol=2e-3)


def test_too_few_poses_fail_and_do_not_change_the_old_file(run):
    Path("calibration.toml").write_text("device = 'old'\n")
    quick_poses("ideal", poses=SIX_SIDES[:4]).save("few.csv")
    status, out, err = run("calibrate", "accel", "few.csv")
    assert (status, out) == (1, "")
    assert err.startswith(
        "footnav: few.csv: 4 rest(s) in 4 different pose(s); 9 or more are needed, on all six sides"
    )
    assert Path("calibration.toml").read_text() == "device = 'old'\n"


def test_gyro_adds_to_an_existing_calibration(run, poses):
    poses.save("poses.csv")
    simulate_poses([[0, 0, 1]], known_sensor(1), 2, initial=4.0).save("rest.csv")
    run("calibrate", "accel", "poses.csv", "--out", "shoe.toml")
    before = load_calibration("shoe.toml")
    status, out, err = run(
        "calibrate", "gyro", "rest.csv", "--update", "shoe.toml", "--out", "shoe.toml"
    )
    after = load_calibration("shoe.toml")
    assert (status, err) == (0, "")
    assert "not measured" in out
    assert after.accel == before.accel
    assert after.gyro.matrix == before.gyro.matrix
    assert after.gyro.bias != before.gyro.bias


def test_a_moving_gyro_recording_fails(run, poses):
    poses.save("poses.csv")
    status, _, err = run("calibrate", "gyro", "poses.csv")
    assert status == 1
    assert "footnav: poses.csv: not at rest: accel_" in err


def test_temperature_adds_to_an_existing_calibration(run):
    ramp = np.linspace(10.0, 40.0, 2000)
    warmed([[0, 0, 1]], ramp, [[1e-3] * 3], [[0.0] * 3], [[1e-4] * 3]).save("warm.csv")
    SensorCalibration(accel=Triad(bias=(0.1, 0.0, 0.0), temperature=25.0)).save("shoe.toml")
    options = ("--order", 1, "--update", "shoe.toml", "--out", "shoe.toml")
    status, out, err = run("calibrate", "temperature", "warm.csv", *options)
    found = load_calibration("shoe.toml")
    assert (status, err) == (0, "")
    assert re.search(r"gyro_y bias, deg/s +\+[56]\.\d+e-03 \+- \d\.\de-0\d", out)
    assert "gyroscope: from 10.9 to 37.9 degC, T0 24.4, residual 0." in out
    assert found.accel.bias == (0.1, 0.0, 0.0)
    np.testing.assert_allclose(found.gyro.thermal.bias, [[1e-4] * 3], rtol=0.1)
    quick_poses("ideal").save("poses.csv")
    _, _, err = run("calibrate", "accel", "poses.csv", "--update", "shoe.toml")
    assert (
        "warning: the accelerometer has no temperature model any more: calibrate temperature again"
        in err
    )


def test_mag_without_a_magnetometer_fails(run, poses):
    poses.save("poses.csv")
    status, _, err = run("calibrate", "mag", "poses.csv")
    assert (status, err) == (1, "footnav: poses.csv has no magnetometer\n")


def test_mag_writes_hard_iron(run):
    directions = np.random.default_rng(0).normal(size=(800, 3))
    mag = 5e-5 * directions / np.linalg.norm(directions, axis=1, keepdims=True) + [1e-5, 0.0, 0.0]
    replace(simulate_poses([[0, 0, 1]], "ideal", initial=8.0), mag=mag).save("around.csv")
    status, out, _ = run("calibrate", "mag", "around.csv")
    assert status == 0
    assert "+10.0000 +- 0.0" in out
    np.testing.assert_allclose(
        load_calibration("calibration.toml").mag.bias, [1e-5, 0, 0], atol=1e-9
    )


def test_a_pair_of_feet_is_calibrated_one_by_one(run):
    counts = np.zeros((400, 13), dtype=int)
    counts[:, 0] = 10 * np.arange(400)
    counts[:, [3, 9]] = 4096
    np.savetxt("pair.csv", counts, fmt="%d", delimiter=",")
    status, _, err = run("calibrate", "gyro", "pair.csv", *RANGES)
    assert status == 2
    assert (
        "pair.csv holds the sensors of both feet; calibrate one at a time, with --foot left or right"
        in err
    )
    assert run("calibrate", "gyro", "pair.csv", *RANGES, "--foot", "left")[0] == 0


# Tracking


@pytest.fixture
def walk(tmp_path) -> footnav.Recording:
    recording = footnav.simulate(
        footnav.simulation.Route.straight(4.0), sensor=known_sensor(1), seed=1
    )[0]
    recording.save(tmp_path / "walk.npz")
    return recording


def test_tracking_applies_the_calibration(run, walk, poses):
    found = footnav.calibration.calibrate_accel(poses, device="shoe-1")
    found.save("shoe.toml")
    status, _, _ = run(
        "track", "walk.npz", "--calibration", "shoe.toml", "--device", "shoe-1", "--formats", "npz"
    )
    with np.load("walk.track.npz") as track:
        np.testing.assert_array_equal(track["position"], footnav.track(found.apply(walk)).position)
    assert status == 0


def test_tracking_with_the_calibration_of_another_device_is_misuse(run, walk):
    SensorCalibration(device="shoe-1").save("shoe.toml")
    status, _, err = run(
        "track", "walk.npz", "--calibration", "shoe.toml", "--device", "shoe-2", "--formats", "npz"
    )
    assert status != 0
    assert "walk.npz is of device 'shoe-2', but the calibration is of 'shoe-1'" in err


def test_tracking_asks_for_the_temperature_that_the_calibration_follows(run, walk):
    thermal = TemperatureModel(reference=25.0, lowest=10.0, highest=40.0, bias=((1e-3, 0.0, 0.0),))
    SensorCalibration(gyro=Triad(thermal=thermal)).save("shoe.toml")
    status, _, err = run("track", "walk.npz", "--calibration", "shoe.toml", "--formats", "npz")
    assert status == 1
    assert (
        "walk.npz: gyroscope: the calibration follows the temperature, but the recording has none"
        in err
    )
    options = ("--calibration", "shoe.toml", "--formats", "npz", "--temperature-degc")
    assert run("track", "walk.npz", *options, 20)[0] == 0
    status, _, err = run("track", "walk.npz", *options, 60)
    assert status == 1
    assert "the temperature is 60.0 degC, but the calibration holds from 8.0 to 42.0 degC" in err


def test_tracking_with_two_calibrations_is_misuse(run, walk):
    SensorCalibration().save("shoe.toml")
    footnav.Config(calibration=footnav.config.Calibration(accel_bias=(0.1, 0.0, 0.0))).save(
        "config.toml"
    )
    status, _, err = run(
        "track", "walk.npz", "--calibration", "shoe.toml", "--config", "config.toml"
    )
    assert status == 2
    assert (
        "--calibration and the [calibration] of --config both correct the readings; leave one out"
        in err
    )
