"""IMU files of the EuRoC MAV dataset, whose layout other visual-inertial datasets share.

References
----------
M. Burri et al., "The EuRoC micro aerial vehicle datasets", International Journal of Robotics
Research 35(10), 2016.
"""

import re

import numpy as np

from footnav.errors import DataError
from footnav.io.header import Title
from footnav.io.options import Options
from footnav.io.samples import Samples, stamps
from footnav.io.source import Source
from footnav.io.text import Table, split
from footnav.io.units import ACCEL, GYRO, TIME
from footnav.recording import Floats

_COLUMNS = {"timestamp": (TIME, "ns")}
_COLUMNS |= {f"w_RS_S_{axis}": (GYRO, "rad/s") for axis in "xyz"}
_COLUMNS |= {f"a_RS_S_{axis}": (ACCEL, "m/s^2") for axis in "xyz"}
"""Quantity and unit of each column, in the order of the format."""

_NS_PER_S = 10**9
_HEADER_BYTES = 1000
_TITLE = re.compile(r"([^\s\[]+)\s*(?:\[(.*)\])?")
_STAMP = re.compile(r"\d{1,19}")


def sniff(source: Source, options: Options) -> bool:
    """Whether the first line has a title of the format's gyroscope or accelerometer."""
    if options.columns:
        return False
    first = source.data[:_HEADER_BYTES].decode("utf-8-sig", errors="replace").partition("\n")[0]
    names = {_split_title(cell)[0] for cell in _titles(first)}
    return bool(names & ({*_COLUMNS} - {"timestamp"}))


def read(source: Source, options: Options) -> Samples:
    """Read stamps in integer ns, angular rate in rad/s and specific force in m/s^2.

    Time counts from the first sample: the first stamp is subtracted in integers, since a float64
    resolves stamps since 1970 to 256 ns only.

    Parameters
    ----------
    source : Source
        The file.
    options : Options
        The options of the caller.

    Returns
    -------
    Samples
        Along the axes of the file; `t` in s from the first sample.

    Raises
    ------
    DataError
        The titles are not those of the format in its order, a row is truncated, a cell is not a
        number, or time goes back.
    ConfigError
        An option does not fit the format.
    """
    options.refuse("euroc", "columns", "t_unit", "accel_unit", "gyro_unit", "foot")
    table = _table(source)
    sensors = table.columns(range(1, len(_COLUMNS)))
    return Samples(
        t=stamps(table.name, _time(table), len(sensors), options.rate_hz),
        gyro=sensors[:, :3],
        accel=sensors[:, 3:],
    )


def _table(source: Source) -> Table:
    """Cut the file into whole rows; unlike in other text, a truncated last one is an error."""
    content = source.data.decode("utf-8-sig", errors="replace").splitlines() or [""]
    _check_titles(source.name, content[0])
    rows = [
        (number, line)
        for number, line in enumerate(content[1:], 2)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not rows:
        raise DataError(f"{source.name} has no row of samples after its header; record it again")
    for number, line in rows:
        _check_width(source.name, number, line, last=number == rows[-1][0])
    numbers, lines = [number for number, _ in rows], [line for _, line in rows]
    return Table(source.name, [*map(Title, _COLUMNS)], len(_COLUMNS), lines, numbers, ",")


def _titles(line: str) -> list[str]:
    return split(line.lstrip("# "), ",")


def _split_title(title: str) -> tuple[str, str | None]:
    """Split "name [unit]", whose unit may be missing."""
    parts = _TITLE.fullmatch(title)
    return (parts[1], parts[2]) if parts else (title, None)


def _check_titles(name: str, header: str) -> None:
    titles = _titles(header)
    found = [_split_title(title) for title in titles]
    if [column for column, _ in found] != [*_COLUMNS]:
        raise DataError(
            f"{name}, line 1: a file of format 'euroc' has the columns {', '.join(_COLUMNS)} in "
            f"this order; found {', '.join(map(repr, titles))}; write them in this order, or read "
            'the file without format="euroc" and with columns={"t": number from 0, "ax": ...}'
        )
    for column, unit in found:
        quantity, expected = _COLUMNS[column]
        if unit is not None and quantity.unit_of(unit) != expected:
            raise DataError(
                f"{name}, line 1: {column} is in {unit!r}; a file of format 'euroc' has "
                f"{expected}; convert the column"
            )


def _check_width(name: str, number: int, line: str, *, last: bool) -> None:
    count = line.count(",") + 1
    if count == len(_COLUMNS):
        return
    cure = "the last line is truncated: remove it" if last else "repair or remove the line"
    raise DataError(
        f"{name}, line {number}: {count} cell(s), expected {len(_COLUMNS)}: "
        f"{line.strip()[:80]!r}; {cure}"
    )


def _time(table: Table) -> Floats:
    """Stamps, s from the first one, shape (n,)."""
    cells = [split(line, table.delimiter)[0] for line in table.lines]
    for number, cell in zip(table.numbers, cells, strict=True):
        if not _STAMP.fullmatch(cell):
            raise DataError(
                f"{table.name}, line {number}: the timestamp is {cell!r}; expected an integer in "
                "ns; write the stamps without point or exponent"
            )
    elapsed = [int(cell) - int(cells[0]) for cell in cells]
    for number, before, after in zip(table.numbers[1:], elapsed, elapsed[1:], strict=False):
        if after < before:
            raise DataError(
                f"{table.name}, line {number}: time goes back by {before - after} ns; sort the rows"
            )
    return np.array([nanoseconds / _NS_PER_S for nanoseconds in elapsed])
