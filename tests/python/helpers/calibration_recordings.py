"""Sensors with known errors, and recordings of them, for the tests of the calibration."""

from dataclasses import replace

import numpy as np

from footnav import Recording
from footnav.calibration import simulate_poses
from footnav.config import Matrix
from footnav.simulation import SensorErrors

MPU6050 = SensorErrors.preset("mpu6050")
SIX_SIDES = [[0, 0, 1], [0, 1, 0], [0, 0, -1], [1, 0, 0], [0, -1, 0], [-1, 0, 0]]


def rows(matrix: np.ndarray) -> Matrix:
    """Return a matrix as settings hold it."""
    return tuple(map(tuple, np.asarray(matrix).tolist()))


def known_sensor(seed: int, noise: float = 1.0) -> SensorErrors:
    """Make an MPU6050 with errors of random signs: scale 2 %, misalignment 1 deg, biases.

    Its bias does not walk and does not feel gravity: what is to be found is one number.
    """
    random = np.random.default_rng(seed)

    def matrix() -> Matrix:
        signs = random.choice([-1.0, 1.0], size=(3, 3))
        return rows(np.eye(3) + signs * np.where(np.eye(3), 0.02, np.radians(1.0)))

    def bias(size: float) -> tuple[float, float, float]:
        return tuple((size * random.choice([-1.0, 1.0], size=3)).tolist())

    drawn = {"bias_std": 0.0, "bias_walk": 0.0, "scale_std": 0.0, "misalignment_std": 0.0}
    accel = MPU6050.accel.replace(**drawn, matrix=matrix(), bias=bias(0.1))
    gyro = MPU6050.gyro.replace(**drawn, matrix=matrix(), bias=bias(np.radians(1.0)))
    if not noise:
        accel, gyro = (triad.replace(noise_density=0.0, resolution=0.0) for triad in (accel, gyro))
    return SensorErrors(accel=accel, gyro=gyro)


def lower(matrix: np.ndarray) -> np.ndarray:
    """Return the lower triangular L with L'L = M'M.

    The same lengths, in the frame that a calibration settles on.
    """
    mirror = np.eye(3)[::-1]
    return mirror @ np.linalg.cholesky(mirror @ matrix.T @ matrix @ mirror).T @ mirror


def true_matrices(sensor: SensorErrors) -> tuple[np.ndarray, np.ndarray]:
    """Return the corrections of accelerometer and gyroscope in the accelerometer's frame."""
    errors = np.array(sensor.accel.matrix)
    accel = lower(np.linalg.inv(errors))
    turned = accel @ errors
    return accel, turned @ np.linalg.inv(np.array(sensor.gyro.matrix))


def quick_poses(sensor: SensorErrors | str, seed: int = 0, **options) -> Recording:
    """Record the sides and edges with little time in each."""
    return simulate_poses(
        sensor=sensor, seed=seed, **({"rate_hz": 50.0, "initial": 3.0, "rest": 2.5} | options)
    )


def warmed(poses, temperature: np.ndarray, bias, scale, gyro_bias, seed: int = 0) -> Recording:
    """Rest in one pose over die temperatures, with polynomials of T - 25 (linear term first)."""
    n = len(temperature)
    clean = simulate_poses(poses, "ideal", seed, initial=n / 50.0, rate_hz=50.0)
    powers = np.power.outer(temperature - 25.0, np.arange(1, len(bias) + 1))
    noise = (
        np.random.default_rng(seed).normal(size=(2, n, 3)) * np.array([0.02, 0.001])[:, None, None]
    )
    return replace(
        clean,
        accel=clean.accel * (1 + powers @ scale) + powers @ bias + noise[0],
        gyro=clean.gyro + powers @ gyro_bias + noise[1],
        temperature=temperature,
        name=f"warm-up {seed}",
    )
