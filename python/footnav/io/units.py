"""Units of recorded files: spellings and SI values."""

import math
import re
from dataclasses import dataclass

from footnav.recording import STANDARD_GRAVITY, Floats


@dataclass(frozen=True, slots=True)
class Quantity:
    """A measured quantity.

    Attributes
    ----------
    name : str
        Name in messages.
    scale : dict of str to float
        SI value of one of each unit; the first unit is the SI one.
    spellings : dict of str to str
        Unit of each spelling, as normalized by `spelling`.
    option : str
        Option of `footnav.io.read` that states the unit, or "" where there is none.
    hint : str
        Hint for an unknown unit, as the end of a message.
    """

    name: str
    scale: dict[str, float]
    spellings: dict[str, str]
    option: str = ""
    hint: str = ""

    def unit_of(self, text: str) -> str | None:
        """Return the unit that `text` spells, or None."""
        return self.spellings.get(spelling(text))


def spelling(text: str) -> str:
    """Normalize a unit to lower-case letters and digits: "m/s²", "(M/S^2)" and "m s^-2" agree."""
    text = text.lower().translate(_SYMBOLS)
    for pattern, short in _WORDS:
        text = re.sub(pattern, short, text)
    return re.sub(r"[^a-z0-9]", "", text)


_SYMBOLS = str.maketrans(
    {"µ": "u", "μ": "u", "²": "2", "°": "deg", "º": "deg", "\N{DEGREE CELSIUS}": "degc"}
)
_WORDS = (
    (r"degrees?", "deg"),
    (r"radians?", "rad"),
    (r"sec(ond)?s?", "s"),
    (r"met(er|re)s?", "m"),
    (r"tesla", "t"),
)

TIME = Quantity(
    "time",
    {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    {"s": "s", "ms": "ms", "millis": "ms", "us": "us", "micros": "us", "ns": "ns", "nanos": "ns"},
    "t_unit",
)
ACCEL = Quantity(
    "the accelerometer",
    {"m/s^2": 1.0, "g": STANDARD_GRAVITY, "mg": STANDARD_GRAVITY / 1000},
    {"ms2": "m/s^2", "mss": "m/s^2", "mps2": "m/s^2", "g": "g", "gs": "g", "mg": "mg"},
    "accel_unit",
    '; raw counts of an MPU6050 need format="mpu6050"',
)
GYRO = Quantity(
    "the gyroscope",
    {"rad/s": 1.0, "deg/s": math.pi / 180},
    {
        "rads": "rad/s",
        "rads1": "rad/s",
        "radps": "rad/s",
        "degs": "deg/s",
        "degs1": "deg/s",
        "degps": "deg/s",
    }
    | {"dps": "deg/s"},
    "gyro_unit",
)
MAG = Quantity(
    "the magnetometer",
    {"T": 1.0, "mT": 1e-3, "uT": 1e-6, "nT": 1e-9, "G": 1e-4, "mG": 1e-7},
    {
        "t": "T",
        "mt": "mT",
        "ut": "uT",
        "microt": "uT",
        "nt": "nT",
        "g": "G",
        "gs": "G",
        "gauss": "G",
    }
    | {"mg": "mG", "mgauss": "mG", "milligauss": "mG"},
)
PRESSURE = Quantity(
    "the barometer",
    {"Pa": 1.0, "hPa": 1e2, "kPa": 1e3},
    {"pa": "Pa", "hpa": "hPa", "mbar": "hPa", "kpa": "kPa"},
)
TEMPERATURE = Quantity(
    "the thermometer",
    {"degC": 1.0},
    {"c": "degC", "degc": "degC", "celsius": "degC", "degcelsius": "degC"},
)


def to_si(values: Floats, quantity: Quantity, unit: str) -> Floats:
    """Convert `values` from `unit` to the SI unit of `quantity`.

    Parameters
    ----------
    values : ndarray
        Values in `unit`.
    quantity : Quantity
        The measured quantity.
    unit : str
        One of `quantity.scale`.

    Returns
    -------
    ndarray
        The same shape, SI.
    """
    scale = quantity.scale[unit]
    # A thousandth has no exact binary form; dividing by the thousand keeps decimal stamps correctly
    # rounded.
    return values / round(1 / scale) if scale < 1 and quantity is TIME else values * scale
