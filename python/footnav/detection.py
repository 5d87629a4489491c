"""Stance detectors on their own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, get_args

from footnav import _core
from footnav.config import Config, Detector
from footnav.errors import ConfigError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from footnav.recording import Recording


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """What a stance detector found; unpacks as ``statistic, decision``.

    Attributes
    ----------
    t : ndarray of shape (n,)
        Stamps, s.
    statistic, threshold : ndarray of shape (n,)
        The test statistic and the value below which it means stance; NaN where the detector's window is not full.
    decision : ndarray of bool of shape (n,)
        Whether the foot is taken to be at rest on the ground.
    """

    t: NDArray[np.float64]
    statistic: NDArray[np.float64]
    threshold: NDArray[np.float64]
    decision: NDArray[np.bool_]

    def __iter__(self) -> Iterator[NDArray[np.float64] | NDArray[np.bool_]]:
        """Give statistic and decision."""
        return iter((self.statistic, self.decision))


def detect(recording: Recording, detector: Detector | Config | str | None = None) -> Detection:
    """Run a stance detector over a recording.

    Parameters
    ----------
    recording : Recording
        The samples.
    detector : AdaptiveShoe, Shoe, MagnitudeVariance, Config or str, optional
        The detector's settings, a configuration that holds them, or the kind of a detector with its default settings.
        Default: the detector of ``Config()``.

    Returns
    -------
    Detection
        One row per sample.

    Raises
    ------
    ConfigError
        Unknown detector, or settings out of range.
    """
    config = _config(detector)
    columns = _core.detect(config.to_json(), recording.rate_hz, recording.t, recording.accel, recording.gyro)
    return Detection(t=recording.t, **columns)


def _config(detector: Detector | Config | str | None) -> Config:
    if detector is None:
        return Config()
    if isinstance(detector, Config):
        return detector
    if isinstance(detector, str):
        known = {choice.__struct_config__.tag: choice for choice in get_args(Detector)}
        if detector not in known:
            msg = f"unknown detector {detector!r}: the known ones are {', '.join(map(str, known))}"
            raise ConfigError(msg)
        return Config(detector=known[detector]())
    return Config(detector=detector)
