"""Atomic writing of files."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from footnav.errors import FootnavError


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open a temporary file that replaces `path` when the block succeeds.

    Parameters
    ----------
    path : path
        The file to write; a link is followed.

    Yields
    ------
    binary file
        In the folder of the target.  When the block fails it is removed, and the file at `path`
        stays.

    Raises
    ------
    FootnavError
        When the file cannot be written; the message names `path`.
    """
    target = Path(path).resolve()
    temporary = target.with_name(f".{target.name}.{os.urandom(4).hex()}.tmp")
    try:
        with temporary.open("xb") as file:
            yield file
        if target.exists():
            shutil.copymode(target, temporary)
        temporary.replace(target)
    except OSError as error:
        raise FootnavError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        _remove(temporary)


def _remove(file: Path) -> None:
    """Delete a file if it and its folder exist."""
    try:
        file.unlink(missing_ok=True)
    except NotADirectoryError:
        return
