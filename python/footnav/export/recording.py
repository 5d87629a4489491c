"""Files of a recording, which `footnav.read` restores to the bit."""

from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Any, BinaryIO, Protocol

import numpy as np
from numpy.typing import NDArray

from footnav.errors import ConfigError
from footnav.files import replacing

Floats = NDArray[np.float64]


class Samples(Protocol):
    """The members of `footnav.Recording` that its files hold; see there for shapes and units."""

    @property
    def t(self) -> Floats: ...  # noqa: D102
    @property
    def accel(self) -> Floats: ...  # noqa: D102
    @property
    def gyro(self) -> Floats: ...  # noqa: D102
    @property
    def mag(self) -> Floats | None: ...  # noqa: D102
    @property
    def pressure(self) -> Floats | None: ...  # noqa: D102
    @property
    def temperature(self) -> Floats | None: ...  # noqa: D102
    @property
    def accel_range(self) -> float | None: ...  # noqa: D102
    @property
    def gyro_range(self) -> float | None: ...  # noqa: D102


def save_recording(recording: Samples, path: str | PathLike[str]) -> None:
    """Write a recording to a file whose suffix names the format.

    Parameters
    ----------
    recording : Samples
        The samples.
    path : path
        ``.csv``: a header ``t (s),ax (m/s^2),...,gz (rad/s)`` and, where present, magnetometer,
        pressure and temperature, with their units.  A table does not hold the full scales: pass
        them to `footnav.read` again.  ``.npz``: arrays named as the attributes of the recording,
        with the full scales.

    Raises
    ------
    ConfigError
        For another suffix.
    FootnavError
        For a file that cannot be written; an existing one is unchanged.
    """
    path = Path(path)
    check_suffix(path)
    with replacing(path) as file:
        _WRITERS[path.suffix.lower()](recording, file)


def check_suffix(path: Path) -> None:
    """Raise ConfigError for a path whose suffix is not a format of a recording."""
    if path.suffix.lower() not in _WRITERS:
        raise ConfigError(
            f"{path}: unknown suffix {path.suffix!r}, expected one of {', '.join(_WRITERS)}"
        )


def _write_csv(recording: Samples, file: BinaryIO) -> None:
    columns = _columns(recording)
    rows = np.column_stack(list(columns.values())).tolist()
    lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows), ""]
    file.write("\n".join(lines).encode())


def _write_npz(recording: Samples, file: BinaryIO) -> None:
    labels = ("t", "accel", "gyro", "mag", "pressure", "temperature", "accel_range", "gyro_range")
    values: dict[str, Any] = {label: getattr(recording, label) for label in labels}
    np.savez(file, **{label: value for label, value in values.items() if value is not None})


def _columns(recording: Samples) -> dict[str, Floats]:
    """Columns of the table by title."""
    columns = {"t (s)": recording.t}
    columns |= dict(zip(("ax (m/s^2)", "ay (m/s^2)", "az (m/s^2)"), recording.accel.T, strict=True))
    columns |= dict(zip(("gx (rad/s)", "gy (rad/s)", "gz (rad/s)"), recording.gyro.T, strict=True))
    if recording.mag is not None:
        columns |= dict(zip(("mx (T)", "my (T)", "mz (T)"), recording.mag.T, strict=True))
    if recording.pressure is not None:
        columns["pressure (Pa)"] = recording.pressure
    if recording.temperature is not None:
        columns["temperature (degC)"] = recording.temperature
    return columns


_WRITERS: dict[str, Callable[[Samples, BinaryIO], None]] = {
    ".csv": _write_csv,
    ".npz": _write_npz,
}
