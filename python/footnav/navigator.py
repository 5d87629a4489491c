"""Streaming: navigation of one foot, sample by sample."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from footnav import _core
from footnav.config import DEFAULTS, Config
from footnav.errors import DataError
from footnav.georeference import georeference
from footnav.health import Health
from footnav.lazy_trajectory import LazyTrajectory
from footnav.recording import to_floats
from footnav.strides import Strides

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import Self

    from footnav.protocols import StanceDetector
    from footnav.trajectory import Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """Navigation state at one instant.

    Attributes
    ----------
    t : float
        Stamp, s.
    position, velocity : ndarray of shape (3,)
        In n, m and m/s.
    quaternion : ndarray of shape (4,)
        Rotation from the sensor frame to n, (x, y, z, w).
    """

    t: float
    position: NDArray[np.float64]
    velocity: NDArray[np.float64]
    quaternion: NDArray[np.float64]


class Navigator(_core.Navigator):
    """Navigation of one foot, sample by sample.

    The numbers are those of :func:`footnav.track`, to the bit, for any division of the samples into
    blocks.  A state is output `latency` samples after its sample, because the window of the
    detector extends into the future and a step-wise smoother waits for the end of the step;
    :meth:`now` extrapolates the filter's newest state to the newest sample.  During the alignment
    the states stay at the origin and `health` is invalid.

    The latency of the default is 0.625 s; with ``Config(detector=AdaptiveShoe.live())`` it is 0.275
    s, at a loss of accuracy that ``docs/accuracy.md`` quantifies.

    Readings of a magnetometer (``Config(magnetometer=Magnetometer(heading=True))``) are passed to
    :meth:`push_block`; samples of `push` have none.

    Threads may share a navigator if their calls do not overlap: a call during another one raises
    `footnav.errors.BusyError` and changes nothing.

    Parameters
    ----------
    config : Config, optional
        Settings; the defaults need no tuning.
    rate_hz : float
        Nominal samples per second; sets the lengths of windows and the limit of a gap.
    detector : StanceDetector, optional
        Takes the place of the detector that the settings name.  Its exceptions propagate from
        `push`, `push_block` and `flush`, and again until :meth:`reset`.

    Attributes
    ----------
    latency : int
        Delay of a state in samples.
    t : float or None
        Stamp of the newest state, s; this and the following are None before the first output, and
        after a `NumericalError`.
    position, velocity : ndarray of shape (3,) or None
        In n, m and m/s.
    quaternion : ndarray of shape (4,) or None
        Rotation from the sensor frame to n, (x, y, z, w).
    zero_velocity : bool or None
        Whether the foot was at rest on the ground.
    gyro_bias, accel_bias : ndarray of shape (3,) or None
        In the sensor frame, rad/s and m/s².
    covariance : ndarray of shape (15, 15) or None
        Of the errors of position, velocity, attitude (n), gyroscope bias and accelerometer bias
        (b), in this order, of the filter's newest state, before a smoother; None during the
        alignment.

    Raises
    ------
    ConfigError
        A setting or the rate is out of range, a correction or smoother needs the whole recording,
        or `detector` is no `footnav.protocols.StanceDetector`.
    """

    config: Config
    rate_hz: float

    def __new__(
        cls,
        config: Config | None = None,
        rate_hz: float = 200.0,
        *,
        detector: StanceDetector | None = None,
    ) -> Self:
        """Build the core's navigator."""
        return super().__new__(cls, (config or DEFAULTS).to_json(), rate_hz, detector)

    def __init__(
        self,
        config: Config | None = None,
        rate_hz: float = 200.0,
        *,
        detector: StanceDetector | None = None,
    ) -> None:
        """Store the settings."""
        self.config = config or DEFAULTS
        self.rate_hz = rate_hz
        self._georeference = georeference(self.config)

    def push_block(
        self, t: ArrayLike, accel: ArrayLike, gyro: ArrayLike, mag: ArrayLike | None = None
    ) -> Trajectory:
        """Process a block of samples and return the states that are output.

        Parameters
        ----------
        t : array_like of shape (n,)
            Stamps, s.
        accel : array_like of shape (n, 3)
            Specific force in the sensor frame, m/s².
        gyro : array_like of shape (n, 3)
            Angular rate in the sensor frame, rad/s.
        mag : array_like of shape (n, 3), optional
            Magnetic flux density in the sensor frame, calibrated, T.  Rows of NaN, and rows that
            repeat the one before, are not readings.  Used if ``config.magnetometer.heading`` is
            set.

        Returns
        -------
        Trajectory
            One row for each state that is output, possibly none.

        Raises
        ------
        DataError
            A shape is wrong, a value is not finite, or time goes back; or the settings ask for the
            magnetometer, and neither this block nor an earlier one has readings of it. No sample of
            the block is used.
        NumericalError
            The filter failed; :meth:`reset` restarts it.
        """
        field = None if mag is None else _floats("mag", mag, 2)
        found = self._push_columns(t, accel, gyro, field)
        if found is None:
            return self.push_block(
                _floats("t", t, 1), _floats("accel", accel, 2), _floats("gyro", gyro, 2), field
            )
        return LazyTrajectory.of_columns(found, self._georeference)

    def flush(self) -> Trajectory:
        """End the data and return the states of the last `latency` samples.

        Raises
        ------
        DataError
            The data are already flushed.
        NumericalError
            The filter failed.
        """
        return LazyTrajectory.of_columns(self._flush_columns(), self._georeference)

    def strides(self) -> Strides:
        """Return the strides that were completed since the last call.

        A stride is complete once the foot has left the stance at its end for 0.1 s, has stood
        there for 0.5 s, or the data are flushed; with a step-wise smoother, once the states of both
        ends were output.  All of this has the delay of `latency` samples.

        Returns
        -------
        Strides
            In the order of time, possibly none; their samples are counted over all states that
            were output since the start.

        Raises
        ------
        ConfigError
            The settings do not ask for strides.
        """
        return Strides(**self._stride_columns())

    def now(self) -> State | None:
        """Return the state at the newest sample.

        The newest output, extrapolated by the strapdown alone.

        Returns
        -------
        State or None
            None before the first sample; the origin during the alignment.

        Raises
        ------
        NumericalError
            The samples that have no decision yet are too large to integrate.
        """
        fields = self._state_now()
        return None if fields is None else State(**fields)

    @property
    def health(self) -> Health:
        """Quality of the newest state, with the counters since the start."""
        return self._health(of_walk=False)

    def health_of_walk(self) -> Health:
        """Return the quality of the whole walk: all flags since the alignment."""
        return self._health(of_walk=True)

    def _health(self, *, of_walk: bool) -> Health:
        return Health.of_fields(self._health_fields(of_walk))


def _floats(name: str, values: ArrayLike, dimensions: int) -> NDArray[np.float64]:
    """Return the values as an array of floats, or raise DataError."""
    array = to_floats(name, values)
    if array.ndim != dimensions:
        expected = "(n,)" if dimensions == 1 else "(n, 3)"
        msg = f"{name} has shape {array.shape}; expected {expected}"
        raise DataError(msg)
    return array
