"""What can go wrong, as types.

Every error of footnav is a :class:`FootnavError`; its message names the file, row or sample, the
value that was found, and what to do about it.
"""

from collections.abc import Collection


class FootnavError(Exception):
    """Base of every error that footnav raises on purpose."""


class ConfigError(FootnavError):
    """A setting is unknown, out of range, or at odds with another one."""


class DataError(FootnavError):
    """The samples cannot be used as they are."""


class NumericalError(FootnavError):
    """The filter lost a property that it cannot go on without, such as a positive covariance."""


class BusyError(FootnavError):
    """Another call, such as one of another thread, is at work on the same object."""


class FootnavWarning(UserWarning):
    """The data can be tracked, but the user should know what was found in them."""


def nearest(word: str, known: Collection[str]) -> str:
    """Name the known word that is most like `word`, as the end of a message, or nothing when none is like it."""
    from difflib import get_close_matches

    close = get_close_matches(word.lower(), known, n=1)
    return f"; did you mean {close[0]!r}?" if close else ""
