"""Foot-mounted inertial navigation: from the IMU on a shoe to the wearer's track.

Examples
--------
>>> import footnav
>>> recording = footnav.read("walk.csv")  # doctest: +SKIP
>>> footnav.track(recording).save("track.geojson")  # doctest: +SKIP
"""

from footnav._core import __version__
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
from footnav.navigator import Navigator, State
from footnav.recording import Recording
from footnav.simulation import Gait, Route, SensorErrors, TriadErrors, Waypoint, simulate
from footnav.stance import StanceDetector
from footnav.tracking import track
from footnav.trajectory import Trajectory

__all__ = [
    "AccelerationMagnitude",
    "AdaptiveShoe",
    "Alignment",
    "AngularRateEnergy",
    "BusyError",
    "Calibration",
    "Config",
    "ConfigError",
    "Correction",
    "DataError",
    "Detection",
    "Diagnosis",
    "Evaluation",
    "Filter",
    "FootnavError",
    "FootnavWarning",
    "Gait",
    "Health",
    "HealthLimits",
    "MagnitudeDebounced",
    "MagnitudeVariance",
    "Mechanization",
    "MovingVariance",
    "Navigator",
    "NumericalError",
    "Output",
    "Reason",
    "Recording",
    "Route",
    "Sensor",
    "SensorErrors",
    "Shoe",
    "Smoother",
    "StanceDetector",
    "State",
    "Status",
    "ThreeCondition",
    "Trajectory",
    "TriadErrors",
    "Waypoint",
    "WindowedEnergies",
    "__version__",
    "detect",
    "diagnose",
    "evaluate",
    "load_config",
    "read",
    "simulate",
    "track",
]
