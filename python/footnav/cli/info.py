"""`footnav info`."""

from pathlib import Path

from footnav.cli.console import each_file, reporting
from footnav.cli.reading import AS_FOUND, Reading, read_walks
from footnav.diagnosis import diagnose


def examine_files(files: list[Path], /, *, reading: Reading = AS_FOUND) -> int:
    """Print a data-quality report for each recording.

    Parameters
    ----------
    files : list of Path
        Recordings.
    reading : Reading
        How to read them.

    Returns
    -------
    int
        Exit status.
    """
    return each_file(files, lambda path: _examine(path, reading))


def _examine(path: Path, reading: Reading) -> None:
    with reporting(path.name):
        recordings = read_walks(path, reading).values()
    for recording in recordings:
        print(diagnose(recording), end="\n\n")
