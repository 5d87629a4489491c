"""Experiments: walks, approaches and figures.

Walks, the approaches that are tried on them, and the figure that the paper gives for each.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeAlias

import numpy as np

from footnav.config import Alignment, Filter
from footnav.evaluation import evaluate
from footnav.simulation import Gait, Route, SensorErrors, simulate

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from footnav.config import Config
    from footnav.recording import Recording
    from footnav.trajectory import Trajectory

JOGGING = 2.0
"""Speed from which a person runs, m/s."""
JOG_DURATION = 0.9
"""Stride of a slow jog, s."""

ZUPT_ALONE = Filter(
    zero_angular_rate=False, contact_rate=0.0, angular_rate_noise=6.0e-4, covariance_interval=0.0
)
"""Common settings of the papers' filters: zero-velocity updates only.
"""


@dataclass(frozen=True, slots=True, eq=False)
class Walk:
    """A recording and its truth.

    Attributes
    ----------
    recording : Recording
        The samples.
    truth : (n, 3) ndarray, optional
        Positions, n, m, one for each sample; None for a walk of which it is only known that it ends
        where it began.
    """

    recording: Recording
    truth: NDArray[np.float64] | None


class Walks(Protocol):
    """Source of the walks of an experiment."""

    def count(self, seeds: int) -> int:
        """Return the number of walks for `seeds` of each simulated one."""

    def load(self, number: int) -> Walk:
        """Return one of them, by its number from 0."""


@dataclass(frozen=True, slots=True)
class Simulated:
    """One walk along a route for each seed.

    Attributes
    ----------
    route : Route
        The route.
    gait : Gait
        How.
    sensor : SensorErrors
        The sensor.
    rate_hz : float
        Samples per second.
    """

    route: Route
    gait: Gait
    sensor: SensorErrors
    rate_hz: float

    def count(self, seeds: int) -> int:
        """Return `seeds`."""
        return seeds

    def load(self, number: int) -> Walk:
        """Simulate the walk whose seed is `number`."""
        recording, truth = simulate(
            self.route, self.gait, self.sensor, number, rate_hz=self.rate_hz
        )
        return Walk(recording, truth.position)


Measure: TypeAlias = Callable[["Trajectory", Walk], float]


def closing_error(track: Trajectory, walk: Walk) -> float:
    """Return how far the end of a track lies from that of the truth in the horizontal plane, m."""
    displacement = track.position[-1] - track.position[0]
    true_displacement = np.zeros(3) if walk.truth is None else walk.truth[-1] - walk.truth[0]
    return float(np.hypot(*(displacement - true_displacement)[:2]))


def armse(track: Trajectory, walk: Walk) -> float:
    """Return the ARMSE of a track against the whole truth, m."""
    return evaluate(track, np.asarray(walk.truth)).armse


@dataclass(frozen=True, slots=True)
class Approach:
    """One way of tracking the walks.

    Attributes
    ----------
    name : str
        Name of the approach.
    config : Config
        Its settings.
    paper : float, optional
        Figure of the paper, in the unit of the experiment.
    limit : float, optional
        Greatest median that agrees with the paper, in that unit.
    ranges_known : bool
        Whether the filter knows the full-scale ranges, and so which samples are clipped.
    note : str
        Remarks.
    """

    name: str
    config: Config
    paper: float | None = None
    limit: float | None = None
    ranges_known: bool = True
    note: str = ""


@dataclass(frozen=True, slots=True)
class Experiment:
    """Walks, and the approaches that are tried on them.

    Attributes
    ----------
    paper : str
        "P1" to "P4".
    title : str
        The route and the sensor.
    walks : Walks
        The walks.
    approaches : tuple of Approach
        How they are tracked.
    distance : float, optional
        Nominal length, m; None where the walks differ.
    unit : {"%", "m"}
        Percent of `distance`, or m.
    measure : callable
        Error of a track, m.
    note : str
        Remarks.
    """

    paper: str
    title: str
    walks: Walks
    approaches: tuple[Approach, ...]
    distance: float | None = None
    unit: Literal["%", "m"] = "m"
    measure: Measure = field(default=closing_error)
    note: str = ""

    def figure(self, track: Trajectory, walk: Walk) -> float:
        """Return the error of a track in the unit of the experiment."""
        error = self.measure(track, walk)
        return 100 * error / self.distance if self.unit == "%" and self.distance else error


def gait_at(speed: float, **changes: float) -> Gait:
    """Return a gait for a speed; corners are rounded.

    Up to 2 m/s stride length and cadence share the change of speed equally; from there on it is a
    slow jog with a stride of 0.9 s, since a simulated foot that runs faster is accelerated more
    than a real one.

    Parameters
    ----------
    speed : float
        m/s.
    **changes : float
        Other parameters of the gait.

    Returns
    -------
    Gait
        The gait.
    """
    if speed >= JOGGING:
        gait, duration = Gait.preset("run"), JOG_DURATION
    else:
        gait = Gait.preset("walk")
        duration = gait.stride_duration * math.sqrt(
            gait.stride_length / gait.stride_duration / speed
        )
    return gait.replace(
        stride_length=speed * duration, stride_duration=duration, sharpest_curve=2.0, **changes
    )


def standing(duration: float, **settings: Any) -> Alignment:
    """Return an alignment on a person who stands, s.

    A foot on the ground sways without turning away, so the mean of its rate falls with the time
    that it is averaged over; what is left after a second is the default of the settings.
    """
    return Alignment(
        duration=duration, gyro_bias_std=Alignment().gyro_bias_std / duration, **settings
    )
