"""Libraries that are loaded only when a feature needs them."""

from importlib import import_module
from typing import Any

from footnav.errors import FootnavError


def require(module: str, install: str, error: type[FootnavError] = FootnavError) -> Any:
    """Import a library.

    Parameters
    ----------
    module : str
        Module to import.
    install : str
        What pip has to install when it is missing.
    error : type
        What to raise when it is missing.

    Returns
    -------
    module
        The imported module.

    Raises
    ------
    FootnavError
        When the library is missing; the message says how to install it.
    """
    try:
        return import_module(module)
    except ImportError as cause:
        raise error(f"{module.partition('.')[0]} is missing: pip install {install}") from cause
