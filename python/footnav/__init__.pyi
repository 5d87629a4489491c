from ._core import __version__
from .allan import AllanDeviation, allan
from .calibration import SensorCalibration, load_calibration
from .config import (
    Alignment,
    Calibration,
    Config,
    Correction,
    Filter,
    HealthLimits,
    Magnetometer,
    Mechanization,
    Output,
    Sensor,
    Smoother,
    load_config,
)
from .detection import Detection, detect
from .detectors import (
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
from .diagnosis import Diagnosis, diagnose
from .errors import BusyError, ConfigError, DataError, FootnavError, FootnavWarning, NumericalError
from .evaluation import Evaluation, evaluate
from .health import Flag, Health, Status
from .io import read
from .many import Outcome, track_many
from .navigator import Navigator, State
from .noise import AxisNoise, Figure, NoiseFigures
from .protocols import StanceDetector
from .recording import Recording
from .simulation import Gait, Route, SensorErrors, TriadErrors, Waypoint, simulate, simulate_rest
from .strides import Stride, Strides
from .tracking import track
from .trajectory import Trajectory

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
    "Flag",
    "FootnavError",
    "FootnavWarning",
    "Gait",
    "GraphTheoretic",
    "Health",
    "HealthLimits",
    "Magnetometer",
    "MagnitudeDebounced",
    "MagnitudeVariance",
    "Mechanization",
    "MovingVariance",
    "Navigator",
    "NoiseFigures",
    "NumericalError",
    "Outcome",
    "Output",
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
    "Stride",
    "Strides",
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
