"""Experiments of the four papers, on simulated walks and on real ones.

`docs/papers.md` explains papers and results.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from footnav.errors import ConfigError, nearest
from papers import abdulrahim, wang_liu, wang_yang, wu

if TYPE_CHECKING:
    from papers.experiment import Experiment

__all__ = ["PAPERS", "experiments_of"]

PAPERS = {
    "P1": wu.experiments,
    "P2": wang_liu.experiments,
    "P3": abdulrahim.experiments,
    "P4": wang_yang.experiments,
}
"""Experiments of each paper."""


def experiments_of(paper: str | None = None, data: Path | None = None) -> tuple[Experiment, ...]:
    """Return the experiments of a paper.

    Parameters
    ----------
    paper : str, optional
        "P1" to "P4"; all of them unless given.
    data : Path, optional
        Folder with the real recordings that P3 is also tried on; they are left out unless given.

    Returns
    -------
    tuple of Experiment
        In the order of the papers.

    Raises
    ------
    ConfigError
        No such paper; the message lists the known ones.
    DataError
        There are no recordings in `data`.
    """
    if paper is not None and paper not in PAPERS:
        known = ", ".join(PAPERS)
        raise ConfigError(
            f"unknown paper {paper!r}: the known ones are {known}{nearest(paper, list(PAPERS))}"
        )
    experiments: list[Experiment] = []
    for name in [paper] if paper is not None else PAPERS:
        experiments += PAPERS[name]()
        if name == "P3" and data is not None:
            experiments += abdulrahim.recorded(data)
    return tuple(experiments)
