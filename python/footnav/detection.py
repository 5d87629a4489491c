"""Stance detection alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias, cast, get_args

from footnav import _core
from footnav.config import Config
from footnav.detectors import Detector
from footnav.errors import ConfigError
from footnav.protocols import StanceDetector
from footnav.settings import Settings, by_kind, unknown_kind

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from footnav.recording import Recording

Choice: TypeAlias = Detector | Config | str | StanceDetector | None


@dataclass(frozen=True, slots=True, eq=False)
class Detection:
    """Result of a stance detector; unpacks as ``statistic, decision``.

    Attributes
    ----------
    t : ndarray of shape (n,)
        Stamps, s.
    statistic, threshold : ndarray of shape (n,)
        The test statistic and the value below which it means stance; NaN where the detector's
        window is not full, and everywhere with a detector of the caller.
    decision : ndarray of bool of shape (n,)
        Whether the foot is classified as at rest on the ground.
    """

    t: NDArray[np.float64]
    statistic: NDArray[np.float64]
    threshold: NDArray[np.float64]
    decision: NDArray[np.bool_]

    def __iter__(self) -> Iterator[NDArray[np.float64] | NDArray[np.bool_]]:
        """Iterate over statistic and decision."""
        return iter((self.statistic, self.decision))


def detect(recording: Recording, detector: Choice = None) -> Detection:
    """Run a stance detector over a recording.

    Parameters
    ----------
    recording : Recording
        The samples.
    detector : Detector, Config, str or StanceDetector, optional
        The detector's settings, such as `footnav.detectors.Shoe`; a configuration with a detector;
        the kind of a detector with its default settings, such as "shoe"; or an object with the
        members of `footnav.protocols.StanceDetector`.  Default: the detector of ``Config()``.

    Returns
    -------
    Detection
        One row per sample.

    Raises
    ------
    ConfigError
        Unknown detector, settings out of range, or an object that is no
        `footnav.protocols.StanceDetector`.
    """
    config, own = _choose(detector)
    columns = _core.detect(
        config.to_json(), recording.rate_hz, recording.t, recording.accel, recording.gyro, own
    )
    return Detection(t=recording.t, **columns)


def _choose(detector: Choice) -> tuple[Config, StanceDetector | None]:
    """Return the settings, and a detector of the caller."""
    if detector is None:
        return Config(), None
    if isinstance(detector, Config):
        return detector, None
    if isinstance(detector, str):
        return Config(detector=_default_detector(detector)), None
    if isinstance(detector, Settings):
        return Config(detector=detector), None
    return Config(), detector


def _default_detector(kind: str) -> Detector:
    """Return the default settings of a kind of detector."""
    kinds = by_kind(get_args(Detector))
    if kind not in kinds:
        raise ConfigError(unknown_kind(f"unknown detector {kind!r}", kind, kinds))
    return cast("Detector", kinds[kind]())
