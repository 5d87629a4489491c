"""Guide through the poses of a calibration, from the samples alone.

First the sensor is at rest, which gives its noise and the bias of its gyroscope.  Then each of its
six sides is turned up, in any order, and then it is tilted at different angles, as Tedaldi, Pretto
and Menegatti 2014 ("A robust and easy to implement method for IMU calibration without external
equipments", ICRA) require.  The turns in between calibrate the gyroscope.

The guide is a state machine without a clock or a screen of its own.
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

SQUARE = 15.0
"""Degrees within which an axis counts as up; a board with pins below is tilted by as much."""

APART = 15.0
"""Least difference of two poses, degrees; nearer ones add nothing to a calibration."""

_STEADY = 2.0
"""Degrees by which gravity may turn while a pose is held; the noise of a window's mean is less."""

_TOUCHED = 0.6
"""s; a shorter rest is part of setting the sensor down."""


class Stage(enum.Enum):
    """What the guide waits for."""

    SETTLE = "settle"
    PLACE = "place"
    HOLD = "hold"
    DONE = "done"


@dataclass(frozen=True, slots=True)
class Plan:
    """What makes a calibration complete.

    Attributes
    ----------
    settle : float
        Untouched time at the start, s.
    hold : float
        How long each pose is held, s.
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
        """Check times and number."""
        for label in ("settle", "hold"):
            value = getattr(self, label)
            if not 1 <= value <= 600:
                raise ConfigError(f"{label} is {value:g} s; expected 1 to 600")
        if not 0 <= self.tilts <= 60:
            raise ConfigError(f"tilts is {self.tilts}; expected 0 to 60")


class Guide:
    """State machine that follows the samples and gives the next instruction.

    Parameters
    ----------
    plan : Plan, optional
        What makes the calibration complete.

    Attributes
    ----------
    stage : Stage
        What the guide waits for.
    held : float
        How long the sensor has been at rest in this pose, s.
    up : str
        Side that points up now, or nearly so; "" before the first samples.
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
        self._settled: Floats | None = None

    @property
    def sides(self) -> tuple[str, ...]:
        """Sides that are done, in the order in which they were."""
        return tuple(label for label in self._poses if label in SIDES)

    @property
    def tilts(self) -> int:
        """Number of other poses that are done."""
        return len(self._poses) - len(self.sides)

    @property
    def missing_sides(self) -> tuple[str, ...]:
        """Sides that are still to come."""
        return tuple(side for side in SIDES if side not in self._poses)

    @property
    def progress(self) -> float:
        """Share of the poses that are done, with that of the one that is being held; 0 to 1."""
        if self.stage is Stage.DONE:
            return 1.0
        share = self.held / self.needed if self.stage is not Stage.PLACE else 0.0
        return (len(self._poses) + min(share, 1.0)) / (len(SIDES) + self.plan.tilts)

    @property
    def instruction(self) -> str:
        """What the person is to do now."""
        if self.stage is Stage.DONE:
            return "All poses are done."
        if self.stage is Stage.SETTLE:
            return (
                "Lay the sensor on a firm table, one side flat, and leave it alone "
                f"for {self.plan.settle:g} s."
            )
        if self.stage is Stage.HOLD and self._pose:
            return f"Leave it alone: {_describe(self._pose[0])}."
        if self.missing_sides:
            missing = ", ".join(self.missing_sides)
            return f"Turn it until {self.missing_sides[0]} points up (to come: {missing})."
        return (
            "Lean it at an angle that it did not have before: "
            f"tilt {self.tilts + 1} of {self.plan.tilts}."
        )

    def feed(self, block: Block) -> list[str]:
        """Take the next samples in.

        Parameters
        ----------
        block : Block
            Samples.

        Returns
        -------
        list of str
            What happened, for the person: poses that are done, were repeated, or ended too early.
        """
        return [
            remark for window in self._rest_monitor.feed(block) for remark in self._step(window)
        ]

    @property
    def needed(self) -> float:
        """How long the sensor has to be at rest in this pose, s."""
        return self.plan.settle if self.stage is Stage.SETTLE else self.plan.hold

    def _step(self, window: Window) -> Iterator[str]:
        if self.stage is Stage.DONE:
            return
        # A sensor that reads nothing at all has no side up, and the recorder refuses it.
        direction = window.accel / (np.linalg.norm(window.accel) or 1.0)
        self.up = _nearest_side(direction)[1]
        if not window.at_rest or self._turned(direction):
            yield from self._move()
        elif self._settled is None:
            yield from self._place(direction, window)
        elif self._pose is not None:
            yield from self._hold(window)

    def _turned(self, direction: Floats) -> bool:
        """Whether the sensor creeps, or was turned in a gap of the samples."""
        return self._settled is not None and _angle(self._settled, direction) > _STEADY

    def _move(self) -> Iterator[str]:
        if self._pose is not None and self.held > _TOUCHED:
            yield f"Moved too early: {self.held:.1f} s of {self.needed:g} s.  Once more."
        self._let_go()
        self._settled = None

    def _let_go(self) -> None:
        if self.stage is Stage.HOLD:
            self.stage = Stage.PLACE
        self._pose, self.held = None, 0.0

    def _place(self, direction: Floats, window: Window) -> Iterator[str]:
        """Begin with the pose in which the sensor came to rest, or say why it is of no use."""
        self._settled = direction
        off, side = _nearest_side(direction)
        refusal = self._refusal(side, off, direction)
        if refusal:
            yield refusal
            return
        self._pose = side if off <= SQUARE else f"tilt {self.tilts + 1}", direction
        if self.stage is Stage.PLACE:
            self.stage = Stage.HOLD
        yield from self._hold(window)

    def _refusal(self, side: str, off: float, direction: Floats) -> str | None:
        if self.missing_sides and off > SQUARE:
            return f"No side is up: {side} is off by {off:.0f} degrees.  Set it down more squarely."
        for label, pose in self._poses.items():
            apart = _angle(pose, direction)
            if (label == side and off <= SQUARE) or apart < APART:
                return f"Repeated: this is {label}, within {math.ceil(apart)} degrees."
        return None

    def _hold(self, window: Window) -> Iterator[str]:
        self.held += window.duration
        if self._pose is None or self.held < self.needed:
            return
        label, direction = self._pose
        self._poses[label] = direction
        self.stage = Stage.PLACE
        self._let_go()
        yield f"Done: {_describe(label)}."
        if not self.missing_sides and self.tilts >= self.plan.tilts:
            self.stage = Stage.DONE


def _describe(label: str) -> str:
    return f"{label} up" if label in SIDES else label


def _nearest_side(direction: Floats) -> tuple[float, str]:
    """Return the side that is most nearly up, after how many degrees it is off."""
    return min((_angle(axis, direction), side) for side, axis in _AXES.items())


def _angle(a: Floats, b: Floats) -> float:
    """Angle between two unit vectors, degrees; as steady for small ones as for large (Kahan 2006)."""
    return math.degrees(2 * math.atan2(float(np.linalg.norm(a - b)), float(np.linalg.norm(a + b))))
