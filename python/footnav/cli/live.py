"""A status line on the terminal, and messages above it."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.live import Live
from rich.text import Text


class StatusLine:
    """Terminal output of a capture, on standard error.

    Parameters
    ----------
    live : Live, optional
        The status line; None where standard error is not a terminal.
    """

    def __init__(self, live: Live | None = None) -> None:
        self._live = live

    def update(self, text: str) -> None:
        """Update the status line, on a terminal."""
        if self._live is not None:
            self._live.update(Text(text, no_wrap=True, overflow="ellipsis"))

    def message(self, text: str) -> None:
        """Print a message above the status line."""
        if self._live is None:
            print(text, file=sys.stderr)
        else:
            self._live.console.print(text, markup=False, highlight=False)


@contextmanager
def status_line() -> Iterator[StatusLine]:
    """Open the status line of a capture.

    Yields
    ------
    StatusLine
        For the time of the capture.
    """
    if not sys.stderr.isatty():
        yield StatusLine()
        return
    # Standard output may be a file while the line is on the terminal.
    with Live(
        console=Console(stderr=True), transient=True, redirect_stdout=False, redirect_stderr=False
    ) as live:
        yield StatusLine(live)
