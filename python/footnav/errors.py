"""What can go wrong, as types.

Every error of footnav is a :class:`FootnavError`; its message names the file, row or sample, the value that was found,
and what to do about it.
"""


class FootnavError(Exception):
    """Base of every error that footnav raises on purpose."""


class ConfigError(FootnavError):
    """A setting is unknown, out of range, or at odds with another one."""


class DataError(FootnavError):
    """The samples cannot be used as they are."""


class NumericalError(FootnavError):
    """The filter lost a property that it cannot go on without, such as a positive covariance."""


class FootnavWarning(UserWarning):
    """The data can be tracked, but the user should know what was found in them."""
