"""One recording of an IMU on a shoe, in SI units, validated once when it is constructed."""

import dataclasses
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from footnav.errors import ConfigError, DataError

Floats = NDArray[np.float64]

STANDARD_GRAVITY = 9.80665
"""The g of data sheets, m/s^2; exact by definition."""

MAX_GYRO = 70.0
"""rad/s, twice the usual widest range of 2000 deg/s: larger numbers are in deg/s."""

MIN_INTERVAL, MAX_INTERVAL = 50e-6, 0.5
"""Median interval between stamps, s: outside these limits the stamps are not in seconds."""

QUIET_WINDOW = 0.1
"""s; every stance of a walking foot is longer than this."""


@dataclass(init=False, frozen=True, slots=True, eq=False, repr=False)
class Recording:
    """Samples of one foot-mounted IMU.

    Arrays are copied, converted to C-contiguous float64 and made read-only.  Nothing is repaired:
    unusable samples are rejected; repeated stamps and gaps are kept for
    `footnav.diagnosis.diagnose`.

    Parameters
    ----------
    t : array_like, shape (n,)
        Time of each sample, s; non-decreasing.  Repeated stamps and gaps are allowed.
    accel : array_like, shape (n, 3)
        Specific force along the sensor's axes, m/s^2: at rest the axis that points up reads +g.
    gyro : array_like, shape (n, 3)
        Angular rate about the sensor's axes, rad/s.
    mag : array_like, shape (n, 3), optional
        Magnetic flux density along the sensor's axes, T.
    pressure : array_like, shape (n,), optional
        Air pressure, Pa.
    temperature : array_like, shape (n,), optional
        Temperature of the sensor, degrees Celsius.
    name : str
        Name in messages, usually the file's name.
    accel_range, gyro_range : float, optional
        Full scale of the sensors, m/s^2 and rad/s; needed to detect clipping.

    Attributes
    ----------
    rate_hz : float
        Sampling rate, Hz: one over the median of the intervals that are longer than zero.

    Raises
    ------
    DataError
        A shape or type is wrong, a value is not finite, time goes back or does not advance, or the
        values are in another unit.
    ConfigError
        A full scale is not a positive number, or is inconsistent with the samples.
    """

    t: Floats
    accel: Floats
    gyro: Floats
    mag: Floats | None
    pressure: Floats | None
    temperature: Floats | None
    name: str
    accel_range: float | None
    gyro_range: float | None
    rate_hz: float = field(init=False)

    def __init__(
        self,
        t: ArrayLike,
        accel: ArrayLike,
        gyro: ArrayLike,
        mag: ArrayLike | None = None,
        pressure: ArrayLike | None = None,
        temperature: ArrayLike | None = None,
        name: str = "",
        *,
        accel_range: float | None = None,
        gyro_range: float | None = None,
    ) -> None:
        arrays = {
            "t": t,
            "accel": accel,
            "gyro": gyro,
            "mag": mag,
            "pressure": pressure,
            "temperature": temperature,
        }
        fields: dict[str, Any] = {"name": name}
        try:
            fields |= {
                label: None if a is None else to_floats(label, a) for label, a in arrays.items()
            }
            fields |= {"accel_range": _full_scale("accel_range", accel_range)}
            fields |= {"gyro_range": _full_scale("gyro_range", gyro_range)}
            for label, value in fields.items():
                object.__setattr__(self, label, value)
            _check_channels(self)
            object.__setattr__(self, "rate_hz", 1.0 / _checked_interval(self.t))
            _check_units(self)
        except (DataError, ConfigError) as error:
            raise type(error)(f"{name}: {error}" if name else str(error)) from None

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle through the constructor, so that the arrays stay read-only."""
        return _rebuild, (
            {f.name: getattr(self, f.name) for f in dataclasses.fields(self) if f.init},
        )

    def __len__(self) -> int:
        """Return the number of samples."""
        return len(self.t)

    def __repr__(self) -> str:
        """Return one line: name, samples, duration, rate."""
        name = f"{self.name!r}, " if self.name else ""
        return f"Recording({name}{len(self)} samples, {self.duration:.2f} s, {self.rate_hz:.5g} Hz)"

    @property
    def duration(self) -> float:
        """Time from the first to the last sample, s."""
        return float(self.t[-1] - self.t[0])

    def save(self, path: str | PathLike[str]) -> None:
        """Write the recording to ``.csv`` or ``.npz``, which `footnav.read` restores to the bit.

        Raises
        ------
        ConfigError
            For another suffix.
        FootnavError
            For a file that cannot be written; an existing one is unchanged.
        """
        from footnav.export.recording import save_recording

        save_recording(self, path)

    def mean_magnetic_field(self, duration: float) -> tuple[float, float, float]:
        """Return the mean of the magnetometer at the start of the recording.

        Parameters
        ----------
        duration : float
            Length of the average, s; the sensor should be at rest.

        Returns
        -------
        tuple of 3 floats
            Magnetic flux density along the sensor's axes, T.

        Raises
        ------
        DataError
            The recording has no magnetometer.
        """
        if self.mag is None:
            raise DataError(f"{self.name or 'the recording'} has no magnetometer")
        x, y, z = self.mag[self.t <= self.t[0] + duration].mean(axis=0)
        return float(x), float(y), float(z)


def to_floats(label: str, values: ArrayLike) -> Floats:
    """Copy `values` into a read-only, C-contiguous float64 array.

    Parameters
    ----------
    label : str
        Name of the values in messages.
    values : array_like
        Real numbers of any shape.

    Returns
    -------
    ndarray of float64
        A copy; masked entries become nan.

    Raises
    ------
    DataError
        The values are ragged or are not real numbers.
    """
    if isinstance(values, np.ma.MaskedArray):
        values = np.where(np.ma.getmaskarray(values), np.nan, values.data)
    try:
        given = np.asarray(values)
    except ValueError:
        raise DataError(f"{label} is ragged: every row needs the same number of values") from None
    if given.dtype.kind not in "iuf":
        raise DataError(f"{label} holds {given.dtype} values; expected real numbers")
    floats = np.array(given, dtype=np.float64, order="C")
    floats.flags.writeable = False
    return floats


def quiet_level(accel: Floats, rate_hz: float) -> float:
    """Return the magnitude of the specific force where it is steadiest.

    Gravity as the sensor measures it.

    Parameters
    ----------
    accel : ndarray, shape (n, 3)
        Specific force, any unit.
    rate_hz : float
        Sampling rate, Hz.

    Returns
    -------
    float
        |mean of accel| over the quietest tenth of a second, in the unit of `accel`.
    """
    length = min(len(accel), max(2, round(QUIET_WINDOW * rate_hz)))
    windows = accel[: len(accel) // length * length].reshape(-1, length, 3)
    quietest = windows.std(axis=1).max(axis=1).argmin()
    return float(np.linalg.norm(windows[quietest].mean(axis=0)))


def _rebuild(fields: dict[str, Any]) -> Recording:
    return Recording(**fields)


def _full_scale(label: str, value: object) -> float | None:
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise ConfigError(f"{label} is {value!r}; expected one positive number")
    if not (math.isfinite(value) and value > 0):
        raise ConfigError(f"{label} is {value}; expected a positive number")
    return float(value)


def _check_channels(recording: Recording) -> None:
    _check_shapes(recording)
    _check_finite(recording)


def _check_units(recording: Recording) -> None:
    _check_accel_unit(recording.accel, recording.rate_hz)
    _check_gyro_unit(recording.gyro)
    _check_range("accel_range", "m/s^2", recording.accel, recording.accel_range)
    _check_range("gyro_range", "rad/s", recording.gyro, recording.gyro_range)


def _channels(recording: Recording) -> Iterable[tuple[str, Floats]]:
    """Yield the name and the array of each kind of samples that is present."""
    for label in ("t", "accel", "gyro", "mag", "pressure", "temperature"):
        values = getattr(recording, label)
        if values is not None:
            yield label, values


def _check_shapes(recording: Recording) -> None:
    n = recording.t.size
    for label, values in _channels(recording):
        expected = (n, 3) if label in ("accel", "gyro", "mag") else (n,)
        if values.shape != expected:
            cure = "; transpose it" if values.shape == expected[::-1] != expected else ""
            raise DataError(
                f"{label} has shape {values.shape}; expected {expected}, one row for each "
                f"stamp{cure}"
            )
    if n < 2:
        raise DataError(f"there are {n} samples; at least 2 are needed")


def _check_finite(recording: Recording) -> None:
    bad = {label: ~np.isfinite(values) for label, values in _channels(recording)}
    count = sum(int(mask.sum()) for mask in bad.values())
    if count:
        firsts = ((np.argwhere(mask)[0], label) for label, mask in bad.items() if mask.any())
        place, label = min(firsts, key=lambda first: int(first[0][0]))
        value = getattr(recording, label)[tuple(place)]
        channel = f"{label}_{'xyz'[place[1]]}" if len(place) == 2 else label
        raise DataError(
            f"row {place[0]} (counted from 0): {channel} is {value}; {count} value(s) in all are "
            "not finite: "
            "remove the rows or repair the recording"
        )


def _checked_interval(t: Floats) -> float:
    """Return the median of the positive intervals, if the stamps are in order and in seconds."""
    intervals = np.diff(t)
    back = np.flatnonzero(intervals < 0)
    if back.size:
        row = int(back[0]) + 1
        raise DataError(
            f"row {row} (counted from 0): time goes back from {t[row - 1]} s to {t[row]} s, "
            f"{back.size} time(s) in all; sort the rows, or unwrap a counter that overflowed"
        )
    if t[0] == t[-1]:
        raise DataError(
            f"all {len(t)} stamps are {t[0]} s; make stamps from the sampling rate (rate_hz)"
        )
    interval = float(np.median(intervals[intervals > 0]))
    if interval > MAX_INTERVAL:
        unit = "ms" if interval < 100 else "us" if interval < 1e5 else "ns"
        raise DataError(
            f'the stamps are {interval:g} s apart, so not in seconds; read them with t_unit="{unit}"'
        )
    if interval < MIN_INTERVAL:
        raise DataError(
            f"the stamps are {interval:g} s apart, so not in seconds; "
            'read them with the unit that they have: t_unit="s", "ms" or "us"'
        )
    return interval


def _check_accel_unit(accel: Floats, rate_hz: float) -> None:
    # Squares of absurd values overflow to inf, which is refused like any other.
    with np.errstate(over="ignore", invalid="ignore"):
        level = float(np.median(np.linalg.norm(accel, axis=1)))
        quiet = quiet_level(accel, rate_hz)
    problem = _accel_problem(level, level / STANDARD_GRAVITY, quiet / STANDARD_GRAVITY)
    if problem:
        raise DataError(f"the median of |accel| is {level:.4g} m/s^2: {problem}")


def _accel_problem(level: float, in_g: float, quiet_in_g: float) -> str | None:
    """Describe an error of the scale of the specific force, or return None.

    `level` is its median, m/s^2.
    """
    if 0.5 <= level <= 1.6:
        return 'the values are in g; read them with accel_unit="g", or multiply them by 9.80665'
    if 500 <= level <= 1600:
        return (
            'the values are in mg; read them with accel_unit="mg", or multiply them by 0.00980665'
        )
    if level < 0.5:
        return "gravity was removed; record the specific force, which reads 9.8 m/s^2 at rest"
    # The median of a runner comes near 2 g, but his stances still read 1 g.
    if in_g > 1.6 and 1.8 <= quiet_in_g <= 2.2:
        return (
            f"it is about 2 g where the sensor is at rest ({quiet_in_g:.2f} g); accel_range is "
            "twice what the sensor "
            "was set to, or offsets were calibrated for another range (as i2cdevlib's calibration "
            "does)"
        )
    if not 0.5 <= in_g <= 2.0:
        return (
            "neither m/s^2 (about 9.8 at rest) nor g (about 1); raw counts need their full scale "
            "(accel_range)"
        )
    return None


def _check_gyro_unit(gyro: Floats) -> None:
    peak = float(np.abs(gyro).max())
    if peak > MAX_GYRO:
        raise DataError(
            f"|gyro| reaches {peak:.4g} rad/s, which is beyond any foot: the values are in deg/s; "
            'read them with gyro_unit="deg/s", or multiply them by pi/180'
        )


def _check_range(label: str, unit: str, samples: Floats, full_scale: float | None) -> None:
    """Reject a full scale that the samples exceed by more than a calibration can explain."""
    peak = float(np.abs(samples).max())
    if full_scale is not None and peak > 1.2 * full_scale:
        raise ConfigError(
            f"{label} is {full_scale:.4g} {unit}, but the samples reach {peak:.4g} {unit}"
        )
