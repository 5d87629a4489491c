"""The track of the foot."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footnav.columns import COLUMNS
from footnav.errors import ConfigError, DataError
from footnav.frames import check_frame
from footnav.geodesy import Origin, check_origin, enu_to_geodetic, warn_of_heading
from footnav.health import Health
from footnav.strides import Strides, find_stances, find_strides
from footnav.summary import Displacement, Summary

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Trajectory:
    """States of the foot, one row for each sample; n may be zero.

    The arrays are read-only; a writable array is copied.

    Attributes
    ----------
    t : (n,) ndarray
        Stamps, s, non-decreasing.
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
        Name in messages and files.
    origin : (latitude, longitude, height) or None
        Origin of the navigation frame, in degrees and m (WGS-84).
    frame : {"enu", "ned"}
        Frame in which tables are written; the arrays here always have z up.
    heading_known : bool
        Whether x is east; if not, it is the direction of the foot at the start.
    filter_strides : Strides or None
        Strides of the filter with their covariance, where the settings ask for them
        (``output.strides``).  Those of a smoothed or corrected track are displacements between its
        rows; their covariance is that of the filter alone, and so conservative.

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
    filter_strides: Strides | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        """Validate all fields and make the arrays read-only."""
        label = f"{self.name}: " if self.name else ""
        for column, (_, dtype) in COLUMNS.items():
            object.__setattr__(
                self, column, _frozen_array(label + column, getattr(self, column), dtype)
            )
        for column, (width, _) in COLUMNS.items():
            _check_shape(label + column, getattr(self, column), (len(self.t), *width))
        _check_time(label, self.t)
        if self.origin is not None:
            object.__setattr__(self, "origin", check_origin(self.origin))
        check_frame(self.frame)
        if self.filter_strides is not None:
            _check_strides(label, self.filter_strides, self.t, self.position)

    @classmethod
    def of_core(cls, columns: dict[str, NDArray[Any]], **fields: Any) -> "Trajectory":
        """Take the columns of the core without checks or copies; they are valid by construction.

        Parameters
        ----------
        columns : dict of str to ndarray
            One array for each column, to which there is no other reference.
        **fields
            The other attributes; absent ones keep the defaults of the constructor.

        Returns
        -------
        Trajectory
            With the same arrays, made read-only.
        """
        track = object.__new__(cls)
        for array in columns.values():
            array.setflags(write=False)
        defaults = {f.name: f.default for f in dataclasses.fields(cls) if f.name not in columns}
        for name, value in {**defaults, **columns, **fields}.items():
            object.__setattr__(track, name, value)
        return track

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle through the constructor, so that the arrays stay read-only."""
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
            f"<Trajectory{name}: {len(self):,} samples, {self.t[-1] - self.t[0]:.2f} s, "
            f"{self.distance:.2f} m walked, "
            f"end at ({x:.2f}, {y:.2f}, {z:.2f}) m>"
        )

    def __getitem__(self, part: slice) -> "Trajectory":
        """Select samples.

        The part has no health and no strides of the filter, which belong to the whole run.

        Raises
        ------
        TypeError
            For anything but a slice.
        """
        if not isinstance(part, slice):
            raise TypeError(f"a Trajectory takes a slice such as traj[10:20], not {part!r}")
        columns: dict[str, Any] = {column: getattr(self, column)[part] for column in COLUMNS}
        return dataclasses.replace(self, **columns, health=None, filter_strides=None)

    @staticmethod
    def concatenate(parts: "Sequence[Trajectory]") -> "Trajectory":
        """Concatenate consecutive parts, such as the blocks of a stream.

        Parameters
        ----------
        parts : sequence of Trajectory
            In the order of time, with the same origin and frame.

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
                    f"part {number} differs from part 0 in whether the heading is known: not one "
                    "track"
                )
            if (part.origin, part.frame) != (parts[0].origin, parts[0].frame):
                raise DataError(
                    f"part {number} has origin {part.origin} and frame {part.frame!r}, "
                    f"part 0 has {parts[0].origin} and {parts[0].frame!r}: parts of one track "
                    "share both"
                )
        columns: dict[str, Any] = {
            column: np.concatenate([getattr(part, column) for part in parts]) for column in COLUMNS
        }
        return dataclasses.replace(
            parts[0], **columns, health=parts[-1].health, filter_strides=None
        )

    @property
    def strides(self) -> Strides:
        """Strides of this foot.

        Those of the filter, or computed at each access, without covariance.
        """
        if self.filter_strides is not None:
            return self.filter_strides
        return find_strides(self.t, self.position, self.quaternion, self.zero_velocity)

    @property
    def distance(self) -> float:
        """Distance walked, m: the sum of the horizontal lengths of the strides."""
        return float(self.strides.length.sum())

    def summary(self) -> Summary:
        """Summarize the track.

        Returns
        -------
        Summary
            Prints as a small table.
        """
        strides = self.strides
        distance = float(strides.length.sum())
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
            strides=len(strides),
            stride_length=_mean(strides.length),
            cadence=60 / _mean(strides.duration),
            zero_velocity_share=_mean(self.zero_velocity),
            greatest_speed=float(np.linalg.norm(self.velocity, axis=1).max())
            if len(self)
            else np.nan,
            horizontal_std=float(np.hypot(east_std, north_std)),
            vertical_std=float(up_std),
            health=self.health,
        )

    def geodetic(self, origin: Sequence[float] | None = None) -> Floats:
        """Return latitude, longitude and height.

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
        where = self.origin if origin is None else check_origin(origin)
        if where is None:
            raise ConfigError(
                "the track has no origin: set output.origin in the configuration, "
                "or geodetic((latitude, longitude, height))"
            )
        warn_of_heading(self.heading_known, stacklevel=2)
        return enu_to_geodetic(self.position, where)

    def save(self, path: str | PathLike[str], **options: Any) -> None:
        """Write the track to a file whose suffix names the format; see `footnav.export.save`."""
        from footnav.export.save import save

        save(self, path, **options)

    def _standing_heights(self) -> tuple[float, float]:
        """Return the lowest and the highest height of a stance."""
        first, last = find_stances(self.t, self.zero_velocity)
        heights = self.position[(first + last) // 2, 2]
        return (float(heights.min()), float(heights.max())) if heights.size else (np.nan, np.nan)


def load_trajectory(path: str | PathLike[str]) -> Trajectory:
    """Read a track that was saved as ``.npz``.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    Trajectory
        Equal to the one that was saved, to the bit.

    Raises
    ------
    DataError
        When the file cannot be read or is not a track; the message names it.
    """
    from footnav.export.archive import read_npz

    return read_npz(path, Trajectory)


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


def _check_strides(label: str, strides: Strides, t: Floats, position: Floats) -> None:
    start, end = strides.start_index, strides.end_index
    inside = not len(strides) or (start.min() >= 0 and end.max() < len(t))
    if not (
        inside
        and np.array_equal(strides.start, t[start])
        and np.array_equal(strides.end, t[end])
        and np.array_equal(strides.displacement, position[end] - position[start])
    ):
        raise DataError(
            f"{label}filter_strides do not lie between rows of this track: leave them out to "
            "compute them"
        )


def _rate_hz(t: Floats) -> float:
    intervals = np.diff(t)
    positive = intervals[intervals > 0]
    return float(1 / np.median(positive)) if positive.size else np.nan


def _mean(values: NDArray[Any]) -> float:
    return float(values.mean()) if values.size else np.nan
