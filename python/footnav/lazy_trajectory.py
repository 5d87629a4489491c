"""The track of one block of a stream, whose arrays are made on demand."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from footnav._core import Columns
from footnav.geodesy import Georeference, Origin
from footnav.health import Health
from footnav.strides import Strides
from footnav.trajectory import Trajectory

Floats = NDArray[np.float64]


class LazyTrajectory(Trajectory):
    """States of one block; see `Trajectory`.

    An application that streams reads one or two columns of most blocks, so each array is made at
    its first access and kept.
    """

    __slots__ = ("_columns", "_georeference", "_made")

    _columns: Columns
    _georeference: Georeference
    _made: dict[str, Any]

    def __new__(cls, *columns: Any, **fields: Any) -> Trajectory:  # type: ignore[misc]
        """Make an ordinary track, as `dataclasses.replace` does."""
        return Trajectory(*columns, **fields)

    @classmethod
    def of_columns(cls, columns: Columns, georeference: Georeference) -> "LazyTrajectory":
        """Take states and health of the core without checks.

        Parameters
        ----------
        columns : Columns
            States and health.
        georeference : Georeference
            Origin, frame, and whether the heading is known.

        Returns
        -------
        LazyTrajectory
            Read-only.
        """
        block: LazyTrajectory = object.__new__(cls)
        object.__setattr__(block, "_columns", columns)
        object.__setattr__(block, "_georeference", georeference)
        object.__setattr__(block, "_made", {})
        return block

    def _array(self, name: str) -> NDArray[Any]:
        """Make a column at its first access."""
        array: NDArray[Any] | None = self._made.get(name)
        if array is None:
            array = self._made[name] = self._columns[name]
            array.setflags(write=False)
        return array

    @property
    def t(self) -> Floats:
        """See `Trajectory`."""
        return self._array("t")

    @property
    def position(self) -> Floats:
        """See `Trajectory`."""
        return self._array("position")

    @property
    def velocity(self) -> Floats:
        """See `Trajectory`."""
        return self._array("velocity")

    @property
    def quaternion(self) -> Floats:
        """See `Trajectory`."""
        return self._array("quaternion")

    @property
    def zero_velocity(self) -> NDArray[np.bool_]:
        """See `Trajectory`."""
        return self._array("zero_velocity")

    @property
    def position_std(self) -> Floats:
        """See `Trajectory`."""
        return self._array("position_std")

    @property
    def gyro_bias(self) -> Floats:
        """See `Trajectory`."""
        return self._array("gyro_bias")

    @property
    def accel_bias(self) -> Floats:
        """See `Trajectory`."""
        return self._array("accel_bias")

    @property
    def flags(self) -> NDArray[np.uint16]:
        """See `Trajectory`."""
        return self._array("flags")

    @property
    def health(self) -> Health:
        """Health of the stream at the end of the block."""
        health: Health | None = self._made.get("health")
        if health is None:
            health = self._made["health"] = Health.of_fields(self._columns.health())
        return health

    @property
    def name(self) -> str:
        """Empty: a stream has no name."""
        return ""

    @property
    def origin(self) -> Origin | None:
        """Origin of the navigation frame, as the settings state it."""
        return self._georeference.origin

    @property
    def frame(self) -> str:
        """Frame in which tables are written, as the settings state it."""
        return self._georeference.frame

    @property
    def heading_known(self) -> bool:
        """Whether x is east."""
        return self._georeference.heading_known

    @property
    def filter_strides(self) -> Strides | None:
        """None: `Navigator.strides` gives the strides of a stream."""
        return None
