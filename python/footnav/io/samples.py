"""Output of every reader.

SI values along the axes of the file, before validation as a recording.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from footnav.errors import ConfigError, DataError
from footnav.io.units import Quantity, to_si
from footnav.recording import Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class Samples:
    """Samples in SI units, as `footnav.recording.Recording` names them.

    Ranges in m/s^2 and rad/s.
    """

    t: Floats
    accel: Floats
    gyro: Floats
    mag: Floats | None = None
    pressure: Floats | None = None
    temperature: Floats | None = None
    accel_range: float | None = None
    gyro_range: float | None = None


def stamps(name: str, t: Floats | None, n: int, rate_hz: float | None) -> Floats:
    """Return the file's stamps, or make them from the sampling rate when it has none.

    Parameters
    ----------
    name : str
        Name of the file, for messages.
    t : ndarray, shape (n,), or None
        The file's stamps, s.
    n : int
        Number of samples.
    rate_hz : float or None
        Sampling rate, Hz, for a file without stamps.

    Returns
    -------
    ndarray, shape (n,)
        Stamps, s.

    Raises
    ------
    ConfigError
        A rate is given for a file that has stamps.
    DataError
        There is neither.
    """
    if t is not None and rate_hz is not None:
        raise ConfigError(f"{name} has stamps; rate_hz is for files without, so leave it out")
    if t is not None:
        return t
    if rate_hz is None:
        raise DataError(
            f'{name} has no column of time that is recognised; name it with columns={{"t": ...}}, '
            "or give the sampling rate (rate_hz) if the file has none"
        )
    return np.arange(n) / rate_hz


def convert(
    name: str, values: Floats, quantity: Quantity, unit: str | None, infer: Callable[[], str | None]
) -> Floats:
    """Convert to SI, from `unit` or else from the unit that `infer` finds in the values.

    Parameters
    ----------
    name : str
        Name of the file, for messages.
    values : ndarray
        Values of `quantity` as the file has them.
    quantity : Quantity
        The measured quantity.
    unit : str or None
        The unit, where it is known.
    infer : callable
        Returns the unit, or None when the values are ambiguous.

    Returns
    -------
    ndarray
        SI values.

    Raises
    ------
    DataError
        The unit is neither stated nor inferred from the values.
    """
    found = unit or infer()
    if found is None:
        choices = ", ".join(quantity.scale)
        cure = (
            f"give {quantity.option} ({choices})"
            if quantity.option
            else f"write it in the title ({choices})"
        )
        raise DataError(
            f"{name} does not state the unit of {quantity.name}, and the values are ambiguous; "
            f"{cure}{quantity.hint}"
        )
    return to_si(values, quantity, found)
