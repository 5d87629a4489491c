"""The clock of a sensor or board, disciplined by that of the host.

The resonator of an Arduino is off by up to half a percent and the oscillator of an MPU6050 by more;
the error of the distance is twice as large.  The host's clock is accurate to some parts in a
million, but data over USB or I2C arrive with a variable latency of milliseconds.  The ratio of the
rates is therefore estimated over the whole capture, by the two-state Kalman filter of clocks: the
states are the host's time at the newest sample and the rate, the rate is a random walk, and the
measurement noise is the latency.

Only the rate enters the stamps, never the phase: the latency of a reading must not change the
interval between two samples, the only time that navigation uses.

References
----------
L. Galleani, P. Tavella, "Time and the Kalman filter", IEEE Control Systems Magazine 30(2), 2010:
the two-state model and its process noise, without the white noise of frequency.
"""

from footnav.recording import Floats

_RATE_WALK = 1e-5
"""Random walk of the rate, 1/sqrt(s): the rate of a warming oscillator changes by some parts in ten
thousand in minutes.
"""

_GATE = 25.0
"""Gate of the squared normalized innovation: beyond it the host was busy, or bytes were buffered.
"""


class HostedClock:
    """Converts stamps of a device to time since the start of the capture.

    Parameters
    ----------
    rate_sigma : float
        Relative error of the device's clock (one sigma).
    latency : float
        Variation of the latency at the host, s (one sigma).

    Attributes
    ----------
    rate : float
        Estimated seconds of the host in a second of the device.
    """

    rate: float

    def __init__(self, rate_sigma: float, latency: float) -> None:
        self.rate = 1.0
        self._rate_variance = rate_sigma**2
        self._noise = latency**2
        self._phase = self._phase_variance = self._covariance = 0.0
        self._device = self._t = 0.0
        self._running = False

    def stamps(self, device: Floats, host: float) -> Floats:
        """Continue with samples of the same run of the device.

        Parameters
        ----------
        device : ndarray of shape (n,)
            Stamps of the device, s, non-decreasing; at least one.
        host : float
            Time of the host at the arrival of the last of them, s.

        Returns
        -------
        ndarray of shape (n,)
            Time since the start of the capture, s.
        """
        if not self._running:
            return self._begin(device, host, t=0.0)
        self._predict(float(device[-1]) - self._device)
        self._update(host)
        return self._advance(device, self._t + (float(device[0]) - self._device) * self.rate)

    def restart(self, device: Floats, host: float, interval: float) -> Floats:
        """Continue after a restart of the device; the host's clock gives the time between.

        Parameters
        ----------
        device : ndarray of shape (n,)
            Stamps of the device, s, non-decreasing; at least one.
        host : float
            Time of the host at the arrival of the last of them, s.
        interval : float
            Interval of the samples, s: the minimum from the last sample before to the first one
            after.

        Returns
        -------
        ndarray of shape (n,)
            Time since the start of the capture, s.
        """
        first = host - float(device[-1] - device[0]) * self.rate
        return self._begin(device, host, self._t + max(first - self._phase, interval))

    def _begin(self, device: Floats, host: float, t: float) -> Floats:
        self._running = True
        self._phase, self._phase_variance, self._covariance = host, self._noise, 0.0
        return self._advance(device, t)

    def _advance(self, device: Floats, t: float) -> Floats:
        stamps: Floats = t + (device - device[0]) * self.rate
        self._device, self._t = float(device[-1]), float(stamps[-1])
        return stamps

    def _predict(self, elapsed: float) -> None:
        walk = _RATE_WALK**2 * elapsed
        self._phase += self.rate * elapsed
        self._phase_variance += elapsed * (
            2 * self._covariance + elapsed * (self._rate_variance + walk / 3)
        )
        self._covariance += elapsed * (self._rate_variance + walk / 2)
        self._rate_variance += walk

    def _update(self, host: float) -> None:
        innovation, variance = host - self._phase, self._phase_variance + self._noise
        if innovation**2 > _GATE * variance:
            return
        phase_gain, rate_gain = self._phase_variance / variance, self._covariance / variance
        self._phase += phase_gain * innovation
        self.rate += rate_gain * innovation
        self._rate_variance -= rate_gain * self._covariance
        self._covariance *= 1 - phase_gain
        self._phase_variance *= 1 - phase_gain
