"""Files that appear whole or not at all."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from footnav.errors import FootnavError


@contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """Open a temporary file that takes the place of `path` when the block ends well.

    Parameters
    ----------
    path : path
        The file to write; a link is followed.

    Yields
    ------
    binary file
        Beside the target.  When the block fails it is removed, and what was at `path` stays.

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
    """Delete a file that may not exist, in a folder that may not exist."""
    try:
        file.unlink(missing_ok=True)
    except NotADirectoryError:
        return
