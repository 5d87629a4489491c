"""NumPy archive of all fields of a track."""

import dataclasses
import json
import zipfile
from collections.abc import Callable, Mapping
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

import numpy as np

from footnav.columns import COLUMNS
from footnav.errors import DataError
from footnav.export.track import Track
from footnav.health import Counters, Flag, Health, Status
from footnav.strides import Strides

Built = TypeVar("Built")

_ARRAYS = (*COLUMNS, "heading_known")
_STRIDES = {f.name: f"stride_{f.name}" for f in dataclasses.fields(Strides)}


def write_npz(traj: Track, file: BinaryIO) -> None:
    """Write arrays (z up) and strides of the filter, and the rest as JSON under ``about``."""
    arrays: dict[str, Any] = {name: getattr(traj, name) for name in _ARRAYS}
    if traj.filter_strides is not None:
        arrays |= {key: getattr(traj.filter_strides, name) for name, key in _STRIDES.items()}
    about = {
        "name": traj.name,
        "origin": traj.origin,
        "frame": traj.frame,
        "health": None if traj.health is None else dataclasses.asdict(traj.health),
    }
    np.savez(file, about=np.array(json.dumps(about)), **arrays)


def read_npz(path: str | PathLike[str], build: Callable[..., Built]) -> Built:
    """Read an archive and build a track of it.

    Parameters
    ----------
    path : path
        The file.
    build : callable
        Takes the attributes of the track by name, such as `footnav.Trajectory`.

    Returns
    -------
    object
        Result of `build`.

    Raises
    ------
    DataError
        When the file cannot be read or is not a track; the message names it.
    """
    path = Path(path)
    try:
        with np.load(path, allow_pickle=False) as archive:
            return build(**_fields(archive))
    except OSError as error:
        raise DataError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (ValueError, KeyError, TypeError, EOFError, AttributeError, zipfile.BadZipFile) as error:
        raise DataError(
            f"{path}: is not a track that Trajectory.save wrote as .npz ({error})"
        ) from error


def _fields(archive: Mapping[str, Any]) -> dict[str, Any]:
    """Attributes of the track by name."""
    about = json.loads(str(archive["about"]))
    return {
        **{name: archive[name] for name in COLUMNS},
        "heading_known": bool(archive["heading_known"]),
        "name": about["name"],
        "origin": about["origin"] and tuple(about["origin"]),
        "frame": about["frame"],
        "health": about["health"] and _health(about["health"]),
        "filter_strides": _strides(archive),
    }


def _strides(archive: Mapping[str, Any]) -> Strides | None:
    """Strides of the filter, if they were stored."""
    if _STRIDES["covariance"] not in archive:
        return None
    return Strides(**{name: archive[key] for name, key in _STRIDES.items()})


def _health(stored: dict[str, Any]) -> Health:
    return Health(
        status=Status(stored["status"]),
        flags=Flag(stored["flags"]),
        counters=Counters(**stored["counters"]),
        horizontal_std=stored["horizontal_std"],
        vertical_std=stored["vertical_std"],
    )
