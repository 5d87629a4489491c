"""P1: Wu, Lu, Chen, on foot-mounted personal navigation with MEMS inertial sensors."""

import math

from footnav.config import Config, Mechanization
from footnav.detectors import AdaptiveShoe, MagnitudeVariance
from footnav.simulation import Gait, Route, SensorErrors
from papers.experiment import ZUPT_ALONE, Approach, Experiment, Simulated, standing

RATE_HZ = 200.0
STEPS = 32
NORTH = 19.0
"""Length of the straight walk, m."""
SIDE = 17.0
"""Side of the square, m."""

LIMIT = 0.9
"""Both walks of the paper end within this percentage of the distance."""

UNCALIBRATED = SensorErrors.preset("mpu6050")
GYRO_BIAS = math.radians((22 + 20 + 26) / 3) / 3600
"""Mean of the paper's three bias stabilities, rad/s."""
ACCEL_BIAS = (0.62 + 0.57 + 0.67) / 3 * 9.80665e-3
"""Mean of the paper's three bias stabilities, m/s²."""
RESIDUAL = 1e-3
"""Scale error and misalignment that a calibration in six positions and on a turntable leaves."""

CALIBRATED = UNCALIBRATED.replace(
    accel=UNCALIBRATED.accel.replace(
        bias_std=ACCEL_BIAS, scale_std=RESIDUAL, misalignment_std=RESIDUAL
    ),
    gyro=UNCALIBRATED.gyro.replace(
        bias_std=GYRO_BIAS, scale_std=RESIDUAL, misalignment_std=RESIDUAL
    ),
)

COARSE, FINE = 10.0, 3.0
"""Rest for the two steps of the alignment, s; the paper has "a few seconds" for the second."""

# The first and the last stride are half ones, so one stride more than the way has lengths.
GAIT = Gait.preset("walk").replace(
    stride_length=NORTH / (STEPS / 2 - 1), rest_before=COARSE + FINE + 1.0
)

PUBLISHED = Config.preset("mpu6050").replace(
    alignment=standing(COARSE, levelling="arcsine", heading_deg=0.0, fine_duration=FINE),
    mechanization=Mechanization(kind="two-sample"),
    detector=MagnitudeVariance(),
    filter=ZUPT_ALONE,
)
UNAIDED = PUBLISHED.replace(filter=PUBLISHED.filter.replace(kind="ins"))
OTHER_DETECTOR = PUBLISHED.replace(detector=AdaptiveShoe())

APPROACHES = (
    Approach("ZUPT", PUBLISHED, paper=LIMIT, limit=LIMIT),
    Approach(
        "ZUPT, footnav's detector",
        OTHER_DETECTOR,
        note="adaptive-shoe in place of the paper's detector",
    ),
)
INS = Approach("INS alone", UNAIDED, note="the paper shows that it diverges")

_NORTH = Route.through([(0.0, 0.0), (0.0, NORTH)])
_SQUARE = Route.through([(0.0, 0.0), (0.0, SIDE), (SIDE, SIDE), (SIDE, 0.0), (0.0, 0.0)])


def experiments() -> tuple[Experiment, ...]:
    """Return the paper's walks, with a sensor that was calibrated and one that was not."""
    walks = (
        ("19 m north", _NORTH, NORTH, APPROACHES),
        ("17 m square", _SQUARE, 4 * SIDE, (*APPROACHES, INS)),
    )
    sensors = (
        (
            "calibrated",
            CALIBRATED,
            "biases of the paper's stabilities, scale and misalignment of 0.1 %",
        ),
        (
            "uncalibrated",
            UNCALIBRATED,
            "biases of 20 mg and 1 deg/s, scale 1 %, misalignment 0.7 %",
        ),
    )
    return tuple(
        Experiment(
            "P1",
            f"{title}, {state} sensor",
            Simulated(route, GAIT, sensor, RATE_HZ),
            approaches,
            distance=distance,
            unit="%",
            note=note,
        )
        for state, sensor, note in sensors
        for title, route, distance, approaches in walks
    )
