"""Command line of the experiments."""

import os
import sys
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

from cyclopts import App, Parameter

from footnav.cli.console import make_folder, print_table, print_warning, reporting
from footnav.cli.run import run_app
from footnav.errors import ConfigError
from footnav.optional import require
from papers import experiments_of
from papers.picture import draw
from papers.report import Row, write_json
from papers.run import Outcome, run
from papers.table import tabulate

NO_DATA = "no recordings; name their folder with --data or in the environment variable FOOTNAV_DATA"

app = App(name="papers.py", default_parameter=Parameter(negative=""), version_flags=())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiments.

    Parameters
    ----------
    arguments : sequence of str, optional
        Options; those of the process unless given.

    Returns
    -------
    int
        Exit status, as for `footnav`.
    """
    return run_app(app, sys.argv[1:] if arguments is None else arguments)


@app.default
def reproduce(
    *,
    paper: str | None = None,
    seeds: int = 20,
    json: Path | None = None,
    plots: Path | None = None,
    data: Path | None = None,
) -> int:
    """Repeat the experiments of the four papers and tabulate measured and published figures.

    Parameters
    ----------
    paper : str, optional
        P1, P2, P3 or P4; all of them unless given.
    seeds : int
        Walks to simulate for each experiment.
    json : Path, optional
        File for the figures.
    plots : Path, optional
        Folder for a picture of each experiment.
    data : Path, optional
        Folder with the real recordings for P3; that in FOOTNAV_DATA unless given.

    Returns
    -------
    int
        Exit status.
    """
    if seeds < 1:
        raise ConfigError(f"--seeds is {seeds}: expected 1 or more")
    if plots is not None:
        require("matplotlib", "footnav[plot]")
        make_folder(plots)
    data = data or _folder_in_environment()
    experiments = experiments_of(paper, data)
    with reporting("papers") as progress:
        outcomes = run(experiments, seeds, progress)
    rows = [Row.of(outcome) for outcome in outcomes]
    if data is None and paper in (None, "P3"):
        print_warning("P3", f"real recordings skipped: {NO_DATA}")
        rows.append(Row.skipped("P3", "real recordings, clipped", NO_DATA))
    print_table(tabulate(rows))
    if json is not None:
        write_json(rows, json)
        print(f"{json}: {len(rows)} rows")
    if plots is not None:
        _draw_each(outcomes, plots)
    return 0


def _draw_each(outcomes: list[Outcome], folder: Path) -> None:
    """Draw every experiment."""
    for _, of_one in groupby(outcomes, key=lambda outcome: outcome.experiment.title):
        print(draw(list(of_one), folder))


def _folder_in_environment() -> Path | None:
    folder = os.environ.get("FOOTNAV_DATA")
    return Path(folder) if folder else None
