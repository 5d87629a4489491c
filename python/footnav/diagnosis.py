"""Data-quality report of a recording: clipping, gaps, sampling rate and the rest at the start."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footnav import _core
from footnav.config import DEFAULTS, Config
from footnav.health import Flag
from footnav.recording import STANDARD_GRAVITY, Floats, Recording
from footnav.rest_detection import alignment_limits, detect_rest, runs

Mask = NDArray[np.bool_]

CLIP_BAND = 0.005
"""Part of the full scale, or of a flat top, within which a sample is clipped: a calibration spreads
the clipped values."""

ACCEL_RANGES_G = (2, 4, 8, 16, 32)
GYRO_RANGES_DEG_S = (250, 500, 1000, 2000, 4000)

_SENSORS = {"accel": "accelerometer", "gyro": "gyroscope"}
_MIN_CLIP = {"accel": 1.5 * STANDARD_GRAVITY, "gyro": math.radians(100)}
"""No full scale is smaller: the smallest ranges sold are 2 g and 125 deg/s."""

_MIN_RATE = 90.0
"""Hz; a heel strike lasts 20 ms."""

_MAX_SCALE_ERROR = 0.03
"""Part of gravity; a calibrated accelerometer errs by less."""

_MAX_GYRO_BIAS = 2.0
"""deg/s."""


@dataclass(frozen=True, slots=True)
class Clipping:
    """Samples of one channel that are at full scale.

    Attributes
    ----------
    channel : str
        Such as "accel_x".
    level : float
        Magnitude at which it clips, m/s^2 or rad/s.
    samples : int
        Number of clipped samples.
    """

    channel: str
    level: float
    samples: int


@dataclass(frozen=True, slots=True)
class Rest:
    """The rest at the start of a recording.

    Attributes
    ----------
    duration : float
        Length, s; the means and standard deviations are over all of it.
    specific_force : float
        Magnitude of the mean specific force, m/s^2.
    gyro_bias : tuple of float
        Mean of each gyroscope axis, rad/s.
    accel_noise, gyro_noise : tuple of float
        Standard deviation of each axis, m/s^2 and rad/s.
    """

    duration: float
    specific_force: float
    gyro_bias: tuple[float, ...]
    accel_noise: tuple[float, ...]
    gyro_noise: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """Data-quality report of a recording; `str` gives it as text.

    Attributes
    ----------
    name : str
        Name of the recording.
    samples : int
        Number of samples.
    duration : float
        From the first to the last sample, s.
    rate_hz : float
        Sampling rate, Hz.
    jitter : float
        Standard deviation of the intervals, s, without repeated stamps and gaps.
    repeated : int
        Samples with the stamp of the one before.
    gaps : int
        Intervals in which samples are missing, as `footnav.health.Counters` counts them.
    longest_gap, longest_gap_at : float
        Length of the longest gap and the stamp at which it starts, s; nan without gaps.
    clipping : tuple of Clipping
        Channels that clip.
    rest : Rest or None
        The rest at the start; None for a start in motion.
    findings : tuple of str
        Each problem and its remedy.
    """

    name: str
    samples: int
    duration: float
    rate_hz: float
    jitter: float
    repeated: int
    gaps: int
    longest_gap: float
    longest_gap_at: float
    clipping: tuple[Clipping, ...]
    rest: Rest | None
    findings: tuple[str, ...]

    @property
    def at_rest_at_start(self) -> bool:
        """Whether the recording starts at rest."""
        return self.rest is not None

    def __str__(self) -> str:
        """Return the measurements, one a line, and the findings."""
        lines = [
            self.name or "recording",
            f"  samples     {self.samples} in {self.duration:.2f} s, {self.rate_hz:.5g} Hz",
            f"  intervals   jitter {1e3 * self.jitter:.3f} ms, {self._stamps_text()}",
            f"  clipping    {', '.join(map(_clipping_text, self.clipping)) or 'none'}",
            *(_rest_text(self.rest) if self.rest else ["  rest        none at the start"]),
        ]
        return "\n".join(
            lines + [f"- {finding}" for finding in self.findings or ("no problems found",)]
        )

    def _stamps_text(self) -> str:
        text = f"{_count(self.repeated, 'repeated stamp')}, {_count(self.gaps, 'gap')}"
        if not self.gaps:
            return text
        return f"{text}, the longest {1e3 * self.longest_gap:.1f} ms at {self.longest_gap_at:.3f} s"


def diagnose(recording: Recording, config: Config | None = None) -> Diagnosis:
    """Report the quality of a recording before it is tracked.

    Gaps and the rest at the start are found as `footnav.track` finds them.

    Parameters
    ----------
    recording : Recording
        Calibrated samples; they are not changed.
    config : Config, optional
        Settings of the track, of which ``alignment`` and ``health`` count; the defaults unless
        given.

    Returns
    -------
    Diagnosis
        Measurements, and the problems with their remedies.
    """
    config = config or DEFAULTS
    intervals = np.diff(recording.t)
    gap = _gaps(recording, config)
    longest = int(intervals.argmax()) if gap.any() else None
    clipped = {sensor: _clipped(recording, sensor) for sensor in _SENSORS}
    rest = _rest(recording, config)
    repeated = int((intervals == 0).sum())
    return Diagnosis(
        name=recording.name,
        samples=len(recording),
        duration=recording.duration,
        rate_hz=recording.rate_hz,
        jitter=float(intervals[(intervals > 0) & ~gap].std()),
        repeated=repeated,
        gaps=int(gap.sum()),
        longest_gap=math.nan if longest is None else float(intervals[longest]),
        longest_gap_at=math.nan if longest is None else float(recording.t[longest]),
        clipping=tuple(
            clip for sensor in _SENSORS for clip in _clipping(recording, sensor, clipped[sensor])
        ),
        rest=rest,
        findings=(
            *(
                _clipping_finding(recording, sensor, mask)
                for sensor, mask in clipped.items()
                if mask.any()
            ),
            *_time_findings(recording, repeated, intervals[gap]),
            *_rest_findings(rest),
        ),
    )


def _clipped(recording: Recording, sensor: str) -> Mask:
    """Return which values of a sensor, shape (n, 3), are at full scale."""
    samples: Floats = getattr(recording, sensor)
    full_scale: float | None = getattr(recording, f"{sensor}_range")
    if full_scale is not None:
        return np.abs(samples) >= (1 - CLIP_BAND) * full_scale
    return np.column_stack([_flat_tops(channel, _MIN_CLIP[sensor]) for channel in samples.T])


def _flat_tops(channel: Floats, min_clip: float) -> Mask:
    """Return which values are clipped, from the shape of the signal alone."""
    clipped = np.zeros(len(channel), dtype=bool)
    for side in (channel, -channel):
        if side.max() >= min_clip and _has_flat_top(side):
            clipped |= side >= (1 - CLIP_BAND) * side.max()
    return clipped


def _has_flat_top(channel: Floats) -> bool:
    """Whether the maximum is a flat top: held twice or more, for three samples, with steep flanks.

    A smooth peak of curvature c leaves its top band of half-width h by c h^2: three half-widths
    away from its middle it has fallen by nine bands, 4.5 %.  A clipped wave is on its steep flank
    there and has fallen by far more, and a steady turn, whose maximum is noise, by far less.
    """
    peak = float(channel.max())
    starts, ends = runs(channel >= (1 - CLIP_BAND) * peak)
    length = ends - starts
    inside = (length >= 3) & (starts >= length) & (ends + length <= len(channel))
    starts, ends, length = starts[inside], ends[inside], length[inside]
    flanks = np.maximum(channel[starts - length], channel[ends + length - 1])
    return int((flanks < 0.85 * peak).sum()) >= 2


def _gaps(recording: Recording, config: Config) -> Mask:
    """Return in which intervals samples are missing, shape (n - 1,)."""
    flags = _core.sample_flags(
        config.to_json(), recording.rate_hz, recording.t, recording.accel, recording.gyro
    )
    gaps: Mask = (flags[1:] & Flag.GAP) != 0
    return gaps


def _rest(recording: Recording, config: Config) -> Rest | None:
    """Return the rest at the start, or None where it is too short for the alignment."""
    limits = alignment_limits(config)
    blocks = detect_rest(recording, limits)
    rests = blocks.rests()
    if not rests or rests[0].start > 0:
        return None
    last = int(blocks.last[rests[0].stop - 1])
    duration = float(recording.t[last] - recording.t[0])
    if duration < limits.min_duration:
        return None
    accel, gyro = recording.accel[: last + 1], recording.gyro[: last + 1]
    return Rest(
        duration=duration,
        specific_force=float(np.linalg.norm(accel.mean(axis=0))),
        gyro_bias=_floats(gyro.mean(axis=0)),
        accel_noise=_floats(accel.std(axis=0)),
        gyro_noise=_floats(gyro.std(axis=0)),
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _floats(values: Floats) -> tuple[float, ...]:
    return tuple(map(float, values))


def _clipping(recording: Recording, sensor: str, clipped: Mask) -> list[Clipping]:
    samples: Floats = getattr(recording, sensor)
    return [
        Clipping(
            f"{sensor}_{'xyz'[axis]}",
            _level(recording, sensor, samples[mask, axis]),
            int(mask.sum()),
        )
        for axis, mask in enumerate(clipped.T)
        if mask.any()
    ]


def _level(recording: Recording, sensor: str, clipped: Floats) -> float:
    """Return the magnitude at which clipped values stand."""
    full_scale: float | None = getattr(recording, f"{sensor}_range")
    return float(np.abs(clipped).max()) if full_scale is None else full_scale


def _clipping_finding(recording: Recording, sensor: str, clipped: Mask) -> str:
    level = _level(recording, sensor, getattr(recording, sensor)[clipped])
    channels = ", ".join("xyz"[axis] for axis in np.flatnonzero(clipped.any(axis=0)))
    return (
        f"the {_SENSORS[sensor]} clips at {_level_text(sensor, level)} "
        f"in {_count(int(clipped.any(axis=1).sum()), 'sample')} ({channels}): "
        f"choose a range of {_wider_range(sensor, level)} or more"
    )


def _level_text(sensor: str, level: float) -> str:
    if sensor == "accel":
        return f"{level:.1f} m/s^2"
    return f"{math.degrees(level):.0f} deg/s"


def _wider_range(sensor: str, level: float) -> str:
    """Name the next full scale that does not clip a walking foot."""
    if sensor == "accel":
        return f"{_next(ACCEL_RANGES_G, max(level / STANDARD_GRAVITY, 4))} g"
    return f"{_next(GYRO_RANGES_DEG_S, max(math.degrees(level), 500))} deg/s"


def _next(ranges: tuple[int, ...], level: float) -> int:
    """Return the first range that is plainly above `level`, or twice the level beyond the last."""
    return next(
        (full_scale for full_scale in ranges if full_scale > 1.1 * level), math.ceil(2 * level)
    )


def _time_findings(recording: Recording, repeated: int, gaps: Floats) -> list[str]:
    findings = []
    if repeated:
        findings.append(
            f"{_count(repeated, 'sample')} with the stamp of the one before: the logger stamps on "
            "arrival or writes rows twice; stamp each sample where it is taken"
        )
    if gaps.size:
        findings.append(
            f"{_count(gaps.size, 'gap')} of {gaps.sum():.2f} s in {recording.duration:.2f} s: "
            "samples were lost or stamped late; lower the load on the logger or its link"
        )
    if recording.rate_hz < _MIN_RATE:
        rate = f"{recording.rate_hz:.3g} Hz"
        findings.append(
            f"{rate} is slow for a heel strike, which lasts 20 ms: record at 100 Hz or more"
        )
    return findings


def _rest_findings(rest: Rest | None) -> list[str]:
    if rest is None:
        return [
            "the recording starts in motion: stand still for a second or more before the first step"
        ]
    findings = []
    error = rest.specific_force / STANDARD_GRAVITY - 1
    if abs(error) > _MAX_SCALE_ERROR:
        findings.append(
            f"at rest the accelerometer reads {rest.specific_force:.2f} m/s^2, "
            f"{100 * error:+.1f} % from gravity: calibrate it, and check its range"
        )
    bias = math.degrees(max(map(abs, rest.gyro_bias)))
    if bias > _MAX_GYRO_BIAS:
        findings.append(
            f"at rest the gyroscope reads {bias:.1f} deg/s: calibrate its bias, or let it warm up"
        )
    return findings


def _clipping_text(clip: Clipping) -> str:
    level = _level_text(clip.channel[:-2], clip.level)
    return f"{clip.channel} {_count(clip.samples, 'sample')} at {level}"


def _rest_text(rest: Rest) -> list[str]:
    bias, noise = ([math.degrees(value) for value in v] for v in (rest.gyro_bias, rest.gyro_noise))
    return [
        f"  rest        {rest.duration:.2f} s at the start, "
        f"|accel| {rest.specific_force:.3f} m/s^2 "
        f"({rest.specific_force / STANDARD_GRAVITY:.4f} g)",
        f"  gyro bias   {_triad(bias, '+.3f')} deg/s at rest",
        f"  noise       accel {_triad(rest.accel_noise, '.3f')} m/s^2, "
        f"gyro {_triad(noise, '.3f')} deg/s",
    ]


def _triad(values: tuple[float, ...] | list[float], form: str) -> str:
    return " ".join(format(value, form) for value in values)
