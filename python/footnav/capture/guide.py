"""Guide through the poses of a calibration.

First the sensor is at rest, which gives its noise and the bias of its gyroscope.  Then each of its
six sides is turned up, in any order, and then it is tilted to distinct angles, as Tedaldi, Pretto
and Menegatti 2014 ("A robust and easy to implement method for IMU calibration without external
equipments", ICRA) require.  The rotations between the poses are recorded, too, because they
calibrate the gyroscope.

The guide is a state machine driven by samples, without a clock or terminal output.
"""

import enum
import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from footnav.capture.block import Block
from footnav.capture.rest_detection import RestMonitor, Window
from footnav.errors import ConfigError
from footnav.recording import Floats

SIDES = ("+x", "-x", "+y", "-y", "+z", "-z")
"""Axis of the sensor that points up."""

_AXES = dict(zip(SIDES, np.kron(np.eye(3), [[1.0], [-1.0]]), strict=True))

SIDE_TOLERANCE = 15.0
"""Degrees within which an axis counts as up; a board with pins below is tilted by up to that."""

MIN_SEPARATION = 15.0
"""Minimum angle between two poses, degrees; nearer ones add no information."""

_MAX_DRIFT = 2.0
"""Degrees by which the direction may change within a pose: noise changes the mean of a window by
less.
"""

_MIN_REST = 0.6
"""s; a shorter rest is part of placing the sensor."""


class Stage(enum.Enum):
    """State of the guide."""

    SETTLE = "settle"
    PLACE = "place"
    HOLD = "hold"
    DONE = "done"


@dataclass(frozen=True, slots=True)
class Plan:
    """Poses of a complete calibration.

    Attributes
    ----------
    settle : float
        Rest at the start, s.
    hold : float
        Duration of each pose, s.
    tilts : int
        Number of poses besides the six sides.

    Raises
    ------
    ConfigError
        A time or the number is out of range.
    """

    settle: float = 20.0
    hold: float = 3.0
    tilts: int = 12

    def __post_init__(self) -> None:
        """Validate the limits."""
        for label in ("settle", "hold"):
            value = getattr(self, label)
            if not 1 <= value <= 600:
                raise ConfigError(f"{label} is {value:g} s; expected 1 to 600")
        if not 0 <= self.tilts <= 60:
            raise ConfigError(f"tilts is {self.tilts}; expected 0 to 60")


class Guide:
    """Tracks the poses in the samples and gives the next instruction.

    Parameters
    ----------
    plan : Plan, optional
        Poses of a complete calibration.

    Attributes
    ----------
    stage : Stage
        State of the guide.
    held : float
        Time at rest in this pose, s.
    up : str
        Side that points nearly up; "" before the first samples.
    """

    stage: Stage
    held: float
    up: str

    def __init__(self, plan: Plan | None = None) -> None:
        self.plan = plan or Plan()
        self.stage = Stage.SETTLE
        self.held = 0.0
        self.up = ""
        self._rest_monitor = RestMonitor()
        self._poses: dict[str, Floats] = {}
        self._pose: tuple[str, Floats] | None = None
        self._rest_direction: Floats | None = None

    @property
    def sides(self) -> tuple[str, ...]:
        """Completed sides, in the order of completion."""
        return tuple(label for label in self._poses if label in SIDES)

    @property
    def tilts(self) -> int:
        """Number of completed tilts."""
        return len(self._poses) - len(self.sides)

    @property
    def missing_sides(self) -> tuple[str, ...]:
        """Remaining sides."""
        return tuple(side for side in SIDES if side not in self._poses)

    @property
    def progress(self) -> float:
        """Completed share of the poses, with that of the current one; 0 to 1."""
        if self.stage is Stage.DONE:
            return 1.0
        share = self.held / self.needed if self.stage is not Stage.PLACE else 0.0
        return (len(self._poses) + min(share, 1.0)) / (len(SIDES) + self.plan.tilts)

    @property
    def instruction(self) -> str:
        """Current instruction."""
        if self.stage is Stage.DONE:
            return "All poses are done."
        if self.stage is Stage.SETTLE:
            return (
                "Place the sensor on a firm table, one side flat, and do not touch it for "
                f"{self.plan.settle:g} s."
            )
        if self.stage is Stage.HOLD and self._pose:
            return f"Do not touch it: {_describe(self._pose[0])}."
        if self.missing_sides:
            return (
                f"Turn it until {self.missing_sides[0]} points up (remaining: "
                f"{', '.join(self.missing_sides)})."
            )
        return f"Tilt it to a new angle: tilt {self.tilts + 1} of {self.plan.tilts}."

    def feed(self, block: Block) -> list[str]:
        """Process the next samples.

        Parameters
        ----------
        block : Block
            Samples.

        Returns
        -------
        list of str
            Messages: poses that are completed, were repeated, or ended too early.
        """
        return [
            message for window in self._rest_monitor.feed(block) for message in self._step(window)
        ]

    @property
    def needed(self) -> float:
        """Required time at rest in this pose, s."""
        return self.plan.settle if self.stage is Stage.SETTLE else self.plan.hold

    def _step(self, window: Window) -> Iterator[str]:
        if self.stage is Stage.DONE:
            return
        # A sensor that reads zero has no side up; the recorder rejects it.
        direction = window.accel / (np.linalg.norm(window.accel) or 1.0)
        self.up = _nearest_side(direction)[1]
        if not window.at_rest or self._turned(direction):
            yield from self._move()
        elif self._rest_direction is None:
            yield from self._place(direction, window)
        elif self._pose is not None:
            yield from self._hold(window)

    def _turned(self, direction: Floats) -> bool:
        """Whether the sensor rotates slowly, or was turned in a gap of the samples."""
        return (
            self._rest_direction is not None
            and _angle(self._rest_direction, direction) > _MAX_DRIFT
        )

    def _move(self) -> Iterator[str]:
        if self._pose is not None and self.held > _MIN_REST:
            yield f"Moved too early: {self.held:.1f} s of {self.needed:g} s.  Repeat the pose."
        self._end_pose()
        self._rest_direction = None

    def _end_pose(self) -> None:
        if self.stage is Stage.HOLD:
            self.stage = Stage.PLACE
        self._pose, self.held = None, 0.0

    def _place(self, direction: Floats, window: Window) -> Iterator[str]:
        """Start the pose in which the sensor came to rest, or give the reason for its rejection."""
        self._rest_direction = direction
        off, side = _nearest_side(direction)
        refusal = self._refusal(side, off, direction)
        if refusal:
            yield refusal
            return
        self._pose = side if off <= SIDE_TOLERANCE else f"tilt {self.tilts + 1}", direction
        if self.stage is Stage.PLACE:
            self.stage = Stage.HOLD
        yield from self._hold(window)

    def _refusal(self, side: str, off: float, direction: Floats) -> str | None:
        if self.missing_sides and off > SIDE_TOLERANCE:
            return f"No side is up: {side} is off by {off:.0f} degrees.  Place it flat on a side."
        for label, pose in self._poses.items():
            apart = _angle(pose, direction)
            if (label == side and off <= SIDE_TOLERANCE) or apart < MIN_SEPARATION:
                return f"Repeated: this is {label}, within {math.ceil(apart)} degrees."
        return None

    def _hold(self, window: Window) -> Iterator[str]:
        self.held += window.duration
        if self._pose is None or self.held < self.needed:
            return
        label, direction = self._pose
        self._poses[label] = direction
        self.stage = Stage.PLACE
        self._end_pose()
        yield f"Done: {_describe(label)}."
        if not self.missing_sides and self.tilts >= self.plan.tilts:
            self.stage = Stage.DONE


def _describe(label: str) -> str:
    return f"{label} up" if label in SIDES else label


def _nearest_side(direction: Floats) -> tuple[float, str]:
    """Return the angle of the most nearly vertical side, degrees, and the side."""
    return min((_angle(axis, direction), side) for side, axis in _AXES.items())


def _angle(a: Floats, b: Floats) -> float:
    """Angle between two unit vectors, degrees; accurate for small and large angles (Kahan 2006)."""
    return math.degrees(2 * math.atan2(float(np.linalg.norm(a - b)), float(np.linalg.norm(a + b))))
