"""Delimited text: rows of numbers, with or without titles.

Blank lines, comment lines (#), trailing delimiters, byte order marks, quotes and decimal commas
(beside another delimiter) are supported.  A truncated last line is dropped with a warning; any
other defect is an error with its line number.
"""

import codecs
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from footnav.errors import DataError, FootnavWarning
from footnav.io.header import REQUIRED, Title, covers, understand
from footnav.recording import Floats

BLANK = None
"""The delimiter of columns that are set apart by blanks."""


@dataclass(frozen=True, slots=True)
class Table:
    """The rows of a text file, still as text.

    Attributes
    ----------
    name : str
        Name of the file.
    titles : list of Title
        One for each column, or empty when the file has no header.
    width : int
        Number of columns.
    lines : list of str
        The rows.
    numbers : list of int
        Line number of each row, from 1.
    delimiter : str or None
        Separator of cells; None for blanks.
    """

    name: str
    titles: list[Title]
    width: int
    lines: list[str]
    numbers: list[int]
    delimiter: str | None

    def title(self, column: int) -> str:
        """Return the name of a column in messages."""
        return repr(self.titles[column].text) if self.titles else f"column {column}"

    def columns(self, indices: Sequence[int]) -> Floats:
        """Parse some of the columns.

        Parameters
        ----------
        indices : sequence of int
            Columns, counted from 0.

        Returns
        -------
        ndarray, shape (rows, len(indices))
            In the unit of the file.

        Raises
        ------
        DataError
            A cell is not a finite number.
        """
        try:
            values = np.loadtxt(
                self.lines, delimiter=self.delimiter, usecols=indices, comments=None, ndmin=2
            )
        except ValueError as error:
            raise self._bad_cell(indices) or DataError(f"{self.name}: {error}") from None
        self._check_finite(values, indices)
        return values

    def _bad_cell(self, indices: Sequence[int]) -> DataError | None:
        for number, line in zip(self.numbers, self.lines, strict=True):
            cells = split(line, self.delimiter)
            for column in indices:
                if not is_number(cells[column]):
                    found = repr(cells[column].strip()) if cells[column].strip() else "empty"
                    return DataError(
                        f"{self.name}, line {number}: {self.title(column)} is {found}; expected a "
                        "number"
                    )
        return None

    def _check_finite(self, values: Floats, indices: Sequence[int]) -> None:
        bad = np.argwhere(~np.isfinite(values))
        if bad.size:
            row, column = bad[0]
            raise DataError(
                f"{self.name}, line {self.numbers[row]}: {self.title(indices[column])} is "
                f"{values[row, column]}; "
                f"{len(bad)} value(s) in all are not finite: remove the rows or repair the "
                "recording"
            )


def parse(data: bytes, name: str) -> Table:
    """Find the header, the delimiter and the rows of a text file.

    Parameters
    ----------
    data : bytes
        Content of the file.
    name : str
        Name of the file, for messages.

    Returns
    -------
    Table

    Raises
    ------
    DataError
        The file is empty or binary, or a line other than the last has too many or too few cells.

    Warns
    -----
    FootnavWarning
        The last line is truncated and is left out.
    """
    text = _decode(data, name).replace("\r\n", "\n").replace("\r", "\n").replace('"', "")
    content = [
        (number, line)
        for number, line in enumerate(text.split("\n"), 1)
        if line and not line.isspace()
    ]
    rows = [row for row in content if not _is_comment(row[1])] if "#" in text else content
    if not rows:
        raise DataError(f"{name} is empty: it has no row of samples")
    # A row from the middle is neither a header nor truncated.
    delimiter = _delimiter(rows[len(rows) // 2][1])
    first = next((k for k, (_, line) in enumerate(rows) if _is_data(line, delimiter)), len(rows))
    if first == len(rows):
        raise DataError(
            f"{name}, line {rows[0][0]}: no row of numbers was found; the file begins "
            f"{rows[0][1][:60]!r}"
        )
    head = [line for number, line in content if number < rows[first][0]]
    body = rows[first:]
    titles = _titles(head, delimiter)
    width = len(titles) or len(_without_trailing(split(body[0][1], delimiter)))
    body = _whole_rows(body, width, delimiter, name, cut=not text.endswith("\n"))
    numbers, lines = [number for number, _ in body], [line for _, line in body]
    if delimiter != ",":
        lines = _decimal_points(lines)
    return Table(name, titles, width, lines, numbers, delimiter)


def split(line: str, delimiter: str | None) -> list[str]:
    """Cut a line into cells."""
    return [cell.strip() for cell in line.split(delimiter)]


def is_number(cell: str) -> bool:
    """Whether a cell is a number; Python's 1_000 is not."""
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def _decode(data: bytes, name: str) -> str:
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return data.decode("utf-16", errors="replace")
    if b"\0" in data:
        raise DataError(f"{name} is binary; expected text or a NumPy .npz file")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Older loggers write degree signs in Latin-1, in which every byte is valid.
        return data.decode("latin-1")


def _is_comment(line: str) -> bool:
    return line.lstrip().startswith("#")


def _delimiter(line: str) -> str | None:
    """Find the delimiter; the comma is last, since it may be a decimal comma beside the others."""
    return next((mark for mark in (";", "\t", ",") if mark in line), BLANK)


def _is_data(line: str, delimiter: str | None) -> bool:
    """Whether enough cells are numbers; other cells are defects of the row, reported later."""
    cells = [cell for cell in split(line, delimiter) if cell]
    numbers = sum(is_number(cell if delimiter == "," else cell.replace(",", ".")) for cell in cells)
    return 2 * numbers > len(cells) or numbers >= len(REQUIRED)


def _titles(head: list[str], delimiter: str | None) -> list[Title]:
    """Parse the header line that names the axes, or else the last one that is not a comment."""
    candidates = [[understand(cell) for cell in _title_cells(line, delimiter)] for line in head]
    named = [titles for titles in candidates if covers(titles)]
    plain = [titles for titles, line in zip(candidates, head, strict=True) if not _is_comment(line)]
    return named[0] if named else plain[-1] if plain else []


def _title_cells(line: str, delimiter: str | None) -> list[str]:
    """Cut a header into titles; numpy.savetxt writes it as a comment."""
    return _without_trailing(split(line.lstrip("#% ") if _is_comment(line) else line, delimiter))


def _without_trailing(cells: list[str]) -> list[str]:
    return cells[:-1] if cells and not cells[-1] else cells


def _cell_count(line: str, delimiter: str | None) -> int:
    return len(line.split()) if delimiter is BLANK else line.count(delimiter) + 1


def _whole_rows(
    rows: list[tuple[int, str]], width: int, delimiter: str | None, name: str, cut: bool
) -> list[tuple[int, str]]:
    """Return the rows with `width` cells: all of them, or all but a truncated last one."""
    for place, (number, line) in enumerate(rows):
        count = _cell_count(line, delimiter)
        if count == width or (
            count == width + 1 and delimiter and line.rstrip(" ").endswith(delimiter)
        ):
            continue
        if place == len(rows) - 1 and place > 0 and count < width:
            return _without_last(rows, name, f"{count} of {width} cells")
        raise DataError(
            f"{name}, line {number}: {count} cell(s), expected {width}: {line.strip()[:80]!r}"
        )
    last = split(rows[-1][1], delimiter)[width - 1]
    if cut and len(rows) > 1 and last in ("", "-", "+", ".", "-."):
        return _without_last(rows, name, f"the last cell is {last!r}")
    return rows


def _without_last(rows: list[tuple[int, str]], name: str, why: str) -> list[tuple[int, str]]:
    message = f"{name}, line {rows[-1][0]}: the last line is truncated ({why}) and is left out"
    warnings.warn(message, FootnavWarning, stacklevel=2)
    return rows[:-1]


def _decimal_points(lines: list[str]) -> list[str]:
    """Write decimal commas as points, in a file that has no points at all."""
    if any("," in line for line in lines[:100]) and not any("." in line for line in lines):
        return [line.replace(",", ".") for line in lines]
    return lines
