"""A file that a reader is given: its content and its name."""

from dataclasses import dataclass
from functools import cached_property

from footnav.io import text


@dataclass(frozen=True)
class Source:
    """The content of a file.

    Attributes
    ----------
    data : bytes
        Content of the file.
    name : str
        Name of the file, for messages.
    """

    data: bytes
    name: str

    @cached_property
    def table(self) -> text.Table:
        """Rows of the file as `text.parse` finds them; parsed once."""
        return text.parse(self.data, self.name)
