"""Noise parameters of an inertial sensor from its Allan deviation."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from footnav.config import Sensor
from footnav.errors import ConfigError
from footnav.recording import Floats

FLICKER_FLOOR = math.sqrt(2 * math.log(2) / math.pi)
"""Allan deviation of flicker noise over its bias instability, 0.664 (IEEE Std 952-1997, annex C).
"""

MODEL_ERROR = 0.03
"""Relative error of the noise model, as a part of the deviation.

It limits the weight of the shortest averaging times, whose statistical error is tiny.
"""

MIN_DEGREES_OF_FREEDOM, MAX_BEND = 1000, 0.15
"""Degrees of freedom from which on the slope of the variance is known to half of the bend by which
a low-pass filter is detected.
"""

SIGNIFICANT = 3.0
"""A term of the variance that is smaller than this many of its standard deviations is not
significant.
"""

CONFIDENCE = 0.95
_TWO_SIDED, _ONE_SIDED = 1.960, 1.645
"""Standard deviations to the ends of a normal interval of 95 %, and to its upper end alone."""

EQUIVALENT_WALK_TIME = 100.0
"""s in which the equivalent random walk reaches the bias instability."""

INFLATION = (2.0, 3.0)
"""Factors from a sensor at rest to a worn one: of the white noise, and of the bias walk."""

_ROUNDS = 50


@dataclass(frozen=True, slots=True)
class Figure:
    """A noise parameter with its confidence interval of 95 %.

    Attributes
    ----------
    value : float or None
        The estimate; None when it is not significant.
    low, high : float
        Limits of the interval; without an estimate `low` is 0 and `high` the upper limit.
    """

    value: float | None
    low: float
    high: float

    def scaled(self, factor: float) -> Figure:
        """Return the figure in a unit that is smaller by `factor`."""
        return Figure(
            None if self.value is None else factor * self.value,
            factor * self.low,
            factor * self.high,
        )


@dataclass(frozen=True, slots=True)
class AxisNoise:
    """Noise of one axis, in the unit u of its samples (m/s² or rad/s).

    Attributes
    ----------
    channel : str
        Such as "gyro_x".
    quantization : Figure
        Q, u s: the deviation falls with the averaging time.
    random_walk : Figure
        N, u/√Hz: white noise, which makes a random walk of the angle or the velocity.
    bias_instability : Figure
        B, u: flicker noise, the floor of the deviation over 0.664.
    bias_walk : Figure
        K, u/√s: random walk of the rate or the acceleration.
    """

    channel: str
    quantization: Figure
    random_walk: Figure
    bias_instability: Figure
    bias_walk: Figure

    @property
    def terms(self) -> tuple[Figure, Figure, Figure, Figure]:
        """Q, N, B and K."""
        return self.quantization, self.random_walk, self.bias_instability, self.bias_walk

    def deviations(self, taus: Floats) -> Floats:
        """Return the Allan deviation of each term alone.

        Parameters
        ----------
        taus : ndarray, shape (k,)
            Averaging times, s.

        Returns
        -------
        ndarray, shape (k, 4)
            Of Q, N, B and K, u; zero for a term that is not significant.
        """
        figures = np.array([term.value or 0.0 for term in self.terms])
        deviations: Floats = np.sqrt(unit_variances(taus)) * figures
        return deviations

    @property
    def wander(self) -> float | None:
        """Equivalent random walk of the bias for a filter, u/√s, or None when none is significant.

        The larger one of K and of the walk that reaches B in 100 s.
        """
        instability = self.bias_instability.value
        significant = [
            self.bias_walk.value,
            None if instability is None else instability / math.sqrt(EQUIVALENT_WALK_TIME),
        ]
        return _largest(significant)


@dataclass(frozen=True, slots=True)
class NoiseFigures:
    """Noise of an inertial measurement unit at rest.

    Attributes
    ----------
    axes : tuple of AxisNoise
        Of accel_x, accel_y, accel_z, gyro_x, gyro_y and gyro_z.
    name : str
        Name of the recording.
    """

    axes: tuple[AxisNoise, ...]
    name: str = ""

    def sensor(
        self, base: Sensor | None = None, inflation: tuple[float, float] = INFLATION
    ) -> Sensor:
        """Return settings for the filter.

        The noise of the worst axis counts.  A sensor on a foot is noisier than on a table: shocks,
        temperature and supply move its biases, so the figures are inflated.  Process noise beyond
        that of the sensor is in ``Config.filter``.

        Parameters
        ----------
        base : Sensor, optional
            Settings whose other values are kept; the defaults unless given.
        inflation : tuple of 2 floats
            Factors of the white noise and of the bias walk.

        Returns
        -------
        Sensor
            With the noise densities and bias walks that are significant.

        Raises
        ------
        ConfigError
            An inflation is not a positive number.
        """
        return (base or Sensor()).replace(**self.settings(inflation))

    def settings(self, inflation: tuple[float, float] = INFLATION) -> dict[str, float]:
        """Return the settings of `sensor` that were significant, by name.

        Parameters
        ----------
        inflation : tuple of 2 floats
            As for `sensor`.

        Returns
        -------
        dict of str to float
            Of ``footnav.config.Sensor``.

        Raises
        ------
        ConfigError
            As `sensor`.
        """
        white, walk = inflation
        for factor in inflation:
            if not 0 < factor < math.inf:
                raise ConfigError(
                    f"inflation is {white:g} and {walk:g}; expected two positive numbers"
                )
        worst = {}
        for sensor in ("gyro", "accel"):
            axes = [axis for axis in self.axes if axis.channel.startswith(sensor)]
            worst[f"{sensor}_noise_density"] = (
                white,
                _largest([axis.random_walk.value for axis in axes]),
            )
            worst[f"{sensor}_bias_walk"] = walk, _largest([axis.wander for axis in axes])
        return {key: factor * value for key, (factor, value) in worst.items() if value is not None}


def fit_axis(
    channel: str, taus: Floats, deviation: Floats, degrees_of_freedom: Floats
) -> AxisNoise:
    """Describe an Allan deviation as the sum of four kinds of noise.

    The variances of the kinds (IEEE Std 952-1997, annex C) add up; their strengths are the
    non-negative ones under which the observed variances, chi-squared about the sum, are most
    likely.  A term that is not significant is left out, and gets an upper limit only.  Estimates
    within a decade of averaging time count as one, since they are correlated; the scatter of
    simulated random walks agrees with that.  Averaging times that a low-pass filter in the sensor
    affects are left out.

    Parameters
    ----------
    channel : str
        Name of the axis.
    taus : ndarray, shape (k,)
        Averaging times, s.
    deviation : ndarray, shape (k,)
        Allan deviation, above zero, in the unit of the axis.
    degrees_of_freedom : ndarray, shape (k,)
        Of each deviation.

    Returns
    -------
    AxisNoise
        In the unit of `deviation`.
    """
    known = slice(_end_of_filter(taus, deviation, degrees_of_freedom), None)
    taus = taus[known]
    curve = _Curve(
        variance=deviation[known] ** 2,
        parts=unit_variances(taus),
        information=_decades(taus) / (2 / degrees_of_freedom[known] + (2 * MODEL_ERROR) ** 2),
    )
    significant = list(range(curve.parts.shape[1]))
    strength, std = _fit(curve, significant)
    while len(significant) > 1 and (strength / std).min() < SIGNIFICANT:
        del significant[int((strength / std).argmin())]
        strength, std = _fit(curve, significant)
    found = {term: _estimate(*both) for term, *both in zip(significant, strength, std, strict=True)}
    return AxisNoise(
        channel,
        *(
            found.get(term) or _limit(curve, significant, term)
            for term in range(curve.parts.shape[1])
        ),
    )


def unit_variances(taus: Floats) -> Floats:
    """Return the Allan variance of each kind of noise at strength one.

    Parameters
    ----------
    taus : ndarray, shape (k,)
        Averaging times, s.

    Returns
    -------
    ndarray, shape (k, 4)
        Of Q, N, B and K.
    """
    return np.column_stack([3 / taus**2, 1 / taus, np.full_like(taus, FLICKER_FLOOR**2), taus / 3])


@dataclass(frozen=True, slots=True)
class _Curve:
    """Allan variances (k,), those of unit noise of each kind (k, 4), and weights (k,)."""

    variance: Floats
    parts: Floats
    information: Floats


def _end_of_filter(taus: Floats, deviation: Floats, degrees_of_freedom: Floats) -> int:
    """Return the first averaging time that no low-pass filter in the sensor affects.

    A sum of powers of the averaging time bends upwards in log-log axes: nowhere is it steeper than
    at its start.  Where a curve falls more steeply later on, a filter has removed noise before.
    """
    slopes = np.gradient(2 * np.log(deviation), np.log(taus))
    steepest = slopes[degrees_of_freedom > MIN_DEGREES_OF_FREEDOM].min(initial=np.inf)
    return int((slopes <= steepest + MAX_BEND).argmax())


def _decades(taus: Floats) -> Floats:
    """Return the width in decades of the averaging times that each one represents."""
    decades: Floats = np.gradient(np.log10(taus))
    return decades


def _fit(curve: _Curve, terms: list[int]) -> tuple[Floats, Floats]:
    """Return the squared strengths of some kinds of noise and their standard deviations.

    The standard deviation of a chi-squared estimate is proportional to its expectation, so the
    least squares are reweighted with the model of the last round; they converge to the maximum
    likelihood.
    """
    from scipy.optimize import nnls

    model = curve.variance
    for _ in range(_ROUNDS):
        weight = np.sqrt(curve.information) / model
        weighted = curve.parts[:, terms] * weight[:, None]
        # The strengths differ by many powers of ten; scaled by the norms of the columns, they do
        # not.
        scale = np.linalg.norm(weighted, axis=0)
        strength = nnls(weighted / scale, curve.variance * weight)[0] / scale
        last, model = model, curve.parts[:, terms] @ strength
        if np.allclose(model, last, rtol=1e-9, atol=0):
            break
    std = np.linalg.norm(np.linalg.pinv(weighted / scale), axis=1) / scale
    return strength, std


def _estimate(strength: float, std: float) -> Figure:
    spread = math.exp(_TWO_SIDED * std / strength / 2)
    value = math.sqrt(strength)
    return Figure(value, value / spread, value * spread)


def _limit(curve: _Curve, significant: list[int], term: int) -> Figure:
    """Return the upper limit of a kind of noise that is not significant."""
    strength, std = _fit(curve, [*significant, term])
    return Figure(None, 0.0, math.sqrt(strength[-1] + _ONE_SIDED * std[-1]))


def _largest(values: list[float | None]) -> float | None:
    return max((value for value in values if value is not None), default=None)


def confidence_limits(deviation: Floats, degrees_of_freedom: Floats) -> tuple[Floats, Floats]:
    """Return the ends of the interval that holds the true deviation in 95 % of all recordings.

    Parameters
    ----------
    deviation : ndarray
        Estimates.
    degrees_of_freedom : ndarray
        Of each estimate: the estimated variance is the true one times chi-squared over these.

    Returns
    -------
    low, high : ndarray
        As `deviation`.
    """
    from scipy.stats import chi2

    tails: tuple[float, float] = ((1 + CONFIDENCE) / 2, (1 - CONFIDENCE) / 2)
    low, high = (
        deviation * np.sqrt(degrees_of_freedom / chi2.ppf(tail, degrees_of_freedom))
        for tail in tails
    )
    return low, high
