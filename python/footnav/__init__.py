"""Foot-mounted inertial navigation: from the IMU on a shoe to the wearer's track.

Examples
--------
>>> import footnav
>>> recording = footnav.read("walk.csv")  # doctest: +SKIP
>>> footnav.track(recording).save("track.geojson")  # doctest: +SKIP
"""

from footnav._core import __version__
from footnav.allan import AllanDeviation, allan
from footnav.calibration import SensorCalibration, load_calibration
from footnav.config import (
    Alignment,
    Calibration,
    Config,
    Correction,
    Filter,
    HealthLimits,
    Mechanization,
    Output,
    Sensor,
    Smoother,
    load_config,
)
from footnav.detection import Detection, detect
from footnav.detectors import (
    AccelerationMagnitude,
    AdaptiveShoe,
    AngularRateEnergy,
    GraphTheoretic,
    MagnitudeDebounced,
    MagnitudeVariance,
    MovingVariance,
    Shoe,
    ThreeCondition,
    WindowedEnergies,
)
from footnav.diagnosis import Diagnosis, diagnose
from footnav.errors import BusyError, ConfigError, DataError, FootnavError, FootnavWarning, NumericalError
from footnav.evaluation import Evaluation, evaluate
from footnav.health import Health, Reason, Status
from footnav.io import read
from footnav.many import Outcome, track_many
from footnav.navigator import Navigator, State
from footnav.noise import AxisNoise, Figure, NoiseFigures
from footnav.recording import Recording
from footnav.simulation import Gait, Route, SensorErrors, TriadErrors, Waypoint, simulate, simulate_rest
from footnav.stance import StanceDetector
from footnav.steps import Steps, Stride
from footnav.tracking import track
from footnav.trajectory import Trajectory

__all__ = [
    "AccelerationMagnitude",
    "AdaptiveShoe",
    "Alignment",
    "AllanDeviation",
    "AngularRateEnergy",
    "AxisNoise",
    "BusyError",
    "Calibration",
    "Config",
    "ConfigError",
    "Correction",
    "DataError",
    "Detection",
    "Diagnosis",
    "Evaluation",
    "Figure",
    "Filter",
    "FootnavError",
    "FootnavWarning",
    "Gait",
    "GraphTheoretic",
    "Health",
    "HealthLimits",
    "MagnitudeDebounced",
    "MagnitudeVariance",
    "Mechanization",
    "MovingVariance",
    "Navigator",
    "NoiseFigures",
    "NumericalError",
    "Outcome",
    "Output",
    "Reason",
    "Recording",
    "Route",
    "Sensor",
    "SensorCalibration",
    "SensorErrors",
    "Shoe",
    "Smoother",
    "StanceDetector",
    "State",
    "Status",
    "Steps",
    "Stride",
    "ThreeCondition",
    "Trajectory",
    "TriadErrors",
    "Waypoint",
    "WindowedEnergies",
    "__version__",
    "allan",
    "detect",
    "diagnose",
    "evaluate",
    "load_calibration",
    "load_config",
    "read",
    "simulate",
    "simulate_rest",
    "track",
    "track_many",
]
