"""Rows that put our figures beside those of the papers."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from footnav.files import replacing

if TYPE_CHECKING:
    from papers.run import Outcome

RANGES_UNKNOWN = "the filter is not told the ranges"


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """One approach in one experiment.

    Attributes
    ----------
    reference : str
        "P1" to "P4".
    experiment : str
        What was walked.
    approach : str
        How it was tracked.
    paper : float or None
        The paper's figure, in `unit`.
    ours_median, ours_p90 : float or None
        Median of ours, and what 90 % of the walks stay within, in `unit`; None where nothing was
        run.
    unit : str
        "%" of the distance, or "m".
    distance : float or None
        Nominal length, m.
    limit : float or None
        Greatest median that agrees with the paper, in `unit`.
    met : bool or None
        Whether the median keeps to it; None without a limit.
    seeds : int
        Number of walks.
    note : str
        What there is to know.
    """

    reference: str
    experiment: str
    approach: str
    paper: float | None
    ours_median: float | None
    ours_p90: float | None
    unit: str
    distance: float | None
    limit: float | None
    met: bool | None
    seeds: int
    note: str

    @classmethod
    def of(cls, outcome: Outcome) -> Row:
        """Sum an outcome up."""
        experiment, approach = outcome.experiment, outcome.approach
        notes = (experiment.note, approach.note, "" if approach.ranges_known else RANGES_UNKNOWN)
        return cls(
            reference=experiment.paper,
            experiment=experiment.title,
            approach=approach.name,
            paper=approach.paper,
            ours_median=outcome.median,
            ours_p90=outcome.p90,
            unit=experiment.unit,
            distance=experiment.distance,
            limit=approach.limit,
            met=outcome.met,
            seeds=len(outcome.figures),
            note="; ".join(filter(None, notes)),
        )

    @classmethod
    def skipped(cls, reference: str, experiment: str, why: str) -> Row:
        """Tell of an experiment that was not run."""
        return cls(
            reference=reference,
            experiment=experiment,
            approach="",
            paper=None,
            ours_median=None,
            ours_p90=None,
            unit="m",
            distance=None,
            limit=None,
            met=None,
            seeds=0,
            note=f"skipped: {why}",
        )


def write_json(rows: Sequence[Row], path: Path) -> None:
    """Write rows as a JSON array of objects; the file is the old one or the whole new one."""
    with replacing(path) as file:
        file.write(msgspec.json.format(msgspec.json.encode(rows), indent=1) + b"\n")
