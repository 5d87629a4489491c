"""Settings in TOML files."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from footnav.errors import ConfigError
from footnav.settings import Settings, convert, encode, refuse_unknown

S = TypeVar("S", bound=Settings)


def load_settings(kind: type[S], path: str | PathLike[str]) -> S:
    """Read settings from a TOML file; absent ones keep their defaults.

    Parameters
    ----------
    kind : type
        What to read.
    path : path
        The file.

    Returns
    -------
    Settings
        Of that type.

    Raises
    ------
    ConfigError
        The file cannot be read, is no TOML, has an unknown key (the message names the nearest known
        one), a value of the wrong type, or one out of range.
    """
    path = Path(path)
    try:
        settings = msgspec.toml.decode(path.read_bytes(), type=dict[str, Any])
        refuse_unknown(kind, settings, "")
        return convert(settings, kind)
    except OSError as error:
        msg = f"{path}: {error.strerror or error}"
        raise ConfigError(msg) from error
    except msgspec.ValidationError as error:
        raise ConfigError(f"{path}: {_readable(error)}") from error
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        msg = f"{path}: not a TOML file: {error}"
        raise ConfigError(msg) from error
    except ConfigError as error:
        raise ConfigError(f"{path}: {error}") from error


def save_settings(settings: Settings, path: str | PathLike[str]) -> None:
    """Write settings as TOML; the file is the old one or the whole new one."""
    import tomli_w

    from footnav.files import replacing

    with replacing(path) as file:
        tomli_w.dump(_without_none(msgspec.json.decode(encode(settings))), file)


def _readable(error: msgspec.ValidationError) -> str:
    """Return a message of msgspec, "Expected `float` - at `$.filter.x`", with the setting first."""
    text, _, place = str(error).partition(" - at `$.")
    return f"{place.rstrip('`')}: {text}" if place else text


def _without_none(value: Any) -> Any:
    """Leave out what is absent: TOML has no null."""
    if isinstance(value, dict):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return value
