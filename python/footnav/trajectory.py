"""The track of the shoe and its summary."""

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footnav import _core
from footnav.errors import ConfigError, DataError
from footnav.health import Health
from footnav.steps import Steps, find_stances, find_steps

Floats = NDArray[np.float64]
Origin = tuple[float, float, float]

FRAMES = ("enu", "ned")

_COLUMNS: dict[str, tuple[tuple[int, ...], type]] = {
    "t": ((), np.float64),
    "position": ((3,), np.float64),
    "velocity": ((3,), np.float64),
    "quaternion": ((4,), np.float64),
    "zero_velocity": ((), np.bool_),
    "position_std": ((3,), np.float64),
    "gyro_bias": ((3,), np.float64),
    "accel_bias": ((3,), np.float64),
    "flags": ((), np.uint16),
}


_DEFAULTS: dict[str, Any] = {
    "health": None,
    "name": "",
    "origin": None,
    "frame": "enu",
    "heading_known": True,
    "filter_steps": None,
}


@dataclass(frozen=True, slots=True)
class Displacement:
    """The way from one point to another.

    Attributes
    ----------
    horizontal : float
        Length in the horizontal plane, m.
    vertical : float
        Climb, m, positive upwards.
    """

    horizontal: float
    vertical: float

    @classmethod
    def of(cls, vector: Floats) -> "Displacement":
        """Take the parts of a vector (3,) in the navigation frame, m."""
        return cls(float(np.hypot(vector[0], vector[1])), float(vector[2]))

    @property
    def spatial(self) -> float:
        """Length in space, m."""
        return float(np.hypot(self.horizontal, self.vertical))

    def percent_of(self, distance: float) -> "Displacement":
        """Relate the parts to a distance in m; nan where the distance is zero."""
        factor = 100 / distance if distance > 0 else np.nan
        return Displacement(self.horizontal * factor, self.vertical * factor)


@dataclass(frozen=True, slots=True)
class Summary:
    """A track in a few numbers; what the track is too short to tell is nan.

    Attributes
    ----------
    name : str
        Name of the track.
    samples : int
        Number of samples.
    duration : float
        From the first to the last sample, s.
    rate_hz : float
        One over the median positive interval, Hz.
    distance : float
        Horizontal length of the strides, m.
    closing, closing_percent : Displacement
        From the first to the last sample, in m and in percent of the distance.
    lowest, highest : float
        Heights at which the foot stood, m.
    strides : int
        Strides of this foot.
    stride_length : float
        Mean horizontal length, m.
    cadence : float
        Strides of this foot in a minute of walking.
    zero_velocity_share : float
        Share of the samples at rest, 0 to 1.
    greatest_speed : float
        m/s.
    horizontal_std, vertical_std : float
        Uncertainty of the last position, one sigma, m; horizontally the root of the sum of both
        variances.
    health : Health or None
        Health of the run.
    """

    name: str
    samples: int
    duration: float
    rate_hz: float
    distance: float
    closing: Displacement
    closing_percent: Displacement
    lowest: float
    highest: float
    strides: int
    stride_length: float
    cadence: float
    zero_velocity_share: float
    greatest_speed: float
    horizontal_std: float
    vertical_std: float
    health: Health | None

    def __str__(self) -> str:
        """Write the summary as a small table."""
        way, share = self.closing, self.closing_percent
        lines = [
            f"{self.name or 'track'}: {self.samples:,} samples, {self.duration:.2f} s at {self.rate_hz:.1f} Hz",
            f"  distance       {self.distance:.2f} m in {self.strides} strides, "
            f"{self.stride_length:.2f} m each, {self.cadence:.1f} a minute",
            f"  start to end   {way.horizontal:.3f} m ({share.horizontal:.2f} %) horizontal, "
            f"{way.vertical:+.3f} m ({share.vertical:+.2f} %) vertical, "
            f"{way.spatial:.3f} m ({share.spatial:.2f} %) in space",
            f"  heights        {self.lowest:.2f} m to {self.highest:.2f} m where the foot stood",
            f"  zero velocity  {100 * self.zero_velocity_share:.1f} % of the samples",
            f"  greatest speed {self.greatest_speed:.2f} m/s",
            f"  one sigma      {self.horizontal_std:.3f} m horizontal, {self.vertical_std:.3f} m vertical, at the end",
        ]
        if self.health is not None:
            lines.append(f"  health         {self.health}")
        return "\n".join(lines)


class _OfBlock:
    """What the core found for a block, of which Python makes what is asked for: most blocks are asked for little."""

    __slots__ = ("_found",)

    _found: tuple[_core.Columns, dict[str, Any]]

    def __getattr__(self, name: str) -> Any:
        """Make an attribute that is asked for the first time."""
        if name not in _COLUMNS and name not in _DEFAULTS:
            raise AttributeError(
                f"{type(self).__name__!r} object has no attribute {name!r}", name=name, obj=self
            )
        columns, known = self._found
        value: Any
        if name in _COLUMNS:
            value = columns[name]
            value.setflags(write=False)
        elif name == "health":
            value = Health.of_fields(columns.health())
        else:
            value = known.get(name, _DEFAULTS[name])
        object.__setattr__(self, name, value)
        return value


_set_found: Callable[["Trajectory", tuple[_core.Columns, dict[str, Any]]], None] = vars(_OfBlock)[
    "_found"
].__set__
"""Sets it although a track is frozen; `object.__setattr__` would look for its name first, at each block."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Trajectory(_OfBlock):
    """States of the shoe, one row for each sample; n may be zero.

    The arrays are read-only; an array that comes in writable is copied.

    Attributes
    ----------
    t : (n,) ndarray
        Stamps, s, never going back.
    position, velocity : (n, 3) ndarray
        Navigation frame (x, y horizontal, z up; east-north-up when the heading is known), m and
        m/s.
    quaternion : (n, 4) ndarray
        Rotation from the sensor to the navigation frame, xyzw.
    zero_velocity : (n,) ndarray of bool
        True where the foot is at rest.
    position_std : (n, 3) ndarray
        One sigma, m.
    gyro_bias, accel_bias : (n, 3) ndarray
        Sensor frame, rad/s and m/s^2.
    flags : (n,) ndarray of uint16
        Bits of `footnav.health.Flag`.
    health : Health or None
        Health of the whole run.
    name : str
        Name that messages and files carry.
    origin : (latitude, longitude, height) or None
        Where the navigation frame's origin is, in degrees and m (WGS-84).
    frame : {"enu", "ned"}
        Frame in which tables are written; the arrays here always have z up.
    heading_known : bool
        Whether x is east; if not, it is where the foot pointed at the start.
    filter_steps : Steps or None
        Strides as the filter found them, with their covariance, where the settings ask for them
        (``output.strides``). Those of a smoothed or corrected track go from row to row like all
        others; their covariance is that of the filter alone, and so conservative.

    Raises
    ------
    DataError
        For an array of the wrong shape or kind, stamps that go back or are not finite, or strides
        of another track.
    ConfigError
        For an impossible origin or an unknown frame.
    """

    t: Floats
    position: Floats
    velocity: Floats
    quaternion: Floats
    zero_velocity: NDArray[np.bool_]
    position_std: Floats
    gyro_bias: Floats
    accel_bias: Floats
    flags: NDArray[np.uint16]
    health: Health | None = None
    name: str = field(default="", kw_only=True)
    origin: Origin | None = field(default=None, kw_only=True)
    frame: str = field(default="enu", kw_only=True)
    heading_known: bool = field(default=True, kw_only=True)
    filter_steps: Steps | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Check everything and freeze the arrays."""
        label = f"{self.name}: " if self.name else ""
        for column, (_, dtype) in _COLUMNS.items():
            object.__setattr__(
                self, column, _frozen_array(label + column, getattr(self, column), dtype)
            )
        for column, (width, _) in _COLUMNS.items():
            _check_shape(label + column, getattr(self, column), (len(self.t), *width))
        _check_time(label, self.t)
        if self.origin is not None:
            object.__setattr__(self, "origin", check_origin(self.origin))
        check_frame(self.frame)
        if self.filter_steps is not None:
            _check_steps(label, self.filter_steps, self.t, self.position)

    @classmethod
    def of_core(cls, columns: dict[str, NDArray[Any]], **fields: Any) -> "Trajectory":
        """Take over the columns of the core, which are right by construction: nothing is checked or copied.

        Parameters
        ----------
        columns : dict of str to ndarray
            One array for each column, which nobody else holds.
        **fields
            The other attributes; the defaults are those of the constructor.

        Returns
        -------
        Trajectory
            With the very same arrays, read-only from now on.
        """
        track = object.__new__(cls)
        for array in columns.values():
            array.setflags(write=False)
        for name, value in {**_DEFAULTS, **columns, **fields}.items():
            object.__setattr__(track, name, value)
        return track

    @classmethod
    def of_block(cls, columns: _core.Columns, known: dict[str, Any]) -> "Trajectory":
        """Take over what the core found for a block: nothing is checked, and arrays are made when they are asked for.

        Parameters
        ----------
        columns : _core.Columns
            States and health.
        known : dict of str to object
            Of the other attributes those that differ from the constructor's defaults.

        Returns
        -------
        Trajectory
            Read-only.
        """
        track = object.__new__(cls)
        _set_found(track, (columns, known))
        return track

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by way of the constructor, so that the arrays stay read-only."""
        return _rebuild, ({f.name: getattr(self, f.name) for f in dataclasses.fields(self)},)

    def __len__(self) -> int:
        """Count the samples."""
        return len(self.t)

    def __repr__(self) -> str:
        """Describe the track in one line."""
        name = f" {self.name!r}" if self.name else ""
        if len(self) == 0:
            return f"<Trajectory{name}: empty>"
        x, y, z = self.position[-1]
        return (
            f"<Trajectory{name}: {len(self):,} samples, {self.t[-1] - self.t[0]:.2f} s, {self.distance:.2f} m walked, "
            f"end at ({x:.2f}, {y:.2f}, {z:.2f}) m>"
        )

    def __getitem__(self, part: slice) -> "Trajectory":
        """Cut out samples; the part has no health and no strides of the filter, which belong to the whole run.

        Raises
        ------
        TypeError
            For anything but a slice.
        """
        if not isinstance(part, slice):
            raise TypeError(f"a Trajectory is cut by a slice such as traj[10:20], not by {part!r}")
        columns: dict[str, Any] = {column: getattr(self, column)[part] for column in _COLUMNS}
        return dataclasses.replace(self, **columns, health=None, filter_steps=None)

    @staticmethod
    def concatenate(parts: "Sequence[Trajectory]") -> "Trajectory":
        """Join parts that follow each other, such as the blocks of a stream.

        Parameters
        ----------
        parts : sequence of Trajectory
            In the order of time, with one and the same origin and frame.

        Returns
        -------
        Trajectory
            With the name of the first part and the health of the last, and no strides of the
            filter.

        Raises
        ------
        DataError
            For no parts, parts that differ in origin, frame or heading_known, or time that goes
            back between them.
        """
        if not parts:
            raise DataError("there are no parts to join: at least one is needed")
        for number, part in enumerate(parts[1:], start=1):
            if part.heading_known != parts[0].heading_known:
                raise DataError(
                    f"part {number} differs from part 0 in whether the heading is known: not one track"
                )
            if (part.origin, part.frame) != (parts[0].origin, parts[0].frame):
                raise DataError(
                    f"part {number} has origin {part.origin} and frame {part.frame!r}, "
                    f"part 0 has {parts[0].origin} and {parts[0].frame!r}: parts of one track share both"
                )
        columns: dict[str, Any] = {
            column: np.concatenate([getattr(part, column) for part in parts]) for column in _COLUMNS
        }
        return dataclasses.replace(parts[0], **columns, health=parts[-1].health, filter_steps=None)

    @property
    def steps(self) -> Steps:
        """Strides of this foot: those of the filter, or computed anew at each access, without covariance."""
        if self.filter_steps is not None:
            return self.filter_steps
        return find_steps(self.t, self.position, self.quaternion, self.zero_velocity)

    @property
    def distance(self) -> float:
        """Distance walked, m: the sum of the horizontal lengths of the strides."""
        return float(self.steps.length.sum())

    def summary(self) -> Summary:
        """Sum the track up.

        Returns
        -------
        Summary
            Prints as a small table.
        """
        steps = self.steps
        distance = float(steps.length.sum())
        closing = (
            Displacement.of(self.position[-1] - self.position[0])
            if len(self)
            else Displacement(np.nan, np.nan)
        )
        lowest, highest = self._standing_heights()
        east_std, north_std, up_std = self.position_std[-1] if len(self) else np.full(3, np.nan)
        return Summary(
            name=self.name,
            samples=len(self),
            duration=float(self.t[-1] - self.t[0]) if len(self) else 0.0,
            rate_hz=_rate_hz(self.t),
            distance=distance,
            closing=closing,
            closing_percent=closing.percent_of(distance),
            lowest=lowest,
            highest=highest,
            strides=len(steps),
            stride_length=_mean(steps.length),
            cadence=60 / _mean(steps.duration),
            zero_velocity_share=_mean(self.zero_velocity),
            greatest_speed=float(np.linalg.norm(self.velocity, axis=1).max())
            if len(self)
            else np.nan,
            horizontal_std=float(np.hypot(east_std, north_std)),
            vertical_std=float(up_std),
            health=self.health,
        )

    def geodetic(self, origin: Sequence[float] | None = None) -> Floats:
        """Place the track on Earth.

        Parameters
        ----------
        origin : (latitude, longitude, height), optional
            Degrees and m (WGS-84); that of the track unless given.

        Returns
        -------
        (n, 3) ndarray
            Latitude and longitude in degrees and ellipsoidal height in m.

        Raises
        ------
        ConfigError
            For an impossible origin, or none at all.

        Warns
        -----
        FootnavWarning
            When the heading at the start is not known, and x may not be east.
        """
        from footnav.export.geographic import place, warn_of_heading

        where = self.origin if origin is None else check_origin(origin)
        if where is None:
            raise ConfigError(
                "the track has no origin: set output.origin in the configuration, "
                "or geodetic((latitude, longitude, height))"
            )
        warn_of_heading(self, stacklevel=2)
        return place(self.position, where)

    def save(self, path: str | PathLike[str], **options: Any) -> None:
        """Write the track to a file whose suffix names the format; see `footnav.export.save`."""
        from footnav.export import save

        save(self, path, **options)

    def _standing_heights(self) -> tuple[float, float]:
        """Lowest and highest place of a stance."""
        first, last = find_stances(self.t, self.zero_velocity)
        heights = self.position[(first + last) // 2, 2]
        return (float(heights.min()), float(heights.max())) if heights.size else (np.nan, np.nan)


def check_origin(origin: Sequence[float]) -> Origin:
    """Make sure that an origin is a place on Earth.

    Parameters
    ----------
    origin : (latitude, longitude, height)
        Degrees, degrees and m (WGS-84).

    Returns
    -------
    (latitude, longitude, height)
        As floats.

    Raises
    ------
    ConfigError
        For anything but three finite numbers within -90..90 and -180..180.
    """
    try:
        latitude, longitude, height = (float(number) for number in origin)
    except (TypeError, ValueError):
        raise ConfigError(
            f"origin is {origin!r}: expected (latitude, longitude, height) in degrees and m"
        ) from None
    if not abs(latitude) <= 90:
        raise ConfigError(f"origin: latitude is {latitude}, expected -90 to 90 degrees")
    if not abs(longitude) <= 180:
        raise ConfigError(f"origin: longitude is {longitude}, expected -180 to 180 degrees")
    if not np.isfinite(height):
        raise ConfigError(f"origin: height is {height}, expected a number in m")
    return latitude, longitude, height


def check_frame(frame: str) -> None:
    """Raise ConfigError for a frame other than "enu" and "ned"."""
    if frame not in FRAMES:
        raise ConfigError(f"frame is {frame!r}: expected 'enu' or 'ned'")


def _rebuild(fields: dict[str, Any]) -> Trajectory:
    return Trajectory(**fields)


def _frozen_array(label: str, value: ArrayLike, dtype: type) -> NDArray[Any]:
    """Read-only array of the type, equal to the value."""
    try:
        given = np.asarray(value)
    except ValueError:
        raise DataError(f"{label} is ragged: expected rows of equal length") from None
    if given.dtype.kind not in "biuf":
        raise DataError(f"{label} is of type {given.dtype}: expected {dtype.__name__}")
    array: NDArray[Any] = given.astype(dtype, order="C", copy=bool(given.flags.writeable))
    if not np.array_equal(array, given, equal_nan=given.dtype.kind == "f"):
        raise DataError(f"{label} has values that do not fit {dtype.__name__}")
    array.setflags(write=False)
    return array


def _check_shape(label: str, array: NDArray[Any], shape: tuple[int, ...]) -> None:
    if array.shape != shape:
        raise DataError(f"{label} has shape {array.shape}, expected {shape}")


def _check_time(label: str, t: Floats) -> None:
    infinite = np.flatnonzero(~np.isfinite(t))
    if infinite.size:
        raise DataError(
            f"{label}row {infinite[0]}: t is {t[infinite[0]]}, expected a finite stamp in s"
        )
    back = np.flatnonzero(np.diff(t) < 0)
    if back.size:
        row = back[0] + 1
        raise DataError(f"{label}row {row}: t goes back from {t[row - 1]} s to {t[row]} s")


def _check_steps(label: str, steps: Steps, t: Floats, position: Floats) -> None:
    start, end = steps.start_index, steps.end_index
    inside = not len(steps) or (start.min() >= 0 and end.max() < len(t))
    if not (
        inside
        and np.array_equal(steps.start, t[start])
        and np.array_equal(steps.end, t[end])
        and np.array_equal(steps.displacement, position[end] - position[start])
    ):
        raise DataError(
            f"{label}filter_steps do not lie between rows of this track: leave them out to find them anew"
        )


def _rate_hz(t: Floats) -> float:
    intervals = np.diff(t)
    positive = intervals[intervals > 0]
    return float(1 / np.median(positive)) if positive.size else np.nan


def _mean(values: NDArray[Any]) -> float:
    return float(values.mean()) if values.size else np.nan
