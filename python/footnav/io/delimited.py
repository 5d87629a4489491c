"""Text with a header: columns by title, units from the titles or the values."""

import warnings
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from footnav.errors import ConfigError, DataError, FootnavWarning, nearest
from footnav.io import infer_units
from footnav.io.header import ACCEL_ROLES, GYRO_ROLES, MAG_ROLES, REQUIRED, Title, is_canonical
from footnav.io.options import Options
from footnav.io.samples import Samples, convert, stamps
from footnav.io.source import Source
from footnav.io.text import Table
from footnav.io.units import ACCEL, GYRO, MAG, PRESSURE, TEMPERATURE, TIME, Quantity
from footnav.recording import Floats

Columns = Mapping[str, int]
"""Column, counted from 0, of each role."""


def read(source: Source, options: Options) -> Samples:
    """Read a table whose columns have titles, or are named by `options.columns`.

    Parameters
    ----------
    source : Source
        The file.
    options : Options
        The options of the caller.

    Returns
    -------
    Samples
        Along the axes of the file.

    Raises
    ------
    DataError
        A column is missing or ambiguous, a cell is not a number, time goes back, or a unit is
        unknown.
    ConfigError
        An option does not fit the file.

    Warns
    -----
    FootnavWarning
        Magnetometer, pressure or temperature has unusable values and is left out.
    """
    options.refuse("csv", "foot")
    table = source.table
    columns = locate(table, options.columns or {})
    values = table.columns([columns[role] for role in REQUIRED])
    accel = _accel(table, columns, values[:, :3], options.accel_unit)
    return Samples(
        t=stamps(
            table.name, read_time(table, columns, options.t_unit), len(values), options.rate_hz
        ),
        accel=accel,
        gyro=_gyro(table, columns, values[:, 3:], accel, options.gyro_unit),
        mag=_extra(table, columns, MAG_ROLES, MAG, infer_units.mag_unit),
        pressure=_flat(_extra(table, columns, ("pressure",), PRESSURE, infer_units.pressure_unit)),
        temperature=_flat(
            _extra(table, columns, ("temperature",), TEMPERATURE, infer_units.temperature_unit)
        ),
    )


def locate(table: Table, named: Mapping[str, str | int]) -> Columns:
    """Find the column of each role.

    Parameters
    ----------
    table : Table
        The file.
    named : mapping
        Titles or numbers of columns in the options; the others are found by their titles.

    Returns
    -------
    mapping of str to int
        Column of each role that was found, all of `REQUIRED` among them.

    Raises
    ------
    DataError
        A column that was named does not exist, or a role has no column or several.
    ConfigError
        Two roles are given the same column.
    """
    columns = {role: _named_column(table, role, column) for role, column in named.items()}
    if len(set(columns.values())) < len(columns):
        raise ConfigError(f"columns gives one column two roles: {dict(named)}")
    taken = set(columns.values())
    for index, title in enumerate(table.titles):
        if title.role is None or title.role in named or index in taken:
            continue
        if title.role in columns:
            first = table.title(columns[title.role])
            raise DataError(
                f"{table.name}: {first} and {table.title(index)} could both be {title.role}; "
                f'say which one with columns={{"{title.role}": ...}}'
            )
        columns[title.role] = index
    _check_complete(table, columns)
    return columns


def read_time(
    table: Table, columns: Columns, t_unit: str | None, default: str | None = None
) -> Floats | None:
    """Read the stamps, if there are any.

    Parameters
    ----------
    table : Table
        The file.
    columns : mapping
        Column of each role.
    t_unit : str or None
        The unit in the options.
    default : str or None
        Default unit of the format, for titles without one.

    Returns
    -------
    ndarray, shape (n,), or None
        Stamps, s.

    Raises
    ------
    DataError
        Time goes back, or its unit is unknown.
    """
    if "t" not in columns:
        return None
    t = table.columns([columns["t"]])[:, 0]
    back = np.flatnonzero(np.diff(t) < 0)
    if back.size:
        before, after = t[back[0]], t[back[0] + 1]
        raise DataError(
            f"{table.name}, line {table.numbers[back[0] + 1]}: time goes back from {before!s} to "
            f"{after!s}, "
            f"{back.size} time(s) in all; sort the rows, or unwrap a counter that overflowed"
        )
    unit = t_unit or _stated(table, [columns["t"]], TIME) or default
    return convert(
        table.name, t, TIME, unit, lambda: infer_units.time_unit(t) or _canonical(table, "s")
    )


def _named_column(table: Table, role: str, column: str | int) -> int:
    if isinstance(column, int):
        if 0 <= column < table.width:
            return column
        raise DataError(
            f"{table.name} has columns 0 to {table.width - 1}; columns gives {column} for {role}"
        )
    found = [index for index, title in enumerate(table.titles) if title.text == column.strip()]
    if len(found) == 1:
        return found[0]
    if found:
        raise DataError(
            f"{table.name} has {len(found)} columns titled {column!r}; give the number of that "
            f"for {role}"
        )
    cure = nearest(column, [title.text for title in table.titles])
    raise DataError(
        f"{table.name} has no column {column!r} for {role}; it has {_found(table)}{cure}"
    )


def _check_complete(table: Table, columns: Columns) -> None:
    missing = [role for role in REQUIRED if role not in columns]
    if missing:
        raise DataError(
            f"{table.name}: found {_found(table)}; none is recognised as {', '.join(missing)}: "
            f'name them, such as columns={{"{missing[0]}": title or number from 0}}'
        )


def _found(table: Table) -> str:
    if not table.titles:
        return f"{table.width} columns without titles"
    return "the columns " + ", ".join(repr(title.text) for title in table.titles)


def _accel(table: Table, columns: Columns, accel: Floats, option: str | None) -> Floats:
    unit = option or _stated(table, [columns[role] for role in ACCEL_ROLES], ACCEL)
    return convert(table.name, accel, ACCEL, unit, lambda: infer_units.accel_unit(accel))


def _gyro(
    table: Table, columns: Columns, gyro: Floats, accel: Floats, option: str | None
) -> Floats:
    unit = option or _stated(table, [columns[role] for role in GYRO_ROLES], GYRO)
    return convert(
        table.name,
        gyro,
        GYRO,
        unit,
        lambda: infer_units.gyro_unit(gyro, accel) or _canonical(table, "rad/s"),
    )


def _canonical(table: Table, unit: str) -> str | None:
    """Return the SI unit if the file has the titles of footnav's own files, which are in SI."""
    return unit if is_canonical(table.titles) else None


def _stated(table: Table, indices: Sequence[int], quantity: Quantity) -> str | None:
    """Return the unit in the titles of some columns, or None."""
    titles = [table.titles[index] for index in indices] if table.titles else []
    units = {_unit_of(table, title, quantity) for title in titles if title.unit}
    if len(units) > 1:
        raise DataError(
            f"{table.name}: the titles give {quantity.name} more than one unit: "
            f"{', '.join(sorted(units))}"
        )
    return units.pop() if units else None


def _unit_of(table: Table, title: Title, quantity: Quantity) -> str:
    unit = quantity.unit_of(title.unit or "")
    if unit is None:
        cure = f"; give {quantity.option}" if quantity.option else ""
        raise DataError(
            f"{table.name}: the title {title.text!r} states the unit {title.unit!r}; "
            f"expected one of {', '.join(quantity.scale)}{cure}"
        )
    return unit


def _extra(
    table: Table,
    columns: Columns,
    roles: tuple[str, ...],
    quantity: Quantity,
    infer_unit: Callable[[Floats], str | None],
) -> Floats | None:
    """Read an optional quantity, shape (n, len(roles)).

    None, with a warning, for unusable values.
    """
    if not {*roles} <= {*columns}:
        return None
    indices = [columns[role] for role in roles]
    try:
        values = table.columns(indices)
        return convert(
            table.name,
            values,
            quantity,
            _stated(table, indices, quantity),
            lambda: infer_unit(values),
        )
    except DataError as error:
        warnings.warn(f"{error}; {quantity.name} is left out", FootnavWarning, stacklevel=2)
        return None


def _flat(column: Floats | None) -> Floats | None:
    return None if column is None else column[:, 0]
