"""Simulated walks: samples of a sensor on a shoe, and the true track.

The samples are the exact inverse of the mechanization: with an ideal sensor a navigator recovers
the truth to rounding.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from footnav import _core
from footnav.errors import ConfigError
from footnav.recording import Recording
from footnav.sections import MechanizationKind
from footnav.settings import IDENTITY, Matrix, Settings, Vector, decode, encode
from footnav.trajectory import Trajectory

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


class Waypoint(Settings, frozen=True, kw_only=True):
    """One corner of a route.

    Attributes
    ----------
    position : tuple of 3 floats
        Position of the sole, n frame, m.
    tread : bool
        Whether the leg to this point is a single stride onto a tread of stairs; if not, it is
        divided into strides.
    lift : bool
        Whether a lift moves the walker vertically to this point, with the foot at rest.
    """

    position: Vector = (0.0, 0.0, 0.0)
    tread: bool = False
    lift: bool = False


class Route(Settings, frozen=True, kw_only=True):
    """A polyline on the ground; the walker sets out along the first leg.

    Attributes
    ----------
    waypoints : tuple of Waypoint
        The corners in the order of the walk.
    """

    waypoints: tuple[Waypoint, ...]

    @classmethod
    def through(cls, points: ArrayLike) -> Route:
        """Go along straight lines through points of shape (n, 2) or (n, 3), m."""
        array = np.asarray(points, dtype=np.float64)
        if array.ndim != 2 or array.shape[1] not in (2, 3):
            msg = f"a route has points of shape (n, 2) or (n, 3), not {array.shape}"
            raise ConfigError(msg)
        corners = np.zeros((len(array), 3))
        corners[:, : array.shape[1]] = array
        return cls(waypoints=tuple(Waypoint(position=(x, y, z)) for x, y, z in corners.tolist()))

    @classmethod
    def straight(cls, length: float) -> Route:
        """Go straight ahead along x for `length` m."""
        return _route("straight", length)

    @classmethod
    def square(cls, side: float) -> Route:
        """Go once around a square of `side` m, anticlockwise, back to the start."""
        return _route("square", side)

    @classmethod
    def rectangle(cls, length: float, width: float) -> Route:
        """Go once around a rectangle, `length` m along x by `width` m along y, anticlockwise."""
        return _route("rectangle", length, width)

    @classmethod
    def figure_of_eight(cls, length: float) -> Route:
        """Go along two circles that touch at the start, `length` m in all."""
        return _route("figure-of-eight", length)

    @classmethod
    def out_and_back(cls, length: float) -> Route:
        """Go `length` m along x, turn about, and come back to the start."""
        return _route("out-and-back", length)

    @classmethod
    def stairs(
        cls, floors: int, risers: int = 12, riser: float = 0.17, tread: float = 0.29
    ) -> Route:
        """Climb `floors` flights of `risers` each (m high, m deep) with landings.

        A negative `riser` leads down.
        """
        return _route("stairs", floors, risers, riser, tread)


class Gait(Settings, frozen=True, kw_only=True):
    """How the foot that carries the sensor moves; the default is a walk at 1.25 m/s.

    The foot frame has x to the toes, y to the left and z up; its origin is the point of the sole
    below the sensor.

    Attributes
    ----------
    stride_length : float
        Distance from one foothold of this foot to the next, m.
    stride_duration : float
        Time from one heel-off to the next one, s.
    stance_share : float
        Share of the stride from heel strike to toe-off.
    swing_clearance : float
        Lift of the sole in mid-swing in addition to that by the roll of the foot, m.
    heel_off_pitch, heel_strike_pitch : float
        Pitch of the foot at toe-off and at heel strike, rad, toes up positive.
    impact : float
        Peak of the oscillation after heel strike, m/s².
    stance_roll : float
        Inward roll of the foot in stance, rad.
    tremor : float
        Root mean square of the angular rate by which each axis trembles, rad/s.
    sensor_position : tuple of 3 floats
        Place of the sensor in the foot frame, m.
    mounting : tuple of 3 floats
        Rotation vector that turns the foot frame into the sensor frame, rad.
    rest_before, rest_after : float
        Time at rest before the first and after the last stride, s.
    variation : float
        Relative standard deviation from stride to stride.
    sharpest_curve : float
        Change of direction up to which a corner is rounded while walking, rad; sharper ones are
        turned on the spot.
    """

    stride_length: float = 1.35
    stride_duration: float = 1.08
    stance_share: float = 0.6
    swing_clearance: float = 0.04
    heel_off_pitch: float = -1.1
    heel_strike_pitch: float = 0.35
    impact: float = 18.0
    stance_roll: float = 0.03
    tremor: float = 0.01
    sensor_position: Vector = (0.0, 0.0, 0.07)
    mounting: Vector = (0.0, 0.0, 0.0)
    rest_before: float = 3.0
    rest_after: float = 2.0
    variation: float = 0.03
    sharpest_curve: float = 0.9

    @classmethod
    def preset(cls, name: str) -> Gait:
        """Return a known gait: "walk" (1.25 m/s), "slow" (0.6 m/s) or "run" (2.7 m/s).

        Raises
        ------
        ConfigError
            No such gait; the message lists the known ones.
        """
        return decode(_core.gait_preset(name), cls)


class TriadErrors(Settings, frozen=True, kw_only=True):
    """Errors of three orthogonal axes, in the unit u of the sensor (m/s² or rad/s).

    None by default.

    Attributes
    ----------
    bias : tuple of 3 floats
        Bias at the start, u.
    bias_std : float
        Standard deviation of a bias that is drawn for each axis and added to `bias`, u.
    bias_walk : float
        Random walk of the bias, u/√s.
    bias_instability : float
        Bias instability B, u: flicker noise whose Allan deviation has its floor at 0.664 B.
    noise_density : float
        White noise, u/√Hz.
    matrix : tuple of 3 rows
        Scale factors and misalignment.
    scale_std, misalignment_std : float
        Standard deviations of the relative scale errors and of the misalignments (rad) that are
        drawn.
    range : float, optional
        Full scale, u.
    resolution : float
        Least significant bit, u; zero for no rounding.
    """

    bias: Vector = (0.0, 0.0, 0.0)
    bias_std: float = 0.0
    bias_walk: float = 0.0
    bias_instability: float = 0.0
    noise_density: float = 0.0
    matrix: Matrix = IDENTITY
    scale_std: float = 0.0
    misalignment_std: float = 0.0
    range: float | None = None
    resolution: float = 0.0


class SensorErrors(Settings, frozen=True, kw_only=True):
    """Errors of an inertial measurement unit; none by default.

    Attributes
    ----------
    accel, gyro : TriadErrors
        Of the accelerometers, m/s², and of the gyroscopes, rad/s.
    gyro_g_sensitivity_std : float
        Standard deviation of the gyroscopes' sensitivity to specific force that is drawn,
        (rad/s)/(m/s²).
    """

    accel: TriadErrors = TriadErrors()
    gyro: TriadErrors = TriadErrors()
    gyro_g_sensitivity_std: float = 0.0

    @classmethod
    def preset(cls, name: str) -> SensorErrors:
        """Return a known sensor.

        "ideal", "mpu6050", "mti-g710" or "stim300", with the figures of its data sheet.

        Raises
        ------
        ConfigError
            No such sensor; the message lists the known ones.
        """
        return decode(_core.sensor_preset(name), cls)


def simulate(
    path: Route | ArrayLike,
    gait: Gait | str = "walk",
    sensor: SensorErrors | str = "mpu6050",
    seed: int = 0,
    *,
    rate_hz: float = 200.0,
    jitter: float = 0.0,
    gravity: float | None = None,
    mechanization: MechanizationKind = "two-sample",
) -> tuple[Recording, Trajectory]:
    """Walk along a path and record it.

    Parameters
    ----------
    path : Route or array_like of shape (n, 2) or (n, 3)
        The route, in n, m.
    gait : Gait or str
        The gait; a string names a preset.
    sensor : SensorErrors or str
        Sensor errors; a string names a preset.
    seed : int
        The same seed gives the same walk; a change of the sensor does not change the walk.
    rate_hz : float
        Samples per second.
    jitter : float
        Largest deviation of a stamp from its nominal time, in sample intervals.
    gravity : float, optional
        m/s²; the default is that of ``Config()``.
    mechanization : {"two-sample", "single-sample", "first-order"}
        The mechanization of which the samples are the exact inverse.

    Returns
    -------
    recording : Recording
        Readings of the sensor.
    truth : Trajectory
        Position, velocity, attitude and biases at each sample, and the stances, on ground that is
        at rest.

    Raises
    ------
    ConfigError
        A parameter is out of range; the message names it.
    """
    route = path if isinstance(path, Route) else Route.through(path)
    sensor = SensorErrors.preset(sensor) if isinstance(sensor, str) else sensor
    settings = {
        "rate_hz": rate_hz,
        "jitter": jitter,
        "seed": seed,
        "kind": mechanization,
        "gravity": gravity,
    }
    plan = {
        "route": route,
        "gait": Gait.preset(gait) if isinstance(gait, str) else gait,
        "sensor": sensor,
        "settings": {key: value for key, value in settings.items() if value is not None},
    }
    columns = _core.simulate(encode(plan))
    name = f"simulated {seed}"
    recording = Recording(
        columns["t"],
        columns["accel"],
        columns["gyro"],
        name=name,
        accel_range=sensor.accel.range,
        gyro_range=sensor.gyro.range,
    )
    truth = Trajectory(
        t=columns["t"],
        position=columns["position"],
        velocity=columns["velocity"],
        quaternion=columns["quaternion"],
        zero_velocity=columns["stance"],
        position_std=np.zeros_like(columns["position"]),
        gyro_bias=columns["gyro_bias"],
        accel_bias=columns["accel_bias"],
        flags=np.zeros(len(columns["t"]), dtype=np.uint16),
        name=f"truth of {name}",
    )
    return recording, truth


def simulate_rest(
    duration: float,
    sensor: SensorErrors | str = "mpu6050",
    seed: int = 0,
    *,
    rate_hz: float = 200.0,
    gravity: float | None = None,
) -> Recording:
    """Simulate a sensor at rest on a table, its z axis up.

    Parameters
    ----------
    duration : float
        How long, s.
    sensor : SensorErrors or str
        Sensor errors; a string names a preset.
    seed : int
        The same seed gives the same sensor and the same noise.
    rate_hz : float
        Samples per second.
    gravity : float, optional
        m/s²; the default is that of ``Config()``.

    Returns
    -------
    Recording
        Readings of the sensor.

    Raises
    ------
    ConfigError
        A parameter is out of range; the message names it.
    """
    sensor = SensorErrors.preset(sensor) if isinstance(sensor, str) else sensor
    settings = {"rate_hz": rate_hz, "seed": seed} | (
        {} if gravity is None else {"gravity": gravity}
    )
    columns = _core.simulate_rest(
        encode({"duration": duration, "sensor": sensor, "settings": settings})
    )
    return Recording(
        **columns,
        name=f"simulated {seed}",
        accel_range=sensor.accel.range,
        gyro_range=sensor.gyro.range,
    )


def _route(shape: str, *sizes: float) -> Route:
    if not np.all(np.isfinite(sizes)):
        msg = f"route {shape!r} with sizes {sizes}: expected finite numbers"
        raise ConfigError(msg)
    return decode(_core.route(shape, [float(size) for size in sizes]), Route)
