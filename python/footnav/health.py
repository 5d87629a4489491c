"""Quality of a track: status, flags and counters."""

from dataclasses import dataclass
from enum import Enum, IntFlag
from typing import Any


class Status(str, Enum):
    """Quality of a track or of the newest state."""

    OK = "OK"
    DEGRADED = "DEGRADED"
    INVALID = "INVALID"

    def __str__(self) -> str:
        """Return the status as a word."""
        return self.value


class Flag(IntFlag):
    """Quality flags of a state, one bit each."""

    ALIGNING = 1
    MOVING_START = 2
    NO_ZERO_VELOCITY = 4
    UPDATES_REJECTED = 8
    GAP = 16
    CLIPPED = 32
    REFUSED = 64
    LOST = 128

    @property
    def status(self) -> Status:
        """Status that follows from the flags."""
        if self & (Flag.ALIGNING | Flag.LOST):
            return Status.INVALID
        return Status.DEGRADED if self else Status.OK

    def describe(self) -> str:
        """Describe the flags in words.

        Returns
        -------
        str
            One sentence for each flag that is set, or "No problems found."
        """
        sentences = [sentence for reason, sentence in _SENTENCES.items() if reason in self]
        return " ".join(sentences) or "No problems found."


_SENTENCES = {
    Flag.ALIGNING: "The initial alignment is not complete.",
    Flag.MOVING_START: "The sensor moved during the initial alignment.",
    Flag.NO_ZERO_VELOCITY: "The foot was not seen at rest for too long.",
    Flag.UPDATES_REJECTED: "Zero-velocity updates were rejected as implausible.",
    Flag.GAP: "Samples are missing.",
    Flag.CLIPPED: "The sensor reached the end of its range.",
    Flag.REFUSED: "Samples that were not finite or out of order were refused.",
    Flag.LOST: (
        "The foot was not seen at rest for too long, or the filter failed: the position is invalid."
    ),
}


@dataclass(frozen=True, slots=True)
class Counters:
    """Counts of samples and of updates.

    Attributes
    ----------
    samples : int
        Samples that were received.
    repeated : int
        Samples whose stamp equals the one before.
    gaps : int
        Intervals in which samples are missing.
    clipped : int
        Samples at the end of the sensor's range.
    refused : int
        Samples that were not used.
    zero_velocity_updates, zero_velocity_rejected : int
        Zero-velocity updates that were applied, and those that the gate rejected.
    zero_angular_rate_updates : int
        Zero-angular-rate updates that were applied.
    magnetic_updates, magnetic_rejected : int
        Stances whose magnetic field corrected the heading, and those in which it disagreed with the
        one at the start.
    """

    samples: int = 0
    repeated: int = 0
    gaps: int = 0
    clipped: int = 0
    refused: int = 0
    zero_velocity_updates: int = 0
    zero_velocity_rejected: int = 0
    zero_angular_rate_updates: int = 0
    magnetic_updates: int = 0
    magnetic_rejected: int = 0

    def __str__(self) -> str:
        """List the counters in one sentence."""
        magnetic = (
            f", {self.magnetic_updates:,} magnetic updates ({self.magnetic_rejected:,} rejected)"
        )
        return (
            f"{self.samples:,} samples: {self.repeated:,} repeated, {self.gaps:,} gaps, "
            f"{self.clipped:,} clipped, "
            f"{self.refused:,} refused; {self.zero_velocity_updates:,} zero-velocity updates "
            f"({self.zero_velocity_rejected:,} rejected), {self.zero_angular_rate_updates:,} "
            "zero-angular-rate updates"
            f"{magnetic if self.magnetic_updates or self.magnetic_rejected else ''}."
        )


@dataclass(frozen=True, slots=True)
class Health:
    """Quality of a run: status, flags and the figures that they are based on.

    Attributes
    ----------
    status : Status
        The status.
    flags : Flag
        Quality flags.
    counters : Counters
        Counts of samples and of updates.
    horizontal_std, vertical_std : float
        Uncertainty of the position, one sigma, in m.
    """

    status: Status
    flags: Flag
    counters: Counters
    horizontal_std: float
    vertical_std: float

    @classmethod
    def of_fields(cls, fields: dict[str, Any]) -> "Health":
        """Convert the fields of the core."""
        flags, counters = Flag(fields["flags"]), Counters(**fields["counters"])
        return cls(flags.status, flags, counters, fields["horizontal_std"], fields["vertical_std"])

    def __str__(self) -> str:
        """Describe the run in one paragraph."""
        return (
            f"{self.status.value}. {self.flags.describe()} {self.counters} "
            f"One sigma: {self.horizontal_std:.2f} m horizontal, {self.vertical_std:.2f} m "
            "vertical."
        )
