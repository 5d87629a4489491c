"""P3: Abdulrahim, Moore, Hide, Hill, on zero velocity updates in MEMS-based navigation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from footnav.config import Config, Correction, Sensor, Smoother
from footnav.detectors import MagnitudeDebounced
from footnav.errors import DataError
from footnav.recording import Recording
from footnav.sections import CorrectionKind
from footnav.simulation import Route, SensorErrors, TriadErrors, Waypoint
from papers.experiment import (
    ZUPT_ALONE,
    Approach,
    Experiment,
    Simulated,
    Walk,
    armse,
    gait_at,
    standing,
)

RATE_HZ = 100.0
SPEED = 1.0
"""m/s: the six minutes of the paper."""
REST = 2.0
"""Rest that the start is levelled on, s."""

G = 9.80665
GYRO_RANGE = math.radians(300)
ACCEL_RANGE = 5 * G

MISALIGNMENT = math.radians(0.2)
CLIPPING = SensorErrors(
    accel=TriadErrors(
        bias_std=5e-3 * G,
        bias_walk=1e-4,
        noise_density=0.4e-3 * G,
        scale_std=2e-3,
        misalignment_std=MISALIGNMENT,
        range=ACCEL_RANGE,
    ),
    gyro=TriadErrors(
        bias_std=math.radians(0.35),
        bias_walk=1e-5,
        noise_density=math.radians(3.5) / 60,
        scale_std=2e-3,
        misalignment_std=MISALIGNMENT,
        range=GYRO_RANGE,
    ),
)
"""A sensor of the 3DM-GX1's class: 3.5 deg/√h, 0.4 mg/√Hz, biases of 0.35 deg/s and 5 mg, scale 0.2
%.
"""
WIDE = CLIPPING.replace(
    accel=CLIPPING.accel.replace(range=None), gyro=CLIPPING.gyro.replace(range=None)
)

FLOORS, RISERS, RISER, TREAD = 4, 20, 0.17, 0.29
"""Flights, risers in a flight, and height and depth of each, m."""
LOOP = (80.0, 43.0)
"""Length and width of the loop on the top floor, m."""
TO_LIFT = 3.0
"""From the end of the loop to the lift, m."""

SIX = (("DR", "dr"), ("KF", "kf"))
"""Names of the filters of the six approaches, and their kinds."""
CORRECTIONS: tuple[tuple[str, CorrectionKind], ...] = (
    ("", "none"),
    ("+LWI", "lwi"),
    ("+RV", "rv"),
)
"""Names of the corrections, and their kinds."""

TABLE_1 = {"DR": 3148.0, "DR+LWI": 25.84, "DR+RV": 6.16, "KF": 2.04, "KF+LWI": 1.89, "KF+RV": 1.81}
"""Closing errors of the six approaches, m."""

KNOWN = ", ranges known"
"""Added to the name of an approach whose filter knows which samples are clipped."""

BASE = Config(
    sensor=Sensor(
        gyro_noise_density=CLIPPING.gyro.noise_density,
        accel_noise_density=CLIPPING.accel.noise_density,
        gyro_bias_std=math.radians(0.7),
        accel_bias_std=0.01 * G,
    ),
    alignment=standing(REST),
    detector=MagnitudeDebounced(),
    filter=ZUPT_ALONE,
)
SMOOTHED = BASE.replace(smoother=Smoother(kind="rts"))
STEPWISE = BASE.replace(smoother=Smoother(kind="stepwise"))


def _six(paper: dict[str, float]) -> tuple[Approach, ...]:
    """Return the six approaches of table I, with a filter that does not know of the clipping."""
    return tuple(
        Approach(
            name + suffix,
            BASE.replace(
                filter=BASE.filter.replace(kind=kind), correction=Correction(kind=correction)
            ),
            paper=paper.get(name + suffix),
            ranges_known=False,
        )
        for name, kind in SIX
        for suffix, correction in CORRECTIONS
    )


def _all(paper: dict[str, float]) -> tuple[Approach, ...]:
    six = _six(paper)
    known = tuple(
        Approach(one.name + KNOWN, one.config) for one in six if one.config.filter.kind == "kf"
    )
    return six + known


SMOOTHERS = (
    Approach("KF" + KNOWN, BASE),
    Approach("KF, step-wise" + KNOWN, STEPWISE),
    Approach("KF, smoothed" + KNOWN, SMOOTHED, note="the paper's reference"),
)


def indoors() -> Route:
    """Return the route up four floors by stairs, around a loop, down by lift, and to the start."""
    stairs = Route.stairs(FLOORS, RISERS, RISER, TREAD).waypoints
    x, y, top = stairs[-1].position
    length, width = LOOP
    corners = [(x - length, y), (x - length, y + width), (x, y + width), (x, y), (x, y + TO_LIFT)]
    upstairs = [Waypoint(position=(*corner, top)) for corner in corners]
    lift = Waypoint(position=(x, y + TO_LIFT, 0.0), lift=True)
    return Route(waypoints=(*stairs, *upstairs, lift, stairs[0]))


def experiments() -> tuple[Experiment, ...]:
    """Return the indoor route, clipped as by the paper's sensor, and with sufficient ranges."""
    gait = gait_at(SPEED, rest_before=REST + 1.0)
    clipped, wide = (Simulated(indoors(), gait, sensor, RATE_HZ) for sensor in (CLIPPING, WIDE))
    length = _length(indoors())
    title = "four floors, loop, lift"
    return (
        Experiment(
            "P3", f"{title}, clipped", clipped, _all(TABLE_1), length, note="300 deg/s and 5 g"
        ),
        Experiment(
            "P3", f"{title}, not clipped", wide, _six({}), length, note="ranges that hold the foot"
        ),
        Experiment(
            "P3",
            f"{title}, along the way",
            clipped,
            SMOOTHERS,
            length,
            measure=armse,
            note="ARMSE; 300 deg/s and 5 g",
        ),
    )


def recorded(data: Path) -> tuple[Experiment, ...]:
    """Return the real recordings, clipped as by the paper's sensor.

    Parameters
    ----------
    data : Path
        Folder with the folders ``openshoe`` (closed walks) and ``vicon`` (walks under motion
        capture).

    Returns
    -------
    tuple of Experiment
        One for each folder.

    Raises
    ------
    DataError
        A folder has no recordings.
    """
    note = "real recordings, clipped afterwards at 300 deg/s and 5 g"
    openshoe, vicon = (Clipped.of(data / name) for name in ("openshoe", "vicon"))
    return (
        Experiment("P3", "OpenShoe, clipped", openshoe, _all({}), note=note),
        Experiment(
            "P3",
            "vicon, clipped",
            vicon,
            (*_all({}), *SMOOTHERS[1:]),
            measure=armse,
            note=f"ARMSE; {note}",
        ),
    )


@dataclass(frozen=True, slots=True)
class Clipped:
    """Real recordings, clipped at the ranges of the paper's sensor.

    Attributes
    ----------
    files : tuple of Path
        ``.npz`` with t (s), accel (m/s²), gyro (rad/s), and position (m) where the truth is known.
    """

    files: tuple[Path, ...]

    @classmethod
    def of(cls, folder: Path) -> Clipped:
        """Take all recordings in a folder; none is a DataError."""
        files = tuple(sorted(folder.glob("*.npz")))
        if not files:
            raise DataError(f"{folder}: no recordings (*.npz) there")
        return cls(files)

    def count(self, seeds: int) -> int:
        """Return the number of files, however many seeds are asked for."""
        return len(self.files)

    def load(self, number: int) -> Walk:
        """Read one of the files, and clip it."""
        path = self.files[number]
        with np.load(path) as columns:
            recording = Recording(
                columns["t"],
                np.clip(columns["accel"], -ACCEL_RANGE, ACCEL_RANGE),
                np.clip(columns["gyro"], -GYRO_RANGE, GYRO_RANGE),
                name=path.name,
                accel_range=ACCEL_RANGE,
                gyro_range=GYRO_RANGE,
            )
            return Walk(recording, columns.get("position"))


def _length(route: Route) -> float:
    """Horizontal length, m."""
    corners = np.array([waypoint.position[:2] for waypoint in route.waypoints])
    return float(np.linalg.norm(np.diff(corners, axis=0), axis=1).sum())
