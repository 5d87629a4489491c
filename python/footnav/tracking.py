"""Batch: a whole recording in, its track out."""

from __future__ import annotations

import dataclasses
import warnings
from typing import TYPE_CHECKING

from footnav.config import Config
from footnav.errors import FootnavError, FootnavWarning
from footnav.health import Health, Reason
from footnav.navigator import Navigator
from footnav.trajectory import Trajectory

if TYPE_CHECKING:
    from collections.abc import Callable

    from footnav.recording import Recording

BLOCK = 100_000
"""Samples between two looks at the keyboard and two reports of progress."""


def track(
    recording: Recording, config: Config | None = None, *, progress: Callable[[float], None] | None = None
) -> Trajectory:
    """Track a whole recording.

    Parameters
    ----------
    recording : Recording
        The samples.  Its full-scale ranges are used where the settings name none.
    config : Config, optional
        Settings; the defaults need no tuning.
    progress : callable, optional
        Called with the share of the samples that is done, 0 to 1.

    Returns
    -------
    Trajectory
        One row per sample.

    Raises
    ------
    ConfigError
        Settings at odds with each other.
    DataError
        The samples cannot be used, or are fewer than the alignment needs.
    NumericalError
        The filter cannot go on.

    Warns
    -----
    FootnavWarning
        Repeated stamps, gaps, clipping or a start in motion: the track is honest, but less certain.
    """
    navigator = Navigator(with_ranges_of(recording, config or Config()), recording.rate_hz)
    try:
        parts = []
        for start in range(0, len(recording), BLOCK):
            rows = slice(start, start + BLOCK)
            parts.append(navigator.push_block(recording.t[rows], recording.accel[rows], recording.gyro[rows]))
            if progress is not None:
                progress(min(1.0, (start + BLOCK) / len(recording)))
        parts.append(navigator.flush())
        navigator._check_aligned()
    except FootnavError as error:
        raise type(error)(f"{recording.name}: {error}" if recording.name else str(error)) from error
    health = navigator.health_of_walk()
    _warn(recording.name, health)
    return dataclasses.replace(Trajectory.concatenate(parts), name=recording.name, health=health)


def with_ranges_of(recording: Recording, config: Config) -> Config:
    """Return the settings with the recording's full-scale ranges where they name none."""
    known = {"accel_range": recording.accel_range, "gyro_range": recording.gyro_range}
    missing = {key: value for key, value in known.items() if value is not None and getattr(config.sensor, key) is None}
    return config.replace(sensor=config.sensor.replace(**missing)) if missing else config


def _warn(name: str, health: Health) -> None:
    counters, reasons = health.counters, health.reasons
    findings = {
        f"{counters.repeated:,} samples repeat the stamp of the one before": counters.repeated,
        f"samples are missing in {counters.gaps:,} place{'s' if counters.gaps > 1 else ''}": counters.gaps,
        f"{counters.clipped:,} samples are clipped at full scale: choose a wider range": counters.clipped,
        "the recording starts in motion: keep the foot still for a second first": Reason.MOVING_START in reasons,
        "the foot was not seen at rest for too long": Reason.NO_ZERO_VELOCITY in reasons,
    }
    sentences = "; ".join(sentence for sentence, found in findings.items() if found)
    if sentences:
        warnings.warn(f"{name}: {sentences}" if name else sentences, FootnavWarning, stacklevel=3)
