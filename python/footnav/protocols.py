"""The stance detector that a user brings along."""

from __future__ import annotations

from typing import Protocol


class StanceDetector(Protocol):
    """A stance detector of one's own, for `footnav.track`, `footnav.Navigator` and `footnav.detect`.

    Any object with these three members will do.  It is asked about one calibrated sample after the
    other and answers by a fixed number of samples late: None for the first `latency` samples, and
    then a bool for every further one. The last `latency` samples of the data, which it is never
    asked about, count as not stationary.

    An exception that it raises comes out of the call that pushed the sample, and out of every later
    one until the navigator is reset.

    Examples
    --------
    >>> class Still:
    ...     latency = 0
    ...
    ...     def push(self, t, accel, gyro):
    ...         return sum(rate * rate for rate in gyro) < 0.5
    ...
    ...     def reset(self):
    ...         pass
    """

    @property
    def latency(self) -> int:
        """Number of samples by which a decision comes late; read once."""
        ...

    def push(
        self, t: float, accel: tuple[float, float, float], gyro: tuple[float, float, float]
    ) -> bool | None:
        """Take the next sample and decide about the one `latency` samples before it.

        Parameters
        ----------
        t : float
            Stamp, s.
        accel : tuple of 3 floats
            Specific force in the sensor frame, calibrated, m/s².
        gyro : tuple of 3 floats
            Angular rate in the sensor frame, calibrated, rad/s.

        Returns
        -------
        bool or None
            Whether the foot was at rest on the ground; None while there is no sample that far back.
        """
        ...

    def reset(self) -> None:
        """Forget all samples; called before the first one, too."""
        ...
