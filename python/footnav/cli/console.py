"""What the commands say: results on standard output, all else on standard error."""

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
"""Options as the messages of the library spell them."""


def complain(error: object) -> None:
    """Print an error in one line, with options as the command line spells them."""
    text = _OPTIONS.sub(
        lambda option: "--" + option[0].replace("_", "-"), " ".join(str(error).split())
    )
    print(f"footnav: {text}", file=sys.stderr)


def caution(label: str, text: str) -> None:
    """Print a warning about a file in one line; the text may name the file itself."""
    print(f"{label}: warning: {text.removeprefix(label).lstrip(',: ')}", file=sys.stderr)


def print_table(table: Table) -> None:
    """Print a table, in colour where there is colour."""
    Console(width=None if sys.stdout.isatty() else TABLE_WIDTH).print(table)


def make_folder(path: Path) -> Path:
    """Make sure that a folder exists, or raise FootnavError."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FootnavError(f"{path}: cannot be made a folder: {error.strerror or error}") from error
    return path


def each_file(files: Iterable[Path], work: Callable[[Path], None]) -> int:
    """Work on every file, whatever happens to the others.

    Parameters
    ----------
    files : iterable of Path
        The files.
    work : callable
        What to do with each of them.

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
            complain(error)
            status = 1
    return status


@contextmanager
def attending(label: str) -> Iterator[Callable[[float], None]]:
    """Show how the work on a file goes on, and what the library warned of when it is over.

    Parameters
    ----------
    label : str
        What to call the file.

    Yields
    ------
    callable
        Takes the share of the work that is done, 0 to 1.
    """
    with _collected_warnings() as texts:
        try:
            with _progress_bar(label) as progress:
                yield progress
        finally:
            for text in dict.fromkeys(texts):
                caution(label, text)


@contextmanager
def _collected_warnings() -> Iterator[list[str]]:
    """Collect the library's warnings; those of others go their way."""
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
        # Standard output may lead into a file while the bar is on the terminal.
        redirect_stdout=False,
        redirect_stderr=False,
        disable=not sys.stderr.isatty(),
    )
    with bar:
        task = bar.add_task(label, total=None)
        yield lambda share: bar.update(task, total=1.0, completed=share)
