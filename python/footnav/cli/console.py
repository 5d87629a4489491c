"""Output of the commands: results on standard output, messages on standard error."""

import re
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from footnav.errors import FootnavError, FootnavWarning

TABLE_WIDTH = 120
"""Characters in a line of a table that does not go to a terminal."""

_OPTIONS = re.compile(
    r"(?<![.\w])(rate_hz|t_unit|accel_unit|gyro_unit|accel_range|gyro_range|(?:foot|format)(?==))\b"
)
"""Options as spelled in messages of the library."""


def print_error(error: object) -> None:
    """Print an error in one line, with options in the spelling of the command line."""
    text = _OPTIONS.sub(
        lambda option: "--" + option[0].replace("_", "-"), " ".join(str(error).split())
    )
    print(f"footnav: {text}", file=sys.stderr)


def print_warning(label: str, text: str) -> None:
    """Print a warning about a file in one line; a repeated name of the file is removed."""
    print(f"{label}: warning: {text.removeprefix(label).lstrip(',: ')}", file=sys.stderr)


def print_table(table: Table) -> None:
    """Print a table, in colour on a terminal."""
    Console(width=None if sys.stdout.isatty() else TABLE_WIDTH).print(table)


def make_folder(path: Path) -> Path:
    """Create a folder if it does not exist, or raise FootnavError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FootnavError(f"{path}: cannot be created: {error.strerror or error}") from error
    return path


def each_file(files: Iterable[Path], work: Callable[[Path], None]) -> int:
    """Process every file; an error of one does not affect the others.

    Parameters
    ----------
    files : iterable of Path
        The files.
    work : callable
        Function of one file.

    Returns
    -------
    int
        Exit status: 1 if a file failed, else 0.
    """
    status = 0
    for path in files:
        try:
            work(path)
        except FootnavError as error:
            print_error(error)
            status = 1
    return status


@contextmanager
def reporting(label: str) -> Iterator[Callable[[float], None]]:
    """Show the progress of the work on a file, and the library's warnings at its end.

    Parameters
    ----------
    label : str
        Name of the file in messages.

    Yields
    ------
    callable
        Takes the completed share of the work, 0 to 1.
    """
    with _collected_warnings() as texts:
        try:
            with _progress_bar(label) as progress:
                yield progress
        finally:
            for text in dict.fromkeys(texts):
                print_warning(label, text)


@contextmanager
def _collected_warnings() -> Iterator[list[str]]:
    """Collect the library's warnings; others are shown as usual."""
    texts: list[str] = []
    show = warnings.showwarning

    def collect(
        message: Warning | str,
        category: type[Warning],
        filename: str,
        lineno: int,
        file: TextIO | None = None,
        line: str | None = None,
    ) -> None:
        if issubclass(category, FootnavWarning):
            texts.append(str(message))
        else:
            show(message, category, filename, lineno, file, line)

    with warnings.catch_warnings():
        warnings.simplefilter("always", FootnavWarning)
        warnings.showwarning = collect
        yield texts


@contextmanager
def _progress_bar(label: str) -> Iterator[Callable[[float], None]]:
    columns = (TextColumn("{task.description}", markup=False), BarColumn(), TimeElapsedColumn())
    bar = Progress(
        *columns,
        console=Console(stderr=True),
        transient=True,
        # Standard output may be a file while the bar is on the terminal.
        redirect_stdout=False,
        redirect_stderr=False,
        disable=not sys.stderr.isatty(),
    )
    with bar:
        task = bar.add_task(label, total=None)
        yield lambda share: bar.update(task, total=1.0, completed=share)
