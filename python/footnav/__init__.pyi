from . import (
    calibration,
    capture,
    config,
    detection,
    detectors,
    diagnosis,
    errors,
    evaluation,
    export,
    health,
    io,
    many,
    mpu6050,
    navigator,
    noise,
    noise_preconditions,
    plot,
    protocols,
    recording,
    rest_detection,
    simulation,
    strides,
    summary,
    tracking,
    trajectory,
)
from ._core import __version__
from .allan import allan
from .calibration import load_calibration
from .config import Config, load_config
from .detection import detect
from .diagnosis import diagnose
from .errors import BusyError, ConfigError, DataError, FootnavError, FootnavWarning, NumericalError
from .evaluation import evaluate
from .health import Health
from .io import read
from .many import track_many
from .navigator import Navigator
from .recording import Recording
from .simulation import simulate, simulate_rest
from .strides import Strides
from .tracking import track
from .trajectory import Trajectory, load_trajectory

__all__ = [
    "BusyError",
    "Config",
    "ConfigError",
    "DataError",
    "FootnavError",
    "FootnavWarning",
    "Health",
    "Navigator",
    "NumericalError",
    "Recording",
    "Strides",
    "Trajectory",
    "__version__",
    "allan",
    "calibration",
    "capture",
    "config",
    "detect",
    "detection",
    "detectors",
    "diagnose",
    "diagnosis",
    "errors",
    "evaluate",
    "evaluation",
    "export",
    "health",
    "io",
    "load_calibration",
    "load_config",
    "load_trajectory",
    "many",
    "mpu6050",
    "navigator",
    "noise",
    "noise_preconditions",
    "plot",
    "protocols",
    "read",
    "recording",
    "rest_detection",
    "simulate",
    "simulate_rest",
    "simulation",
    "strides",
    "summary",
    "track",
    "track_many",
    "tracking",
    "trajectory",
]
