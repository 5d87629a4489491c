"""NumPy archive of everything that a track holds."""

import dataclasses
import json
import zipfile
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from footnav.errors import DataError
from footnav.health import Counters, Flag, Health, Status
from footnav.steps import Steps
from footnav.trajectory import Trajectory

_NOT_ARRAYS = ("health", "name", "origin", "frame", "filter_steps")
_ARRAYS = tuple(f.name for f in dataclasses.fields(Trajectory) if f.name not in _NOT_ARRAYS)
_STEPS = {f.name: f"step_{f.name}" for f in dataclasses.fields(Steps)}


def write_npz(traj: Trajectory, file: BinaryIO) -> None:
    """Write all arrays, in the frame with z up, the filter's strides, and the rest as JSON text under ``about``."""
    arrays: dict[str, Any] = {name: getattr(traj, name) for name in _ARRAYS}
    if traj.filter_steps is not None:
        arrays |= {key: getattr(traj.filter_steps, name) for name, key in _STEPS.items()}
    about = {
        "name": traj.name,
        "origin": traj.origin,
        "frame": traj.frame,
        "health": None if traj.health is None else dataclasses.asdict(traj.health),
    }
    np.savez(file, about=np.array(json.dumps(about)), **arrays)


def load_trajectory(path: str | PathLike[str]) -> Trajectory:
    """Read a track that was saved as ``.npz``.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    Trajectory
        Equal to the one that was saved, to the bit.

    Raises
    ------
    DataError
        When the file cannot be read or is not a track; the message names it.
    """
    path = Path(path)
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in _ARRAYS}
            steps = _steps(archive)
            about = json.loads(str(archive["about"]))
        origin = about["origin"] and tuple(about["origin"])
        health = about["health"] and _health(about["health"])
        one = {"name": about["name"], "origin": origin, "frame": about["frame"]}
        return Trajectory(**arrays, **one, health=health, filter_steps=steps)
    except OSError as error:
        raise DataError(f"{path}: cannot be read: {error.strerror or error}") from error
    except (ValueError, KeyError, TypeError, EOFError, AttributeError, zipfile.BadZipFile) as error:
        raise DataError(
            f"{path}: is not a track that Trajectory.save wrote as .npz ({error})"
        ) from error


def _steps(archive: Mapping[str, Any]) -> Steps | None:
    """Strides of the filter, if they were stored."""
    if _STEPS["covariance"] not in archive:
        return None
    return Steps(**{name: archive[key] for name, key in _STEPS.items()})


def _health(stored: dict[str, Any]) -> Health:
    return Health(
        status=Status(stored["status"]),
        flags=Flag(stored["flags"]),
        counters=Counters(**stored["counters"]),
        horizontal_std=stored["horizontal_std"],
        vertical_std=stored["vertical_std"],
    )
