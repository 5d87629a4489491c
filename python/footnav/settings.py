"""Groups of settings: immutable, with known keys, passed to the core as JSON."""

from __future__ import annotations

import json
import math
import threading
from collections.abc import Iterable
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar, get_args, get_type_hints

import msgspec
import numpy as np

from footnav.errors import ConfigError, nearest

if TYPE_CHECKING:
    from typing_extensions import Self


Vector: TypeAlias = tuple[float, float, float]
Matrix: TypeAlias = tuple[Vector, Vector, Vector]

IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Settings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A group of settings."""

    def replace(self, **changes: Any) -> Self:
        """Return the same settings with some of them changed."""
        refuse_unknown(type(self), changes, "")
        return msgspec.structs.replace(self, **changes)


S = TypeVar("S", bound=Settings)

_CONVERTING = threading.Lock()
"""msgspec examines a type at its first conversion, which two threads must not do at once."""


def encode(settings: Settings | dict[str, Any]) -> bytes:
    """Return settings as JSON for the core.

    Raises
    ------
    ConfigError
        A value is of a type that no setting has, or a number is not finite: JSON would make nothing
        of it.
    """
    try:
        values = msgspec.to_builtins(settings, enc_hook=_plain)
    except TypeError as error:
        msg = f"a setting has a value that is no setting: {error}"
        raise ConfigError(msg) from error
    try:
        return json.dumps(values, allow_nan=False).encode()
    except ValueError:
        _refuse_non_finite(values, "")
        raise


def decode(text: str, kind: type[S]) -> S:
    """Return the settings of a type that the core wrote as JSON."""
    return convert(msgspec.json.decode(text), kind)


def convert(values: Any, kind: type[S]) -> S:
    """Make settings of a type from numbers and tables.

    Raises
    ------
    msgspec.ValidationError
        A value is of the wrong type.
    """
    with _CONVERTING:
        return msgspec.convert(values, kind)


def _plain(value: Any) -> Any:
    """Turn NumPy's numbers and arrays into Python's."""
    if isinstance(value, (np.generic, np.ndarray)):
        return value.tolist()
    msg = f"{value!r}"
    raise TypeError(msg)


def _refuse_non_finite(value: Any, name: str) -> None:
    if isinstance(value, float) and not math.isfinite(value):
        msg = f"{name} = {value}: expected a finite number"
        raise ConfigError(msg)
    items = (
        value.items()
        if isinstance(value, dict)
        else enumerate(value)
        if isinstance(value, (list, tuple))
        else ()
    )
    for key, item in items:
        _refuse_non_finite(item, f"{name}.{key}".lstrip("."))


def refuse_unknown(section: type[msgspec.Struct], settings: dict[str, Any], prefix: str) -> None:
    """Raise for the first key that `section` does not have, naming the nearest one that it has."""
    types = _types(section)
    tag_field = section.__struct_config__.tag_field
    for key, value in settings.items():
        if key == tag_field:
            continue
        if key not in section.__struct_fields__:
            raise ConfigError(_unknown(prefix + key, section.__struct_fields__))
        inner = _section_for(types[key], value, prefix + key)
        if inner is not None:
            refuse_unknown(inner, value, f"{prefix}{key}.")


@cache
def _types(section: type[msgspec.Struct]) -> dict[str, Any]:
    """Return the types of the settings; to find them takes longer than to check all values."""
    return get_type_hints(section)


def _section_for(declared: Any, value: Any, name: str) -> type[msgspec.Struct] | None:
    """Return the section of a table of settings, by its `kind` where several are possible."""
    sections = [
        c
        for c in (declared, *get_args(declared))
        if isinstance(c, type) and issubclass(c, msgspec.Struct)
    ]
    if not sections or not isinstance(value, dict):
        return None
    if len(sections) == 1:
        return sections[0]
    kinds = by_kind(sections)
    kind = value.get("kind")
    if not isinstance(kind, str) or kind not in kinds:
        found = f"{name}.kind = {kind!r}" if "kind" in value else f"{name} has no kind"
        raise ConfigError(unknown_kind(found, str(kind), kinds))
    return kinds[kind]


def by_kind(sections: Iterable[type[msgspec.Struct]]) -> dict[str, type[msgspec.Struct]]:
    """Return the sections by their `kind`."""
    return {str(section.__struct_config__.tag): section for section in sections}


def unknown_kind(found: str, kind: str, known: dict[str, Any]) -> str:
    """Say that there is no such kind, which ones there are, and which is the nearest."""
    return f"{found}: the known ones are {', '.join(known)}{nearest(kind, list(known))}"


def _unknown(key: str, known: tuple[str, ...]) -> str:
    hint = nearest(key.rpartition(".")[2], known)
    return f"unknown setting {key!r}: known here are {', '.join(known)}{hint}"
