"""Rows with measured and published figures."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from footnav.files import replacing

if TYPE_CHECKING:
    from papers.run import Outcome

RANGES_UNKNOWN = "the filter does not know the ranges"


class Row(msgspec.Struct, frozen=True, kw_only=True):
    """One approach in one experiment.

    Attributes
    ----------
    reference : str
        "P1" to "P4".
    experiment : str
        The route and the sensor.
    approach : str
        Name of the approach.
    paper : float or None
        The paper's figure, in `unit`.
    ours_median, ours_p90 : float or None
        Median and 90th percentile of footnav, in `unit`; None for a skipped experiment.
    unit : str
        "%" of the distance, or "m".
    distance : float or None
        Nominal length, m.
    limit : float or None
        Greatest median that agrees with the paper, in `unit`.
    met : bool or None
        Whether the median is within it; None without a limit.
    seeds : int
        Number of walks.
    note : str
        Remarks.
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
        """Summarize an outcome."""
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
        """Describe a skipped experiment."""
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
    """Write rows as a JSON array of objects, atomically."""
    with replacing(path) as file:
        file.write(msgspec.json.format(msgspec.json.encode(rows), indent=1) + b"\n")
