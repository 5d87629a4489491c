"""Units inferred from the values, for files that do not state them.

Each function returns a unit only where no other one is plausible for an IMU on a foot, and None
when in doubt.
"""

import numpy as np

from footnav.io.units import TIME
from footnav.recording import STANDARD_GRAVITY, Floats


def time_unit(t: Floats) -> str | None:
    """Infer the unit of stamps, shape (n,), by the interval.

    10 to 5000 Hz are the rates of an IMU.
    """
    intervals = np.diff(t)
    intervals = intervals[intervals > 0]
    if not intervals.size:
        return None
    interval = float(np.median(intervals))
    plausible = [unit for unit, scale in TIME.scale.items() if 2e-4 <= interval * scale <= 0.1]
    return plausible[0] if len(plausible) == 1 else None


def accel_unit(accel: Floats) -> str | None:
    """Infer the unit of the specific force, shape (n, 3), from gravity."""
    level = float(np.median(np.linalg.norm(accel, axis=1)))
    if 0.5 <= level <= 1.6:
        return "g"
    if 500 <= level <= 1600:
        return "mg"
    return "m/s^2" if 0.5 <= level / STANDARD_GRAVITY <= 2.0 else None


def gyro_unit(gyro: Floats, accel: Floats) -> str | None:
    """Infer the unit of the angular rate, shape (n, 3).

    `accel` is the specific force, shape (n, 3), m/s^2.

    A walking foot peaks at 4 to 17 rad/s, that is 230 to 1000 deg/s.  Beyond 60 the values are
    deg/s; 2 to 40 are rad/s if the accelerometer shows that the foot was walking, since a foot that
    turns at 40 deg/s only does not strike the ground.  The rest, a sensor on a table above all,
    could be either.
    """
    peak = float(np.linalg.norm(gyro, axis=1).max())
    if peak > 60:
        return "deg/s"
    return "rad/s" if 2 <= peak <= 40 and _walks(accel) else None


def _walks(accel: Floats) -> bool:
    """Whether one sample in fifty is 3 m/s^2 away from gravity.

    Heel strikes and swings, not an impact on the table.
    """
    excess = np.abs(np.linalg.norm(accel, axis=1) - STANDARD_GRAVITY)
    return bool(np.quantile(excess, 0.98) > 3.0)


def mag_unit(mag: Floats) -> str | None:
    """Infer the unit of the magnetic field, shape (n, 3).

    The Earth's is 22 to 67 uT, steel may treble it.
    """
    level = float(np.median(np.linalg.norm(mag, axis=1)))
    if 10 <= level <= 200:
        return "uT"
    return "T" if 10e-6 <= level <= 200e-6 else None


def pressure_unit(pressure: Floats) -> str | None:
    """Infer the unit of the air pressure, shape (n,): 500 to 1100 hPa wherever people walk."""
    level = float(np.median(pressure))
    if 500 <= level <= 1100:
        return "hPa"
    if 50 <= level <= 110:
        return "kPa"
    return "Pa" if 50_000 <= level <= 110_000 else None


def temperature_unit(temperature: Floats) -> str | None:
    """Infer the unit of the temperature, shape (n,).

    Values within the limits of a chip are degrees Celsius.
    """
    return "degC" if np.all(np.abs(temperature - 22.5) <= 107.5) else None
