"""Errors and the warning of footnav.

Every error of footnav is a :class:`FootnavError`; its message names the file, row or sample, the
value that was found, and the remedy.
"""

from collections.abc import Collection


class FootnavError(Exception):
    """Base class of all errors of footnav."""


class ConfigError(FootnavError):
    """A setting is unknown, out of range, or inconsistent with another one."""


class DataError(FootnavError):
    """The samples cannot be used as they are."""


class NumericalError(FootnavError):
    """The filter lost a required property, such as a positive definite covariance."""


class BusyError(FootnavError):
    """Another call, such as one of another thread, uses the same object."""


class FootnavWarning(UserWarning):
    """The data can be tracked, but with less certainty."""


def nearest(word: str, known: Collection[str]) -> str:
    """Return "; did you mean ...?" with the nearest known word, or "" when none is near."""
    from difflib import get_close_matches

    close = get_close_matches(word.lower(), known, n=1)
    return f"; did you mean {close[0]!r}?" if close else ""
