"""The libraries that reach the hardware, which only a capture needs."""

from importlib import import_module
from typing import Any

from footnav.errors import ConfigError


def require(module: str, what: str, package: str) -> Any:
    """Import a library.

    Parameters
    ----------
    module : str
        Module to import.
    what : str
        What it is needed for.
    package : str
        Its name for pip.

    Returns
    -------
    module
        The imported module.

    Raises
    ------
    ConfigError
        The library is missing; the message says how to install it.
    """
    try:
        return import_module(module)
    except ImportError:
        raise ConfigError(f"{what} needs {package}: pip install {package}, or footnav[capture]") from None
