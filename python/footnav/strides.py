"""Strides of the foot that carries the sensor, from one stance to the next.

The core decides which samples form a stance and where in it a stride starts or ends, by the same
rule for a recording and a stream; see ``docs/strides.md``.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from footnav import _core

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class Stride:
    """The motion of the foot from one stance to the next; the arrays are read-only.

    Attributes
    ----------
    start_index, end_index : int
        Samples between which the stride is measured, counted over the whole track.
    start, end : float
        Their stamps, s.
    displacement : (3,) ndarray
        From start to end in the navigation frame, m.
    start_heading : float
        Direction of the sensor's forward axis at the start, rad, anticlockwise from x of the
        navigation frame.
    heading_change : float
        Turn of the foot about the vertical, rad, within (-pi, pi], positive to the left.
    covariance : (4, 4) ndarray or None
        Of the errors of `local`, m and rad; None for a track that no filter made.
    """

    start_index: int
    end_index: int
    start: float
    end: float
    displacement: Floats
    start_heading: float
    heading_change: float
    covariance: Floats | None = None

    @property
    def length(self) -> float:
        """Horizontal length, m."""
        return float(np.hypot(self.displacement[0], self.displacement[1]))

    @property
    def height_change(self) -> float:
        """Climb, m, positive upwards."""
        return float(self.displacement[2])

    @property
    def duration(self) -> float:
        """Duration, s."""
        return self.end - self.start

    @property
    def local(self) -> Floats:
        """Displacement in the frame of the start heading, m, and heading change, rad.

        (dx, dy, dz, dheading).
        """
        return _local(
            self.displacement, np.float64(self.start_heading), np.float64(self.heading_change)
        )


@dataclass(frozen=True, slots=True, eq=False)
class Strides:
    """The k strides of a track; all arrays are read-only.

    An index or an iteration gives each as a `Stride`.

    Attributes
    ----------
    start_index, end_index : (k,) ndarray of int
        Samples between which the stride is measured.
    start, end : (k,) ndarray
        Their stamps, s.
    displacement : (k, 3) ndarray
        From start to end in the navigation frame, m.
    start_heading : (k,) ndarray
        Direction of the sensor's forward axis at the start, rad, anticlockwise from x of the
        navigation frame; of its x axis where no filter made the track.
    heading_change : (k,) ndarray
        Turn of the foot about the vertical, rad, within (-pi, pi], positive to the left.
    covariance : (k, 4, 4) ndarray or None
        Of the errors of `local`, m and rad; None for a track that no filter made, or whose settings
        did not ask for it (``output.strides``).
    """

    start_index: Indices
    end_index: Indices
    start: Floats
    end: Floats
    displacement: Floats
    start_heading: Floats
    heading_change: Floats
    covariance: Floats | None = None

    def __post_init__(self) -> None:
        """Make the arrays read-only."""
        for column in fields(self):
            array = getattr(self, column.name)
            if array is not None:
                array.setflags(write=False)

    def __len__(self) -> int:
        """Count the strides."""
        return len(self.start)

    def __getitem__(self, k: int) -> Stride:
        """Return stride `k`; a negative index counts from the end."""
        return Stride(
            start_index=int(self.start_index[k]),
            end_index=int(self.end_index[k]),
            start=float(self.start[k]),
            end=float(self.end[k]),
            displacement=self.displacement[k],
            start_heading=float(self.start_heading[k]),
            heading_change=float(self.heading_change[k]),
            covariance=None if self.covariance is None else self.covariance[k],
        )

    def __iter__(self) -> Iterator[Stride]:
        """Iterate over the strides in the order of time."""
        return (self[k] for k in range(len(self)))

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
        """Duration of each stride, s, (k,)."""
        return self.end - self.start

    @property
    def local(self) -> Floats:
        """Displacements in the frames of the start headings, m, and turns, rad, (k, 4)."""
        return _local(self.displacement, self.start_heading, self.heading_change)


def find_stances(t: Floats, zero_velocity: NDArray[np.bool_]) -> tuple[Indices, Indices]:
    """Group the samples at rest into stances.

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
    return _core.stances(t, zero_velocity)


def find_strides(
    t: Floats, position: Floats, quaternion: Floats, zero_velocity: NDArray[np.bool_]
) -> Strides:
    """Find the strides of a track.

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
    Strides
        Without shuffles on the spot, and without covariance.
    """
    return Strides(**_core.strides(t, position, quaternion, zero_velocity))


def _local(displacement: Floats, start_heading: Floats, heading_change: Floats) -> Floats:
    """Rotate displacements (..., 3) by minus their headings, and append the changes of heading."""
    x, y, z = np.moveaxis(displacement, -1, 0)
    cos, sin = np.cos(start_heading), np.sin(start_heading)
    return np.stack([cos * x + sin * y, cos * y - sin * x, z, heading_change], axis=-1)
