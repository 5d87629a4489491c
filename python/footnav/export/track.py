"""Interface of a track for the formats."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from footnav.geodesy import Origin
from footnav.health import Health
from footnav.strides import Strides
from footnav.summary import Summary

Floats = NDArray[np.float64]


class Track(Protocol):
    """The members of `footnav.Trajectory` that the formats use; see there for shapes and units."""

    @property
    def t(self) -> Floats: ...  # noqa: D102
    @property
    def position(self) -> Floats: ...  # noqa: D102
    @property
    def velocity(self) -> Floats: ...  # noqa: D102
    @property
    def quaternion(self) -> Floats: ...  # noqa: D102
    @property
    def zero_velocity(self) -> NDArray[np.bool_]: ...  # noqa: D102
    @property
    def position_std(self) -> Floats: ...  # noqa: D102
    @property
    def health(self) -> Health | None: ...  # noqa: D102
    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def origin(self) -> Origin | None: ...  # noqa: D102
    @property
    def frame(self) -> str: ...  # noqa: D102
    @property
    def heading_known(self) -> bool: ...  # noqa: D102
    @property
    def filter_strides(self) -> Strides | None: ...  # noqa: D102

    def __len__(self) -> int:
        """Count the samples."""
        ...

    def summary(self) -> Summary:
        """Summarize the track."""
        ...
