"""The CSV files of x-io Technologies: NGIMU, x-IMU3, and the examples of their Fusion library."""

from footnav.errors import DataError
from footnav.io import delimited
from footnav.io.options import Options
from footnav.io.samples import Samples
from footnav.io.source import Source

_TIME = ("Time (s)", "Timestamp (us)")
_SENSORS = tuple(
    f"{sensor} {axis} ({unit})"
    for sensor, unit in (("Gyroscope", "deg/s"), ("Accelerometer", "g"))
    for axis in "XYZ"
)


def read(source: Source, options: Options) -> Samples:
    """Read a file with the maker's titles, which state every unit.

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
        The titles are not the maker's, or the rows are defective.
    ConfigError
        An option does not fit the file.
    """
    table = source.table
    options.refuse("xio", "columns", "t_unit", "accel_unit", "gyro_unit")
    found = [title.text for title in table.titles]
    if not ({*_SENSORS} <= {*found} and {*_TIME} & {*found}):
        expected = f"'{_TIME[0]}' or '{_TIME[1]}', and {', '.join(map(repr, _SENSORS))}"
        titles = ", ".join(map(repr, found)) or "no titles"
        raise DataError(f"{table.name} is not of format 'xio': expected {expected}; found {titles}")
    return delimited.read(source, options)
