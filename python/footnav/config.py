"""Settings of every stage, in the order in which a sample meets the stages.

The Rust core owns the defaults and the ranges; the values here are the same ones.  Everything is
SI; angles are in degrees where the name ends in ``_deg``.
"""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias

from footnav import _core
from footnav.config_file import load_settings, save_settings
from footnav.detectors import AdaptiveShoe, Detector
from footnav.section import Section, decode, encode

if TYPE_CHECKING:
    from footnav.recording import Recording

Vector: TypeAlias = tuple[float, float, float]
Matrix: TypeAlias = tuple[Vector, Vector, Vector]

IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Sensor(Section, frozen=True, kw_only=True):
    """What is known of the inertial measurement unit.

    Attributes
    ----------
    gyro_noise_density : float
        White noise of the gyroscope, rad/s/√Hz.
    accel_noise_density : float
        White noise of the accelerometer, m/s²/√Hz.
    gyro_bias_walk : float
        Random walk of the gyroscope's bias, rad/s/√s.
    accel_bias_walk : float
        Random walk of the accelerometer's bias, m/s²/√s.
    gyro_bias_std : float
        Standard deviation of the gyroscope's bias before any rest was seen, rad/s.
    accel_bias_std : float
        Standard deviation of the accelerometer's bias, m/s².
    gyro_scale_std, accel_scale_std : float
        Standard deviations of scale factors and misalignments (rad) that no calibration took out.
    gyro_range : float, optional
        Full scale of the gyroscope, rad/s.
    accel_range : float, optional
        Full scale of the accelerometer, m/s².
    """

    gyro_noise_density: float = 1.0e-4
    accel_noise_density: float = 4.0e-3
    gyro_bias_walk: float = 1.0e-5
    accel_bias_walk: float = 1.0e-4
    gyro_bias_std: float = 0.02
    accel_bias_std: float = 0.15
    gyro_scale_std: float = 0.0
    accel_scale_std: float = 0.0
    gyro_range: float | None = None
    accel_range: float | None = None


class Calibration(Section, frozen=True, kw_only=True):
    """Correction of raw readings: M (raw - b) for each sensor.

    Attributes
    ----------
    accel_matrix : tuple of 3 rows
        Scale and misalignment M of the accelerometer.
    accel_bias : tuple of 3 floats
        Bias b of the accelerometer, m/s².
    gyro_matrix : tuple of 3 rows
        Scale and misalignment M of the gyroscope.
    gyro_bias : tuple of 3 floats
        Bias b of the gyroscope, rad/s.
    """

    accel_matrix: Matrix = IDENTITY
    accel_bias: Vector = (0.0, 0.0, 0.0)
    gyro_matrix: Matrix = IDENTITY
    gyro_bias: Vector = (0.0, 0.0, 0.0)


class Alignment(Section, frozen=True, kw_only=True):
    """The start of the walk.

    Attributes
    ----------
    duration : float
        Rest that is averaged at the most, s.
    levelling : {"arctangent", "arcsine"}
        Form of the levelling equations; the arcsines of Wu et al., eq. 1, need a sensor mounted
        within 90 degrees of upright.
    heading_deg : float, optional
        Heading of `forward_axis` at the start, degrees clockwise from true north.  Without it n x
        is where that axis points.
    magnetic_field : tuple of 3 floats, optional
        Magnetic field at the start in the sensor frame, any unit: gives the heading instead of
        `heading_deg`.
    declination_deg : float
        Declination of the magnetic field, degrees east of true north.
    forward_axis : {"x", "y", "z", "-x", "-y", "-z"}
        Axis of the sensor that the heading belongs to.
    rest_accel_std, rest_gyro_std : float
        Greatest standard deviations that still count as rest, m/s² and rad/s.
    fine_duration : float
        Rest after that, at the most, over which the filter levels finely before the walk begins, s
        (Wu et al.).
    gyro_bias_std : float
        Standard deviation of the gyroscope's bias after `duration` of rest, rad/s, beside what the
        foot was seen to sway.
    tilt_std : float
        Standard deviation of roll and pitch beyond what the accelerometer's bias explains, rad.
    heading_std_deg : float
        Standard deviation of the heading, degrees: zero when it only defines where n x points.
    """

    duration: float = 1.0
    levelling: Literal["arctangent", "arcsine"] = "arctangent"
    heading_deg: float | None = None
    magnetic_field: Vector | None = None
    declination_deg: float = 0.0
    forward_axis: Literal["x", "y", "z", "-x", "-y", "-z"] = "x"
    rest_accel_std: float = 0.25
    rest_gyro_std: float = 0.06
    fine_duration: float = 0.0
    gyro_bias_std: float = 1.0e-3
    tilt_std: float = 0.01
    heading_std_deg: float = 0.0


class Mechanization(Section, frozen=True, kw_only=True):
    """The strapdown integration.

    Attributes
    ----------
    kind : {"two-sample", "single-sample", "first-order"}
        Coning and sculling compensated; rotation compensated only; the first-order form of Wang et
        al. 2019.
    earth_rate : bool
        Whether the Earth turns; needs a heading.
    gravity : float, optional
        Gravity, m/s²; from latitude and height when absent.
    latitude_deg, height : float, optional
        Where gravity is taken at, degrees and m; from `Output.origin`, or else 45 degrees and 0 m,
        when absent.
    """

    kind: Literal["two-sample", "single-sample", "first-order"] = "two-sample"
    earth_rate: bool = False
    gravity: float | None = None
    latitude_deg: float | None = None
    height: float | None = None


class Filter(Section, frozen=True, kw_only=True):
    """The error-state filter.

    Attributes
    ----------
    kind : {"kf", "dr", "ins"}
        What a zero velocity corrects: all states that the velocity depends on, by a Kalman filter;
        the velocity alone (dead reckoning, Abdulrahim et al.); nothing (the strapdown alone, for
        comparison).
    specific_force_noise : float
        Noise density of the specific force beyond the sensor's own, m/s²/√Hz: shock, bandwidth,
        scale and timing of a foot in motion.
    angular_rate_noise : float
        Noise density of the angular rate beyond the sensor's own, rad/s/√Hz.
    clipped_noise_factor : float
        Factor by which both grow at a sample that clips.
    zero_velocity_std : float
        Standard deviation of a foot's velocity in stance, m/s.
    zupt_lever_std : float
        How far what the foot rolls about wanders, m: the velocity is uncertain by this times the
        angular rate.
    zupt_correlation : float
        Part of both that all zero velocities of a stance have in common, 0 to 1.  The foot takes it
        along to the next stance, so it widens the uncertainty of the position; the track is the
        same.
    contact_rate : float
        Angular rate up to which a foot that stands in between rolls on the ground, rad/s: from
        these contacts it is learned what it rolls about, and with which velocity in stance.  Zero:
        a foot in stance has none.
    chi2_gate : float
        Squared Mahalanobis distance beyond which a zero velocity, zero angular rate or attitude is
        rejected.
    rejection_limit : float
        Time in stance, over one or several of them, with nothing but rejections after which a zero
        velocity is believed all the same, s.
    attitude_update : {"none", "gravity", "iaa"}
        What the accelerometer tells of the attitude in stance: nothing beyond the zero velocities;
        roll and pitch; or roll, pitch and heading as published by Wang et al. 2019, eq. 17.  An
        accelerometer carries no heading: ``docs/papers.md`` tells what the last one does.
    attitude_threshold : float, optional
        Difference of the specific force from gravity below which it does, m/s²: from the sensor's
        noise.  Needed for an attitude update.
    attitude_std : float
        Standard deviation of the attitude that it tells, rad.
    zero_angular_rate : bool
        Whether rest corrects the gyroscope's bias.
    zero_angular_rate_std : float
        Standard deviation of a foot's angular rate at rest, rad/s.
    rest_rate : float
        Angular rate below which the foot may be at rest, rad/s.
    rest_duration : float
        How long the angular rate must have stayed below that, s.
    covariance_interval : float
        While the foot swings the covariance is carried over as many samples at once as take about
        this time, s.  Zero: over one after the other, as with a smoother; the track then differs by
        less than a millimetre in most walks. In the swing `position_std` is right to a thousandth
        of its value unless this is zero.
    """

    kind: Literal["kf", "dr", "ins"] = "kf"
    specific_force_noise: float = 0.1
    angular_rate_noise: float = 1.0e-3
    clipped_noise_factor: float = 30.0
    zero_velocity_std: float = 0.01
    zupt_lever_std: float = 0.03
    zupt_correlation: float = 1.0
    contact_rate: float = 2.0
    chi2_gate: float = 1.0e3
    rejection_limit: float = 0.1
    attitude_update: Literal["none", "gravity", "iaa"] = "none"
    attitude_threshold: float | None = None
    attitude_std: float = 0.01
    zero_angular_rate: bool = True
    zero_angular_rate_std: float = 0.02
    rest_rate: float = 0.05
    rest_duration: float = 0.5
    covariance_interval: float = 0.02


class Magnetometer(Section, frozen=True, kw_only=True):
    """The heading that a magnetometer holds.

    The field of the rest at the start, or else of the first stance with a reading, is what the
    others are held against: once in each stance the heading is corrected, unless strength, dip or
    heading of its field disagree.

    Attributes
    ----------
    heading : bool
        Whether the field holds the heading.  The readings have to be calibrated:
        ``docs/accuracy.md`` tells why.
    std_deg : float
        Standard deviation of the heading that the field of a stance shows, degrees: what bends it
        there and is not seen in its strength and dip.
    strength_tolerance : float
        Share by which the strength of the field may differ from that at the start.
    dip_tolerance_deg : float
        Angle by which its dip may, degrees.
    """

    heading: bool = False
    std_deg: float = 10.0
    strength_tolerance: float = 0.1
    dip_tolerance_deg: float = 5.0


class Correction(Section, frozen=True, kw_only=True):
    """Correction of whole gait cycles, after the filter (Abdulrahim et al.); needs the whole recording.

    The velocity that a stance finds wrong is taken off the swing before it in proportion to time,
    and the position is integrated again.  The uncertainties stay those of the filter.

    Attributes
    ----------
    kind : {"none", "lwi", "rv"}
        Which velocity is taken off: none; the mean over the stance (linearly weighted
        interpolation); that at the first sample of the stance (residual velocity).
    """

    kind: Literal["none", "lwi", "rv"] = "none"


class Smoother(Section, frozen=True, kw_only=True):
    """States estimated from what came later, too.

    Attributes
    ----------
    kind : {"none", "stepwise", "rts"}
        Which later samples are used: none; those of the step (Colomar et al. 2012), which works in
        a stream; all of the recording (Rauch, Tung, Striebel 1965).
    longest_step : float
        Longest step that the step-wise smoother smooths as a whole, s: so much later its states
        come out of a stream.
    """

    kind: Literal["none", "stepwise", "rts"] = "none"
    longest_step: float = 2.0


class HealthLimits(Section, frozen=True, kw_only=True):
    """When the solution is called degraded or invalid.

    Attributes
    ----------
    gap_intervals : float
        Interval that counts as a gap, in nominal intervals.
    memory : float
        How long a gap, a clipped or a refused sample degrades the solution, s.
    degraded_after, invalid_after : float
        Time without a zero velocity after which the solution is degraded, or invalid for good, s.
    longest_gap : float
        Longest gap that is bridged, s.  After a longer one the walk goes on from where it was, but
        is invalid.
    tilt_limit : float
        Roll and pitch uncertainty above which a start in motion still degrades the solution, rad.
    """

    gap_intervals: float = 1.8
    memory: float = 1.0
    degraded_after: float = 3.0
    invalid_after: float = 15.0
    longest_gap: float = 1.0
    tilt_limit: float = 0.03


class Output(Section, frozen=True, kw_only=True):
    """Where the track lies on the Earth and how files are written.

    Attributes
    ----------
    origin : tuple of 3 floats, optional
        Geodetic latitude and longitude in degrees and ellipsoidal height in m of the start.
    frame : {"enu", "ned"}
        Frame of positions, velocities and attitudes in files.
    strides : bool
        Keep the strides as the filter finds them, with the covariance of each: `Trajectory.strides`
        then carries it, and `Navigator.strides` hands them out.
    """

    origin: Vector | None = None
    frame: Literal["enu", "ned"] = "enu"
    strides: bool = False


class Config(Section, frozen=True, kw_only=True, dict=True):
    """All settings; immutable.

    Attributes
    ----------
    sensor : Sensor
        What is known of the inertial measurement unit.
    calibration : Calibration
        Correction of raw readings.
    alignment : Alignment
        The start of the walk.
    mechanization : Mechanization
        The strapdown integration.
    detector : Detector
        The stance detector: the settings of one of the kinds in ``footnav.config.Detector``.
    filter : Filter
        The error-state filter.
    magnetometer : Magnetometer
        The heading that a magnetometer holds.
    correction : Correction
        Correction of whole gait cycles.
    smoother : Smoother
        States estimated from what came later, too.
    health : HealthLimits
        When the solution is called degraded or invalid.
    output : Output
        Where the track lies on the Earth and how files are written.

    Raises
    ------
    ConfigError
        A value has the wrong type, is out of range, or is at odds with another one.

    Examples
    --------
    >>> config = Config(detector=Shoe(threshold=1e4))
    >>> config.replace(alignment=config.alignment.replace(heading_deg=90.0)).alignment.heading_deg
    90.0
    """

    sensor: Sensor = Sensor()
    calibration: Calibration = Calibration()
    alignment: Alignment = Alignment()
    mechanization: Mechanization = Mechanization()
    detector: Detector = AdaptiveShoe()
    filter: Filter = Filter()
    magnetometer: Magnetometer = Magnetometer()
    correction: Correction = Correction()
    smoother: Smoother = Smoother()
    health: HealthLimits = HealthLimits()
    output: Output = Output()

    def __post_init__(self) -> None:
        """Let the core check the values."""
        _core.check_config(self.to_json())

    @classmethod
    def preset(cls, name: str) -> Config:
        """Return the default settings with the figures of a known sensor.

        Parameters
        ----------
        name : str
            "mpu6050", "mti-g710", "stim300", "ngimu" or "vn100".

        Raises
        ------
        ConfigError
            No such preset; the message lists the known ones.
        """
        return decode(_core.preset_config(name), cls)

    @property
    def gravity(self) -> float:
        """Gravity that the settings amount to, m/s²."""
        return _core.gravity(self.to_json())

    def with_heading_from(self, recording: Recording) -> Config:
        """Return the settings with the heading taken from the recording's magnetometer in the rest at its start.

        Raises
        ------
        DataError
            The recording has no magnetometer.
        """
        alignment = self.alignment.replace(
            magnetic_field=recording.mean_magnetic_field(self.alignment.duration), heading_deg=None
        )
        return self.replace(alignment=alignment)

    def to_json(self) -> bytes:
        """Return the settings as the core reads them."""
        return self._json

    @cached_property
    def _json(self) -> bytes:
        return encode(self)

    def save(self, path: str | Path) -> None:
        """Write all settings as TOML; the file is the old one or the whole new one."""
        save_settings(self, path)


DEFAULTS = Config()
"""The settings that need no tuning."""


def load_config(path: str | Path) -> Config:
    """Read settings from a TOML file; absent ones keep their defaults.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Config

    Raises
    ------
    ConfigError
        The file cannot be read, is no TOML, has an unknown key (the message names the nearest known
        one), a value of the wrong type, or one out of range.
    """
    return load_settings(Config, path)
