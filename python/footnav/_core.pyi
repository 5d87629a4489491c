from collections.abc import Callable
from typing import Any, final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import Self, disjoint_base

from footnav.protocols import StanceDetector

__all__ = [
    "Batch",
    "Columns",
    "Navigator",
    "RestDetector",
    "__version__",
    "alignment_rest_limits",
    "allan",
    "calibrate",
    "calibration_at",
    "check_config",
    "corrupt",
    "default_config",
    "detect",
    "gait_preset",
    "gravity",
    "live_detector",
    "preset_config",
    "preset_names",
    "route",
    "sample_flags",
    "sensor_preset",
    "settings_schema",
    "simulate",
    "simulate_rest",
    "stances",
    "strides",
]

__version__: str

@final
class Batch:
    def __new__(
        cls,
        config: bytes,
        rate_hz: float,
        detector: StanceDetector | None = None,
        stationary: list[bool] | None = None,
    ) -> Self: ...
    def push_block(
        self,
        t: NDArray[np.float64],
        accel: NDArray[np.float64],
        gyro: NDArray[np.float64],
        mag: NDArray[np.float64] | None = None,
    ) -> None: ...
    def finish(
        self, progress: Callable[[], object]
    ) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any] | None]: ...

@final
class Columns:
    def __getitem__(self, name: str, /) -> NDArray[Any]: ...
    def health(self) -> dict[str, Any]: ...

@disjoint_base
class Navigator:
    def __new__(
        cls, config: bytes, rate_hz: float, detector: StanceDetector | None = None
    ) -> Self: ...
    def push(
        self, t: float, ax: float, ay: float, az: float, gx: float, gy: float, gz: float
    ) -> bool: ...
    def _push_columns(
        self,
        t: ArrayLike,
        accel: ArrayLike,
        gyro: ArrayLike,
        mag: NDArray[np.float64] | None = None,
    ) -> Columns | None: ...
    def _flush_columns(self) -> Columns: ...
    def _stride_columns(self) -> dict[str, Any]: ...
    def reset(self) -> None: ...
    def _state_now(self) -> dict[str, Any] | None: ...
    def _health_fields(self, of_walk: bool) -> dict[str, Any]: ...
    @property
    def latency(self) -> int: ...
    @property
    def t(self) -> float | None: ...
    @property
    def position(self) -> NDArray[np.float64] | None: ...
    @property
    def velocity(self) -> NDArray[np.float64] | None: ...
    @property
    def quaternion(self) -> NDArray[np.float64] | None: ...
    @property
    def gyro_bias(self) -> NDArray[np.float64] | None: ...
    @property
    def accel_bias(self) -> NDArray[np.float64] | None: ...
    @property
    def zero_velocity(self) -> bool | None: ...
    @property
    def covariance(self) -> NDArray[np.float64] | None: ...

@final
class RestDetector:
    def __new__(cls, limits: dict[str, float], rate_hz: float) -> Self: ...
    def push_block(
        self, t: NDArray[np.float64], accel: NDArray[np.float64], gyro: NDArray[np.float64]
    ) -> dict[str, NDArray[Any]]: ...
    def finish(self) -> dict[str, NDArray[Any]]: ...

def alignment_rest_limits(config: bytes) -> dict[str, float]: ...
def sample_flags(
    config: bytes,
    rate_hz: float,
    t: NDArray[np.float64],
    accel: NDArray[np.float64],
    gyro: NDArray[np.float64],
) -> NDArray[np.uint16]: ...
def default_config() -> str: ...
def live_detector() -> str: ...
def preset_config(name: str) -> str: ...
def preset_names() -> list[str]: ...
def settings_schema() -> str: ...
def check_config(config: bytes) -> None: ...
def gravity(config: bytes) -> float: ...
def detect(
    config: bytes,
    rate_hz: float,
    t: NDArray[np.float64],
    accel: NDArray[np.float64],
    gyro: NDArray[np.float64],
    detector: StanceDetector | None = None,
) -> dict[str, NDArray[Any]]: ...
def allan(
    samples: NDArray[np.float64], progress: Callable[[float], object]
) -> dict[str, NDArray[Any]]: ...
def calibrate(
    calibration: bytes, raw: NDArray[np.float64], temperature: NDArray[np.float64] | None = None
) -> NDArray[np.float64]: ...
def calibration_at(calibration: bytes, temperature: float | None = None) -> str: ...
def corrupt(
    sensor: bytes,
    seed: int,
    t: NDArray[np.float64],
    accel: NDArray[np.float64],
    gyro: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...
def stances(
    t: NDArray[np.float64], zero_velocity: NDArray[np.bool_]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]: ...
def strides(
    t: NDArray[np.float64],
    position: NDArray[np.float64],
    quaternion: NDArray[np.float64],
    zero_velocity: NDArray[np.bool_],
) -> dict[str, Any]: ...
def simulate(plan: bytes) -> dict[str, NDArray[Any]]: ...
def simulate_rest(plan: bytes) -> dict[str, NDArray[Any]]: ...
def gait_preset(name: str) -> str: ...
def sensor_preset(name: str) -> str: ...
def route(shape: str, sizes: list[float]) -> str: ...
