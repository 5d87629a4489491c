"""Batch: a whole recording in, its track out."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from footnav import _core
from footnav.config import DEFAULTS, Config
from footnav.errors import ConfigError, DataError, FootnavError, FootnavWarning
from footnav.health import Flag, Health
from footnav.navigator import placed
from footnav.steps import Steps
from footnav.trajectory import Trajectory

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from footnav.recording import Recording
    from footnav.stance import StanceDetector

BLOCK = 20_000
"""Samples between two looks at the keyboard and two reports of progress."""


def track(
    recording: Recording,
    config: Config | None = None,
    *,
    stationary: ArrayLike | None = None,
    detector: StanceDetector | None = None,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Track a whole recording.

    Parameters
    ----------
    recording : Recording
        The samples.  Its full-scale ranges are used where the settings name none, its magnetometer
        if the settings ask for it.
    config : Config, optional
        Settings; the defaults need no tuning.
    stationary : array_like of bool of shape (n,), optional
        Where the foot is at rest on the ground, sample by sample: decided by the caller instead of
        a detector.
    detector : StanceDetector, optional
        A stance detector of one's own instead of the one that the settings name; what it raises
        comes out of here.
    progress : callable, optional
        Called with the share of the samples that is done, 0 to 1, and with 1 again while a smoother
        goes back over them; what it raises ends the work.

    Returns
    -------
    Trajectory
        One row per sample.

    Raises
    ------
    ConfigError
        Settings at odds with each other, both `stationary` and `detector`, or a detector that is no
        `footnav.StanceDetector`.
    DataError
        The samples cannot be used, or are fewer than the alignment needs; a magnetometer is to hold
        the heading, and there is none; `stationary` is not a bool for each; a smoother or a
        correction found no stance to go by.
    NumericalError
        The filter cannot go on.

    Warns
    -----
    FootnavWarning
        Repeated stamps, gaps, clipping or a start in motion: the track is honest, but less certain.
    """
    trajectory = track_quietly(
        recording, config or DEFAULTS, stationary=stationary, detector=detector, progress=progress
    )
    if trajectory.health is not None:
        _warn(recording.name, trajectory.health)
    return trajectory


def track_quietly(
    recording: Recording,
    config: Config,
    *,
    stationary: ArrayLike | None = None,
    detector: StanceDetector | None = None,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Track a whole recording and leave what speaks against the track to its health; see `track`."""
    config = with_ranges_of(recording, config)
    report = progress or (lambda _: None)
    mag = recording.mag if config.magnetometer.heading else None
    try:
        batch = _batch(recording, config, stationary, detector)
        for start in range(0, len(recording), BLOCK):
            rows = slice(start, start + BLOCK)
            field = None if mag is None else mag[rows]
            batch.push_block(recording.t[rows], recording.accel[rows], recording.gyro[rows], field)
            report(min(1.0, (start + BLOCK) / len(recording)))
        columns, fields, strides = batch.finish(lambda: report(1.0))
    except FootnavError as error:
        if recording.name:
            error.args = (f"{recording.name}: {error}",)
        raise
    steps = None if strides is None else Steps(**strides)
    health = Health.of_fields(fields)
    return Trajectory.of_core(
        columns, **placed(config), name=recording.name, health=health, filter_steps=steps
    )


def _batch(
    recording: Recording,
    config: Config,
    stationary: ArrayLike | None,
    detector: StanceDetector | None,
) -> _core.Batch:
    if stationary is None:
        return _core.Batch(config.to_json(), recording.rate_hz, detector)
    if detector is not None:
        raise ConfigError(
            "stationary and detector both decide where the foot is at rest: keep one of them"
        )
    return _core.Batch(
        config.to_json(), recording.rate_hz, stationary=_decisions(stationary, len(recording))
    )


def _decisions(stationary: ArrayLike, samples: int) -> list[bool]:
    """Return one bool for each sample, or say what is wrong with what was given."""
    decisions = np.asarray(stationary)
    if decisions.dtype != np.bool_:
        raise DataError(f"stationary is an array of {decisions.dtype}; expected bool")
    if decisions.shape != (samples,):
        raise DataError(
            f"stationary has shape {decisions.shape}; expected ({samples},), one bool for each sample"
        )
    values: list[bool] = decisions.tolist()
    return values


def with_ranges_of(recording: Recording, config: Config) -> Config:
    """Return the settings with the recording's full-scale ranges where they name none."""
    known = {"accel_range": recording.accel_range, "gyro_range": recording.gyro_range}
    missing = {
        key: value
        for key, value in known.items()
        if value is not None and getattr(config.sensor, key) is None
    }
    return config.replace(sensor=config.sensor.replace(**missing)) if missing else config


def _warn(name: str, health: Health) -> None:
    counters, flags = health.counters, health.flags
    bent, stances = (
        counters.magnetic_rejected,
        counters.magnetic_updates + counters.magnetic_rejected,
    )
    findings = {
        f"{counters.repeated:,} samples repeat the stamp of the one before": counters.repeated,
        f"samples are missing in {counters.gaps:,} place{'s' if counters.gaps > 1 else ''}": counters.gaps,
        f"{counters.clipped:,} samples are clipped at full scale: choose a wider range": counters.clipped,
        f"in {bent:,} of {stances:,} stances the magnetic field disagreed with that at the start and was not used: "
        "calibrate the magnetometer, and start away from iron": bent > stances / 2,
        "the recording starts in motion: keep the foot still for a second first": Flag.MOVING_START
        in flags,
        "the foot was not seen at rest for too long": Flag.NO_ZERO_VELOCITY in flags,
    }
    sentences = "; ".join(sentence for sentence, found in findings.items() if found)
    if sentences:
        warnings.warn(f"{name}: {sentences}" if name else sentences, FootnavWarning, stacklevel=3)
