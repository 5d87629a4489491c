"""The default detector for a stream that must not be late."""

from __future__ import annotations

from typing import TYPE_CHECKING

from footnav import _core
from footnav.settings import Settings, decode

if TYPE_CHECKING:
    from typing_extensions import Self


class LiveDetector(Settings, frozen=True, kw_only=True):
    """Settings of a detector that can look less far ahead."""

    @classmethod
    def live(cls) -> Self:
        """Return the settings for a stream that must not be late by more than 0.3 s.

        Examples
        --------
        >>> config = Config.preset("mpu6050").replace(detector=AdaptiveShoe.live())
        >>> Navigator(config, rate_hz=200.0).latency
        55
        """
        return decode(_core.live_detector(), cls)
