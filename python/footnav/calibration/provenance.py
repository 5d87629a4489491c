"""Data that a calibration is based on."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime, timezone
from typing import Any

import numpy as np

from footnav.calibration.model import RANGE_TOLERANCE
from footnav.errors import ConfigError, DataError
from footnav.mpu6050 import Setup
from footnav.recording import STANDARD_GRAVITY, Recording


def as_recordings(recordings: Recording | Sequence[Recording]) -> list[Recording]:
    """Return one or several recordings as a list.

    Raises
    ------
    DataError
        There is none.
    """
    found = [recordings] if isinstance(recordings, Recording) else list(recordings)
    if not found:
        raise DataError("there is no recording to calibrate from")
    return found


def provenance(recordings: Sequence[Recording], sensor: str) -> dict[str, Any]:
    """Return `range`, `temperature` and `date` of a sensor's calibration.

    Parameters
    ----------
    recordings : sequence of Recording
        Recordings that the calibration is based on.
    sensor : {"accel", "gyro", "mag"}
        The sensor.

    Returns
    -------
    dict
        Keywords of `Triad`.

    Raises
    ------
    ConfigError
        The recordings were made at different full scales.
    """
    celsius = [
        float(each.temperature.mean()) for each in recordings if each.temperature is not None
    ]
    return {
        "range": _common_range(recordings, f"{sensor}_range"),
        "temperature": float(np.mean(celsius)) if celsius else None,
        "date": datetime.now(timezone.utc).date().isoformat(),
    }


def check_setup(recordings: Sequence[Recording], setup: Setup | None) -> None:
    """Raise ConfigError if the full scales of recordings and registers differ."""
    if setup is None:
        return
    expected = {
        "accel_range": setup.accel_range_g * STANDARD_GRAVITY,
        "gyro_range": np.radians(setup.gyro_range_deg_s),
    }
    for label, full_scale in expected.items():
        found = _common_range(recordings, label)
        if found is not None and abs(found / full_scale - 1) > RANGE_TOLERANCE:
            raise ConfigError(
                f"{label} of the recording is {found:.4g}, that of the given registers "
                f"{full_scale:.4g}"
            )


def _common_range(recordings: Sequence[Recording], label: str) -> float | None:
    found = [(each.name, getattr(each, label, None)) for each in recordings]
    known = [(name, full_scale) for name, full_scale in found if full_scale is not None]
    for name, full_scale in known[1:]:
        if abs(full_scale / known[0][1] - 1) > RANGE_TOLERANCE:
            raise ConfigError(
                f"{name} has {label} {full_scale:.4g}, but {known[0][0]} has {known[0][1]:.4g}; "
                "calibrate each alone"
            )
    return known[0][1] if known else None
