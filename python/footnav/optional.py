"""Import of optional libraries."""

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
        Requirement for pip when it is missing.
    error : type
        Type of the error when it is missing.

    Returns
    -------
    module
        The imported module.

    Raises
    ------
    FootnavError
        When the library is missing; the message has the command that installs it.
    """
    try:
        return import_module(module)
    except ImportError as cause:
        raise error(f"{module.partition('.')[0]} is missing: pip install {install}") from cause
