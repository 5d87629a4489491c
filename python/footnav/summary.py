"""Summary figures of a track."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from footnav.health import Health

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Displacement:
    """The displacement from one point to another.

    Attributes
    ----------
    horizontal : float
        Length in the horizontal plane, m.
    vertical : float
        Climb, m, positive upwards.
    """

    horizontal: float
    vertical: float

    @classmethod
    def of(cls, vector: Floats) -> "Displacement":
        """Convert a vector (3,) in the navigation frame, m."""
        return cls(float(np.hypot(vector[0], vector[1])), float(vector[2]))

    @property
    def spatial(self) -> float:
        """Length in space, m."""
        return float(np.hypot(self.horizontal, self.vertical))

    def percent_of(self, distance: float) -> "Displacement":
        """Express both components in percent of a distance in m; nan where the distance is zero."""
        factor = 100 / distance if distance > 0 else np.nan
        return Displacement(self.horizontal * factor, self.vertical * factor)


@dataclass(frozen=True, slots=True)
class Summary:
    """Summary figures of a track; nan where the track is too short.

    Attributes
    ----------
    name : str
        Name of the track.
    samples : int
        Number of samples.
    duration : float
        From the first to the last sample, s.
    rate_hz : float
        One over the median positive interval, Hz.
    distance : float
        Horizontal length of the strides, m.
    closing, closing_percent : Displacement
        From the first to the last sample, in m and in percent of the distance.
    lowest, highest : float
        Heights at which the foot stood, m.
    strides : int
        Strides of this foot.
    stride_length : float
        Mean horizontal length, m.
    cadence : float
        Strides of this foot in a minute of walking.
    zero_velocity_share : float
        Share of the samples at rest, 0 to 1.
    greatest_speed : float
        m/s.
    horizontal_std, vertical_std : float
        Uncertainty of the last position, one sigma, m; horizontally the root of the sum of both
        variances.
    health : Health or None
        Health of the run.
    """

    name: str
    samples: int
    duration: float
    rate_hz: float
    distance: float
    closing: Displacement
    closing_percent: Displacement
    lowest: float
    highest: float
    strides: int
    stride_length: float
    cadence: float
    zero_velocity_share: float
    greatest_speed: float
    horizontal_std: float
    vertical_std: float
    health: Health | None

    def __str__(self) -> str:
        """Write the summary as a small table."""
        closing, share = self.closing, self.closing_percent
        lines = [
            f"{self.name or 'track'}: {self.samples:,} samples, {self.duration:.2f} s at "
            f"{self.rate_hz:.1f} Hz",
            f"  distance       {self.distance:.2f} m in {self.strides} strides, "
            f"{self.stride_length:.2f} m each, {self.cadence:.1f} a minute",
            f"  start to end   {closing.horizontal:.3f} m ({share.horizontal:.2f} %) horizontal, "
            f"{closing.vertical:+.3f} m ({share.vertical:+.2f} %) vertical, "
            f"{closing.spatial:.3f} m ({share.spatial:.2f} %) in space",
            f"  heights        {self.lowest:.2f} m to {self.highest:.2f} m where the foot stood",
            f"  zero velocity  {100 * self.zero_velocity_share:.1f} % of the samples",
            f"  greatest speed {self.greatest_speed:.2f} m/s",
            f"  one sigma      {self.horizontal_std:.3f} m horizontal, {self.vertical_std:.3f} m "
            "vertical, at the end",
        ]
        if self.health is not None:
            lines.append(f"  health         {self.health}")
        return "\n".join(lines)
