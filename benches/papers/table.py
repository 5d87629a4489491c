"""Table of the figures on the terminal."""

from collections.abc import Sequence

from rich import box
from rich.table import Table
from rich.text import Text

from papers.report import Row


def tabulate(rows: Sequence[Row]) -> Table:
    """Tabulate measured and published figures.

    Parameters
    ----------
    rows : sequence of Row
        One for each approach, grouped by experiment.

    Returns
    -------
    Table
        A row for each of them.
    """
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("experiment", overflow="fold")
    for title in ("approach", "paper", "median", "90 %", "", "met", "walks"):
        table.add_column(title, justify="right", no_wrap=True)
    before = None
    for row in rows:
        title = f"{row.reference} {row.experiment}"
        table.add_row(
            Text("" if title == before else title),
            Text(row.approach or row.note[: row.note.find(";")]),
            *(_figure(figure) for figure in (row.paper, row.ours_median, row.ours_p90)),
            row.unit,
            {None: "", True: "yes", False: "no"}[row.met],
            f"{row.seeds}",
        )
        before = title
    return table


def _figure(value: float | None) -> str:
    """Write a figure to a hundredth, or to the unit where it is large."""
    if value is None:
        return ""
    return f"{value:.2f}" if value < 100 else f"{value:,.0f}"
