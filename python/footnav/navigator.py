"""Streaming: one foot, sample by sample."""

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
    """Follows one foot, sample by sample.

    The numbers are those of :func:`footnav.track`, to the bit, however the samples are cut into
    blocks.  A state comes out `latency` samples after its sample went in, because the detector
    looks ahead and a step-wise smoother waits for the end of the step; :meth:`now` carries the
    filter's newest state forward to the newest sample.  While the start is aligned the states stay
    at the origin and `health` says so.

    The default looks ahead for 0.625 s and is the more accurate for it; with
    ``Config(detector=AdaptiveShoe.live())`` it is 0.275 s.  ``docs/accuracy.md`` tells what that
    costs.

    A magnetometer (``Config(magnetometer=Magnetometer(heading=True))``) is fed by
    :meth:`push_block`; what comes by `push` has no reading of it.

    Threads may share a navigator if they take turns: whatever is asked of it while another call is
    at work raises `footnav.errors.BusyError` and changes nothing.

    Parameters
    ----------
    config : Config, optional
        Settings; the defaults need no tuning.
    rate_hz : float
        Samples per second, about; sets the lengths of windows and what counts as a gap.
    detector : StanceDetector, optional
        A stance detector of one's own instead of the one that the settings name.  What it raises
        comes out of `push`, `push_block` and `flush`, and again until :meth:`reset`.

    Attributes
    ----------
    latency : int
        Number of samples by which a state comes late.
    t : float or None
        Stamp of the newest state, s; this and the following are None before the first state came
        out, and after a `NumericalError`.
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
        (b), in this order, of the filter's newest state, which a smoother still holds back; None
        while the start is aligned.

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
        """Remember the settings."""
        self.config = config or DEFAULTS
        self.rate_hz = rate_hz
        self._georeference = georeference(self.config)

    def push_block(
        self, t: ArrayLike, accel: ArrayLike, gyro: ArrayLike, mag: ArrayLike | None = None
    ) -> Trajectory:
        """Take a block of samples in and return the states that came out.

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
            repeat the one before, are no readings.  Used if ``config.magnetometer.heading`` is set.

        Returns
        -------
        Trajectory
            As many rows as states came out, possibly none.

        Raises
        ------
        DataError
            A shape is wrong, a value is not finite, or time goes back; or a magnetometer is to hold
            the heading, and neither this block nor one before has readings of it.  None of the
            block was used.
        NumericalError
            The filter cannot go on; :meth:`reset` begins anew.
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
            The data were ended before.
        NumericalError
            The filter cannot go on.
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
        """Return the state at the newest sample: the newest that came out, carried forward by the strapdown alone.

        Returns
        -------
        State or None
            None before the first sample; the origin while the start is aligned.

        Raises
        ------
        NumericalError
            The samples that wait for their decision are too large to integrate.
        """
        fields = self._state_now()
        return None if fields is None else State(**fields)

    @property
    def health(self) -> Health:
        """Trust in the newest state, with what was counted since the start."""
        return self._health(of_walk=False)

    def health_of_walk(self) -> Health:
        """Return the trust in the whole walk: all that spoke against it since the start was aligned."""
        return self._health(of_walk=True)

    def _health(self, *, of_walk: bool) -> Health:
        return Health.of_fields(self._health_fields(of_walk))


def _floats(name: str, values: ArrayLike, dimensions: int) -> NDArray[np.float64]:
    """Return what was given as an array of floats, or say what is wrong with it."""
    array = to_floats(name, values)
    if array.ndim != dimensions:
        expected = "(n,)" if dimensions == 1 else "(n, 3)"
        msg = f"{name} has shape {array.shape}; expected {expected}"
        raise DataError(msg)
    return array
