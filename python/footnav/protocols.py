"""Interfaces that callers implement."""

from __future__ import annotations

from typing import Protocol


class StanceDetector(Protocol):
    """A stance detector for `footnav.track`, `footnav.Navigator` and `footnav.detect`.

    Any object with these three members is valid.  It receives the calibrated samples one by one and
    decides with a fixed latency: None for the first `latency` samples, and then a bool for every
    further one.  The last `latency` samples of the data, which get no decision, count as not
    stationary.

    An exception that it raises propagates from the call that pushed the sample, and from every
    later one until the navigator is reset.

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
        """Latency of a decision in samples; read once."""
        ...

    def push(
        self, t: float, accel: tuple[float, float, float], gyro: tuple[float, float, float]
    ) -> bool | None:
        """Process the next sample and decide about the one `latency` samples before it.

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
            Whether the foot was at rest on the ground; None for the first `latency` samples.
        """
        ...

    def reset(self) -> None:
        """Discard all samples; also called before the first one."""
        ...
