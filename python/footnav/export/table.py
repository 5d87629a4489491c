"""Tables of states: CSV, TUM, Parquet and Feather."""

import csv
import io
from collections.abc import Iterable
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from footnav.export.frames import states_in
from footnav.export.track import Track
from footnav.geodesy import enu_to_geodetic
from footnav.optional import require

_AXES = {"enu": "xyz", "ned": "ned"}
_EXTRA = "footnav[parquet]"


def write_csv(traj: Track, file: BinaryIO, *, frame: str | None = None) -> None:
    """Write a header and one line for each sample, with the digits of an exact round trip."""
    columns = _columns(traj, frame)
    columns["zero_velocity"] = columns["zero_velocity"].astype(np.uint8)
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    _write_rows(file, [tuple(columns)], ",")
    _write_rows(file, rows, ",")


def write_tum(traj: Track, file: BinaryIO, *, frame: str | None = None) -> None:
    """Write lines of ``t x y z qx qy qz qw``, the format of the TUM benchmark."""
    states = states_in(traj, frame)
    rows = np.column_stack([traj.t, states.position, states.quaternion])
    _write_rows(file, rows.tolist(), " ")


def write_parquet(traj: Track, file: BinaryIO, *, frame: str | None = None) -> None:
    """Write the columns of the CSV to an Apache Parquet file."""
    parquet = require("pyarrow.parquet", _EXTRA)
    parquet.write_table(_arrow_table(traj, frame), file)


def write_feather(traj: Track, file: BinaryIO, *, frame: str | None = None) -> None:
    """Write the columns of the CSV to a Feather file (version 2, the Arrow IPC format)."""
    feather = require("pyarrow.feather", _EXTRA)
    feather.write_feather(_arrow_table(traj, frame), file)


def _arrow_table(traj: Track, frame: str | None) -> Any:
    return require("pyarrow", _EXTRA).table(_columns(traj, frame))


def _columns(traj: Track, frame: str | None) -> dict[str, NDArray[Any]]:
    """Columns of the table by name."""
    states = states_in(traj, frame)
    axes = _AXES[frame or traj.frame]
    columns: dict[str, NDArray[Any]] = {"t": traj.t}
    columns |= _named([f"p{axis}" for axis in axes], states.position)
    columns |= _named([f"v{axis}" for axis in axes], states.velocity)
    columns |= _named(["qx", "qy", "qz", "qw"], states.quaternion)
    columns["zero_velocity"] = traj.zero_velocity
    columns |= _named([f"std_{axis}" for axis in axes], states.position_std)
    if traj.origin is not None and traj.heading_known:
        columns |= _named(
            ["latitude_deg", "longitude_deg", "height"], enu_to_geodetic(traj.position, traj.origin)
        )
    return columns


def _named(names: list[str], array: NDArray[np.float64]) -> dict[str, NDArray[Any]]:
    return dict(zip(names, np.ascontiguousarray(array.T), strict=True))


def _write_rows(file: BinaryIO, rows: Iterable[Iterable[Any]], delimiter: str) -> None:
    text = io.StringIO()
    csv.writer(text, delimiter=delimiter, lineterminator="\n").writerows(rows)
    file.write(text.getvalue().encode())
