"""Strides of the foot that carries the sensor, from stance to stance.

Limits, and what they rest on (28 recordings under motion capture, from walking and running to shuffling and crawling,
with the SHOE statistic at three thresholds within a decade):

- LONGEST_BRIDGED_MOTION: a swing takes about 0.4 s in walking.  Of the motions shorter than 0.1 s between two rests, at
  most one in a hundred carried the foot 0.05 m: they are doubts of the detector within one stance.
- A stance may be as short as one sample: of a running foot's, the default detector believes no more.
- LONGEST_HALF_STANCE: a stride is measured between the middles of two stances, where the foot is flattest, because the
  ends of a detected stance reach into heel strike and push-off.  Of a long rest only the half second next to the
  stride belongs to it, so that standing still makes no slow stride.
- SHORTEST_STRIDE: a stride that ends within 0.05 m of where it began, both horizontally and in height, is a shuffle on
  the spot and is not counted.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

LONGEST_BRIDGED_MOTION = 0.1
LONGEST_HALF_STANCE = 0.5
SHORTEST_STRIDE = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Steps:
    """The k strides of a track; all arrays are read-only.

    Attributes
    ----------
    start_index, end_index : (k,) ndarray of int
        Samples between which the stride is measured.
    start, end : (k,) ndarray
        Their stamps, s.
    displacement : (k, 3) ndarray
        From start to end in the navigation frame, m.
    heading_change : (k,) ndarray
        Turn of the foot about the vertical, rad, within (-pi, pi], positive to the left.
    """

    start_index: Indices
    end_index: Indices
    start: Floats
    end: Floats
    displacement: Floats
    heading_change: Floats

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for name in self.__slots__:
            getattr(self, name).setflags(write=False)

    def __len__(self) -> int:
        """Count the strides."""
        return len(self.start)

    @property
    def length(self) -> Floats:
        """Horizontal length of each stride, m, (k,)."""
        return np.hypot(self.displacement[:, 0], self.displacement[:, 1])

    @property
    def height_change(self) -> Floats:
        """Climb of each stride, m, (k,), positive upwards."""
        return self.displacement[:, 2]

    @property
    def duration(self) -> Floats:
        """Time that each stride took, s, (k,)."""
        return self.end - self.start


def find_stances(t: Floats, zero_velocity: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """Join the samples at rest into stances.

    Parameters
    ----------
    t : (n,) ndarray
        Stamps, s.
    zero_velocity : (n,) ndarray of bool
        True where the foot is at rest.

    Returns
    -------
    first, last : (m,) ndarray of int
        First and last sample of each stance.
    """
    first, last = _runs(zero_velocity)
    apart = _elapsed(t, last[:-1], first[1:]) >= LONGEST_BRIDGED_MOTION
    first = first[np.append(np.ones(min(len(first), 1), bool), apart)]
    return first, last[np.append(apart, np.ones(min(len(last), 1), bool))]


def find_steps(t: Floats, position: Floats, quaternion: Floats, zero_velocity: NDArray[np.bool_]) -> Steps:
    """Measure the strides of a track.

    Parameters
    ----------
    t : (n,) ndarray
        Stamps, s.
    position : (n, 3) ndarray
        Navigation frame, m.
    quaternion : (n, 4) ndarray
        Sensor to navigation frame, xyzw.
    zero_velocity : (n,) ndarray of bool
        True where the foot is at rest.

    Returns
    -------
    Steps
        Without the shuffles on the spot.
    """
    arrival, departure = _places(t, *find_stances(t, zero_velocity))
    start, end = departure[:-1], arrival[1:]
    displacement = position[end] - position[start]
    walked = np.hypot(displacement[:, 0], displacement[:, 1]) >= SHORTEST_STRIDE
    climbed = np.abs(displacement[:, 2]) >= SHORTEST_STRIDE
    counted = walked | climbed
    start, end = start[counted], end[counted]
    turn = _turn_about_vertical(quaternion[start], quaternion[end])
    return Steps(start, end, t[start], t[end], displacement[counted], turn)


def _runs(flag: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """First and last index of each run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate(([False], flag, [False]))))
    return edges[::2], edges[1::2] - 1


def _elapsed(t: Floats, start: Indices, end: Indices) -> Floats:
    """Time between samples, to the microsecond: a limit must not depend on the rounding of large stamps."""
    elapsed: Floats = np.round(t[end] - t[start], 6)
    return elapsed


def _places(t: Floats, first: Indices, last: Indices) -> tuple[Indices, Indices]:
    """Find the samples at which a stride arrives in each stance and at which the next one leaves it."""
    middle = (first + last) // 2
    arrival = np.minimum(middle, np.searchsorted(t, t[first] + LONGEST_HALF_STANCE))
    departure = np.maximum(middle, np.searchsorted(t, t[last] - LONGEST_HALF_STANCE))
    return arrival, departure


def _turn_about_vertical(before: Floats, after: Floats) -> Floats:
    """Vertical part of the rotation between two attitudes, rad, whichever way the sensor sits on the shoe.

    With q = after * conjugate(before), the turn is 2 atan2(q_z, q_w).
    """
    x0, y0, z0, w0 = before.T
    x1, y1, z1, w1 = after.T
    q_z = z1 * w0 - w1 * z0 + y1 * x0 - x1 * y0
    q_w = w1 * w0 + x1 * x0 + y1 * y0 + z1 * z0
    return _wrapped(2 * np.arctan2(q_z, q_w))


def _wrapped(angle: Floats) -> Floats:
    """Angle within (-pi, pi]."""
    wrapped: Floats = np.pi - (np.pi - angle) % (2 * np.pi)
    return wrapped
