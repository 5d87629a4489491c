"""NumPy .npz files with arrays named like the attributes of a recording, in SI units."""

import io
import warnings
from typing import Any

import numpy as np

from footnav.errors import DataError, FootnavWarning
from footnav.io import infer_units
from footnav.io.options import Options
from footnav.io.samples import Samples, stamps
from footnav.io.source import Source
from footnav.io.units import ACCEL, GYRO, MAG, TIME, to_si
from footnav.recording import Floats, to_floats

MAGIC = b"PK\x03\x04"
"""First bytes of a zip archive, which an .npz file is."""


def sniff(source: Source, options: Options) -> bool:
    """Whether the file is a zip archive."""
    return source.data.startswith(MAGIC)


def read(source: Source, options: Options) -> Samples:
    """Read t, accel, gyro and, where present, the optional arrays and ranges.

    Parameters
    ----------
    source : Source
        The file.
    options : Options
        Units override SI; a rate makes stamps when there is no t.

    Returns
    -------
    Samples
        Along the axes of the file.

    Raises
    ------
    DataError
        The archive is damaged, an array is missing, or is not one of numbers.
    ConfigError
        An option does not fit the format.

    Warns
    -----
    FootnavWarning
        The magnetometer's unit is unknown or values are missing, and it is left out.
    """
    options.refuse("npz", "columns", "foot")
    name = source.name
    arrays = _load(source.data, name)
    missing = [label for label in ("accel", "gyro") if label not in arrays]
    if missing:
        found = ", ".join(arrays) or "none of them"
        raise DataError(
            f"{name}: expected the arrays t, accel and gyro, found {found}; missing "
            f"{', '.join(missing)}"
        )
    accel = to_si(arrays["accel"], ACCEL, options.accel_unit or "m/s^2")
    t = to_si(arrays["t"], TIME, options.t_unit or "s") if "t" in arrays else None
    return Samples(
        t=stamps(name, t, len(np.atleast_1d(accel)), options.rate_hz),
        accel=accel,
        gyro=to_si(arrays["gyro"], GYRO, options.gyro_unit or "rad/s"),
        mag=_mag(name, arrays.get("mag")),
        pressure=arrays.get("pressure"),
        temperature=arrays.get("temperature"),
        accel_range=_scalar(name, "accel_range", arrays),
        gyro_range=_scalar(name, "gyro_range", arrays),
    )


_LABELS = ("t", "accel", "gyro", "mag", "pressure", "temperature", "accel_range", "gyro_range")


def _load(data: bytes, name: str) -> dict[str, Floats]:
    if not data.startswith(MAGIC):
        raise DataError(f"{name} is not a NumPy .npz file, which numpy.savez writes")
    # Imported here, as NumPy does, to keep `import footnav` fast.
    from zipfile import BadZipFile

    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as archive:
            found: dict[str, Any] = {
                label: archive[label] for label in archive.files if label in _LABELS
            }
    except (BadZipFile, ValueError, OSError, EOFError, KeyError) as error:
        raise DataError(f"{name} cannot be read as a NumPy .npz file: {error}") from None
    return {label: to_floats(f"{name}: {label}", values) for label, values in found.items()}


def _mag(name: str, mag: Floats | None) -> Floats | None:
    """Convert a magnetometer to T from T or uT, by the strength of the Earth's field."""
    if mag is None or mag.ndim != 2:
        return mag
    missing = int((~np.isfinite(mag)).any(axis=1).sum())
    unit = infer_units.mag_unit(mag)
    if unit and not missing:
        return to_si(mag, MAG, unit)
    why = f"has {missing} row(s) that are not finite" if missing else "is in neither T nor uT"
    warnings.warn(f"{name}: mag {why}; it is left out", FootnavWarning, stacklevel=2)
    return None


def _scalar(name: str, label: str, arrays: dict[str, Floats]) -> float | None:
    if label not in arrays:
        return None
    if arrays[label].size != 1:
        raise DataError(f"{name}: {label} has shape {arrays[label].shape}; expected one number")
    return float(arrays[label].item())
