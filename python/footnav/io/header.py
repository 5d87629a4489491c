"""Roles and units in the titles of columns.

Many spellings are accepted ("ax", "Acc_X", "accelerometer x [g]", "accX_mps2"); a title with an
unknown word ("free acc x", "gravity_x") has no role.
"""

import re
from dataclasses import dataclass

from footnav.io.units import ACCEL, GYRO, MAG, PRESSURE, TEMPERATURE, TIME, Quantity

ACCEL_ROLES = ("ax", "ay", "az")
GYRO_ROLES = ("gx", "gy", "gz")
MAG_ROLES = ("mx", "my", "mz")
REQUIRED = (*ACCEL_ROLES, *GYRO_ROLES)
ROLES = ("t", *REQUIRED, *MAG_ROLES, "pressure", "temperature")
CANONICAL = ("t", *REQUIRED)
"""Titles of footnav's own files, which are in SI."""

_TRIADS = (
    ("a", ACCEL, r"accelerometer|acceleration|accel|acc|a"),
    ("g", GYRO, r"gyroscope|gyro|gyr|angularvelocity|angularrate|angvel|rotationrate|omega|w|g"),
    ("m", MAG, r"magnetometer|magneticfield|magn|mag|m"),
)
_SCALARS = (
    ("temperature", TEMPERATURE, r"temperature|temp"),
    ("pressure", PRESSURE, r"barometricpressure|airpressure|barometer|pressure|baro"),
    ("t", TIME, r"timestamps?|sampletime|time|ts|t"),
)
_FILLERS = {"imu", "sensor", "axis", "data", "calibrated", "cal", "elapsed"}
_TOKEN = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+|[^\W\d_a-zA-Z]+")
_BRACKETS = re.compile(r"(.*?)[(\[{](.*)[)\]}]\s*")


@dataclass(frozen=True, slots=True)
class Title:
    """The parsed title of a column.

    Attributes
    ----------
    text : str
        As the file has it.
    role : str or None
        One of `ROLES`, or None for an unknown title.
    unit : str or None
        Unit as the file spells it, or None where the title has none.
    """

    text: str
    role: str | None = None
    unit: str | None = None


def understand(text: str) -> Title:
    """Find the role and the unit that a title states."""
    bracketed = _BRACKETS.fullmatch(text)
    words, unit = bracketed.groups() if bracketed else (text, "")
    tokens = [token.lower() for token in _TOKEN.findall(words)]
    name = "".join(token for token in tokens if token not in _FILLERS)
    if not unit and TIME.unit_of(name):
        return Title(text, "t", name)
    role, quantity, rest = _match(name)
    if role is None or quantity is None:
        return Title(text, unit=unit.strip() or None)
    if rest and (unit or not quantity.unit_of(rest)):
        return Title(text)
    return Title(text, role, unit.strip() or rest or None)


def _match(name: str) -> tuple[str | None, Quantity | None, str]:
    """Split a title without blanks into role, quantity and rest."""
    for letter, quantity, words in _TRIADS:
        axis_last = re.fullmatch(rf"(?:{words})([xyz])(.*)", name)
        found = axis_last or re.fullmatch(rf"([xyz])(?:{words})((?![xyz]).*)", name)
        if found:
            return letter + found[1], quantity, found[2]
    for role, quantity, words in _SCALARS:
        found = re.fullmatch(rf"(?:{words})(.*)", name)
        if found:
            return role, quantity, found[1]
    return None, None, ""


def covers(titles: list[Title]) -> bool:
    """Whether the titles name every axis of an accelerometer and a gyroscope."""
    return {*REQUIRED} <= {title.role for title in titles}


def is_canonical(titles: list[Title]) -> bool:
    """Whether the titles are those of footnav's own files."""
    return tuple(title.text for title in titles[: len(CANONICAL)]) == CANONICAL
