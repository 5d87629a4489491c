"""Batch processing of a whole recording."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING

import numpy as np

from footnav import _core
from footnav.config import DEFAULTS, Config
from footnav.errors import DataError, FootnavError, FootnavWarning
from footnav.georeference import georeference
from footnav.health import Flag, Health
from footnav.strides import Strides
from footnav.trajectory import Trajectory

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike
    from typing_extensions import TypeIs

    from footnav.protocols import StanceDetector
    from footnav.recording import Recording

BLOCK = 20_000
"""Samples between two checks for interrupts and two reports of progress."""


def track(
    recording: Recording,
    config: Config | None = None,
    *,
    detector: StanceDetector | ArrayLike | None = None,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Track a whole recording.

    Parameters
    ----------
    recording : Recording
        The samples.  Its full-scale ranges apply where the settings have none, its magnetometer if
        the settings ask for it.
    config : Config, optional
        Settings; the defaults need no tuning.
    detector : StanceDetector or array_like of bool of shape (n,), optional
        Takes the place of the detector that the settings name: an object with the members of
        `footnav.protocols.StanceDetector`, whose exceptions propagate, or one decision for each
        sample, True where the foot is at rest on the ground.
    progress : callable, optional
        Called with the share of the samples that is done, 0 to 1, and with 1 again during the
        backward pass of a smoother; an exception that it raises cancels the run.

    Returns
    -------
    Trajectory
        One row per sample.

    Raises
    ------
    ConfigError
        Settings are inconsistent, or an object is not a `StanceDetector`.
    DataError
        The samples cannot be used, or are fewer than the alignment needs; the settings ask for a
        magnetometer, and there is none; `detector` is an array of another type or length; a
        smoother or a correction found no stance.
    NumericalError
        The filter failed.

    Warns
    -----
    FootnavWarning
        Repeated stamps, gaps, clipping or a start in motion: the track is less certain.
    """
    trajectory = track_quietly(recording, config or DEFAULTS, detector=detector, progress=progress)
    if trajectory.health is not None:
        _warn(recording.name, trajectory.health)
    return trajectory


def track_quietly(
    recording: Recording,
    config: Config,
    *,
    detector: StanceDetector | ArrayLike | None = None,
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Track a whole recording without warnings, which are flags of its health; see `track`."""
    config = with_ranges_of(recording, config)
    report = progress or (lambda _: None)
    mag = recording.mag if config.magnetometer.heading else None
    try:
        batch = _batch(recording, config, detector)
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
    health = Health.of_fields(fields)
    return Trajectory.of_core(
        columns,
        **georeference(config)._asdict(),
        name=recording.name,
        health=health,
        filter_strides=None if strides is None else Strides(**strides),
    )


def _batch(
    recording: Recording, config: Config, detector: StanceDetector | ArrayLike | None
) -> _core.Batch:
    if _is_array(detector):
        decisions = _decisions(detector, len(recording))
        return _core.Batch(config.to_json(), recording.rate_hz, stationary=decisions)
    return _core.Batch(config.to_json(), recording.rate_hz, detector)


def _is_array(detector: StanceDetector | ArrayLike | None) -> TypeIs[ArrayLike]:
    return hasattr(detector, "__array__") or isinstance(detector, list | tuple)


def _decisions(detector: ArrayLike, samples: int) -> list[bool]:
    """Return one bool for each sample, or raise DataError."""
    decisions = np.asarray(detector)
    if decisions.dtype != np.bool_:
        raise DataError(f"detector is an array of {decisions.dtype}; expected bool")
    if decisions.shape != (samples,):
        raise DataError(
            f"detector has shape {decisions.shape}; expected ({samples},), one bool for each sample"
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
        f"in {bent:,} of {stances:,} stances the magnetic field disagreed with that at the start "
        "and was not used: "
        "calibrate the magnetometer, and start away from iron": bent > stances / 2,
        "the recording starts in motion: keep the foot still for a second first": Flag.MOVING_START
        in flags,
        "the foot was not seen at rest for too long": Flag.NO_ZERO_VELOCITY in flags,
    }
    sentences = "; ".join(sentence for sentence, found in findings.items() if found)
    if sentences:
        warnings.warn(f"{name}: {sentences}" if name else sentences, FootnavWarning, stacklevel=3)
