"""Settings of the stance detectors; `docs/papers.md` explains what each of them looks at."""

from __future__ import annotations

from typing import Literal, TypeAlias, cast, get_args

from footnav import _core
from footnav.errors import ConfigError
from footnav.section import Section, by_kind, decode, unknown_kind

Condition: TypeAlias = Literal["magnitude", "variance", "rate"]


class AdaptiveShoe(Section, frozen=True, kw_only=True, tag_field="kind", tag="adaptive-shoe"):
    """SHOE with a threshold that follows the stride: a min_factor above the statistic's minimum around the sample.

    Attributes
    ----------
    window : float
        Length of the statistic's window, s.
    accel_std, gyro_std : float
        Standard deviations that the statistic weighs specific force and angular rate with, m/s² and
        rad/s.
    look_behind, look_ahead : float
        How far the minimum is sought, s.  The latency is `look_ahead` and half a window.
    min_factor : float
        Multiple of the minimum up to which a sample is stationary.
    noise_floor : float
        Statistic below which a sample is stationary however low the minimum is.
    upper_bound : float
        Statistic above which a sample is never stationary.
    max_fraction : float
        Part of the maximum around the sample up to which it is stationary.
    """

    window: float = 0.05
    accel_std: float = 0.02
    gyro_std: float = 8.7e-3
    look_behind: float = 0.6
    look_ahead: float = 0.6
    min_factor: float = 1.5
    noise_floor: float = 500.0
    upper_bound: float = 2.0e5
    max_fraction: float = 0.015

    @classmethod
    def live(cls) -> AdaptiveShoe:
        """Return the settings for a stream that must not be late by more than 0.3 s.

        Examples
        --------
        >>> config = Config.preset("mpu6050").replace(detector=AdaptiveShoe.live())
        >>> Navigator(config, rate_hz=200.0).latency
        55
        """
        return decode(_core.live_detector(), cls)


class Shoe(Section, frozen=True, kw_only=True, tag_field="kind", tag="shoe"):
    """SHOE with a fixed threshold (Skog et al. 2010).

    Attributes
    ----------
    window : float
        Length of the window, s.
    accel_std, gyro_std : float
        Standard deviations that the statistic weighs specific force and angular rate with, m/s² and
        rad/s.
    threshold : float
        Statistic below which a sample is stationary.
    """

    window: float = 0.025
    accel_std: float = 0.02
    gyro_std: float = 8.7e-3
    threshold: float = 3.0e3


class MagnitudeVariance(
    Section, frozen=True, kw_only=True, tag_field="kind", tag="magnitude-variance"
):
    """Magnitude and sliding variance of the specific force (Wu et al., eqs. 4-5).

    The gates are the paper's 0.06, which it prints without a unit; in m/s² and m²/s⁴ they work on
    real recordings of an MPU6050, in g they do not.

    Attributes
    ----------
    window : float
        Length of the variance's window, s.
    magnitude_gate : float
        Deviation of the magnitude from gravity from which a sample moves, m/s².
    variance_gate : float
        Variance of the magnitude from which a sample moves, m²/s⁴.
    """

    window: float = 0.055
    magnitude_gate: float = 0.06
    variance_gate: float = 0.06


class WindowedEnergies(
    Section, frozen=True, kw_only=True, tag_field="kind", tag="windowed-energies"
):
    """Energies of specific force and angular rate over a window (Wang et al. 2019, eq. 3).

    The window is the paper's, the rest was chosen on real walks with a VN-100, an MPU6050, an NGIMU
    and OpenShoe's IMU.

    Attributes
    ----------
    window : float
        Length of the window, s.
    accel_std, gyro_std : float
        Standard deviations that the energies are weighed with, m/s² and rad/s.
    accel_threshold, gyro_threshold : float
        Energies from which a sample moves.
    """

    window: float = 0.15
    accel_std: float = 0.02
    gyro_std: float = 8.7e-3
    accel_threshold: float = 3.0e3
    gyro_threshold: float = 6.0e3


class MagnitudeDebounced(
    Section, frozen=True, kw_only=True, tag_field="kind", tag="magnitude-debounced"
):
    """Magnitude of the specific force, without isolated detections and gaps (Abdulrahim et al.).

    The statistic and its threshold are those of each sample alone; the decision also depends on the
    samples around it.

    The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU;
    the paper prints none.

    Attributes
    ----------
    magnitude_gate : float
        Deviation of the magnitude from gravity from which a sample moves, m/s².
    longest_gap : float
        Gap between two detections up to which it is filled, s.
    shortest_stance : float
        Stance, gaps filled, below which it is dropped, s.  The latency is this and `longest_gap`,
        less one sample.
    """

    magnitude_gate: float = 0.3
    longest_gap: float = 0.02
    shortest_stance: float = 0.15


class ThreeCondition(Section, frozen=True, kw_only=True, tag_field="kind", tag="three-condition"):
    """Magnitude, variance and rate, together or any of them (Wang Libing et al. 2016).

    The defaults were chosen for all three together on real walks with a VN-100, an MPU6050, an
    NGIMU and OpenShoe's IMU; the paper prints none.

    Attributes
    ----------
    conditions : tuple of {"magnitude", "variance", "rate"}
        The conditions that must hold, one or more: |f| near gravity, its variance low, |ω| low.
    window : float
        Length of the variance's window, s; the other conditions look at its centre.
    magnitude_band : float
        Deviation of the magnitude from gravity from which a sample moves, m/s².
    variance_threshold : float
        Variance of the magnitude from which a sample moves, m²/s⁴.
    rate_threshold : float
        Angular rate from which a sample moves, rad/s.
    """

    conditions: tuple[Condition, ...] = ("magnitude", "variance", "rate")
    window: float = 0.15
    magnitude_band: float = 0.3
    variance_threshold: float = 0.5
    rate_threshold: float = 0.5


class AngularRateEnergy(
    Section, frozen=True, kw_only=True, tag_field="kind", tag="angular-rate-energy"
):
    """Energy of the angular rate: ARE of Skog et al. 2010.

    The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU.

    Attributes
    ----------
    window : float
        Length of the window, s.
    threshold : float
        Mean square of the angular rate up to which a sample is stationary, rad²/s².
    """

    window: float = 0.1
    threshold: float = 0.8


class MovingVariance(Section, frozen=True, kw_only=True, tag_field="kind", tag="moving-variance"):
    """Moving variance of the specific force: MV of Skog et al. 2010.

    The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU.

    Attributes
    ----------
    window : float
        Length of the window, s.
    threshold : float
        Variance of the specific force, summed over the axes, up to which a sample is stationary,
        m²/s⁴.
    """

    window: float = 0.15
    threshold: float = 0.2


class AccelerationMagnitude(
    Section, frozen=True, kw_only=True, tag_field="kind", tag="acceleration-magnitude"
):
    """Magnitude of the specific force: MAG of Skog et al. 2010.

    The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU.

    Attributes
    ----------
    window : float
        Length of the window, s.
    threshold : float
        Mean square of the magnitude less gravity up to which a sample is stationary, m²/s⁴.
    """

    window: float = 0.1
    threshold: float = 0.1


class GraphTheoretic(Section, frozen=True, kw_only=True, tag_field="kind", tag="graph-theoretic"):
    """Contrast of the specific force between the parts of a window, wherever it is cut in two (MBGTD).

    The defaults were chosen on real walks with a VN-100, an MPU6050, an NGIMU and OpenShoe's IMU.

    Attributes
    ----------
    window : float
        Length of the window, s.
    threshold : float
        Mean distance between the parts less that within them, over the cuts at the most, up to
        which a sample is stationary, m/s².
    """

    window: float = 0.15
    threshold: float = 0.3


Detector: TypeAlias = (
    AdaptiveShoe
    | Shoe
    | MagnitudeVariance
    | WindowedEnergies
    | MagnitudeDebounced
    | ThreeCondition
    | AngularRateEnergy
    | MovingVariance
    | AccelerationMagnitude
    | GraphTheoretic
)


def default_detector(kind: str) -> Detector:
    """Return the default settings of a kind of detector.

    Raises
    ------
    ConfigError
        No such kind; the message lists the known ones.
    """
    kinds = by_kind(get_args(Detector))
    if kind not in kinds:
        raise ConfigError(unknown_kind(f"unknown detector {kind!r}", kind, kinds))
    return cast("Detector", kinds[kind]())
