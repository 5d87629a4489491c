"""Experiments, run over many walks."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from footnav.errors import FootnavWarning
from footnav.papers.experiment import Approach, Experiment, Walk
from footnav.recording import Recording
from footnav.tracking import track

if TYPE_CHECKING:
    from footnav.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class Outcome:
    """What an approach reached in an experiment.

    Attributes
    ----------
    experiment : Experiment
        The experiment.
    approach : Approach
        The approach.
    figures : tuple of float
        One for each walk, in the unit of the experiment.
    """

    experiment: Experiment
    approach: Approach
    figures: tuple[float, ...]

    @property
    def median(self) -> float:
        """Median over the walks."""
        return float(np.median(self.figures))

    @property
    def p90(self) -> float:
        """Figure that 90 % of the walks stay within."""
        return float(np.quantile(self.figures, 0.9, method="higher"))

    @property
    def met(self) -> bool | None:
        """Whether the median keeps to the limit; None without one."""
        return None if self.approach.limit is None else self.median <= self.approach.limit


def run(
    experiments: Sequence[Experiment], seeds: int, progress: Callable[[float], None] | None = None
) -> list[Outcome]:
    """Run experiments.

    Parameters
    ----------
    experiments : sequence of Experiment
        The experiments.
    seeds : int
        Walks of each simulated experiment.
    progress : callable, optional
        Called with the share of the walks that is done, 0 to 1.

    Returns
    -------
    list of Outcome
        One for each experiment and approach, in their order.

    Raises
    ------
    FootnavError
        A walk cannot be simulated, read or tracked.
    """
    walks = [(experiment, number) for experiment in experiments for number in range(experiment.walks.count(seeds))]
    # The core releases the interpreter's lock, so threads keep all processors busy.
    with warnings.catch_warnings(), ThreadPoolExecutor(os.cpu_count()) as executor:
        warnings.simplefilter("ignore", FootnavWarning)
        futures = [executor.submit(_figures, *walk) for walk in walks]
        try:
            for done, future in enumerate(as_completed(futures), start=1):
                future.result()
                if progress is not None:
                    progress(done / len(futures))
        finally:
            executor.shutdown(cancel_futures=True)
    figures: dict[int, list[tuple[float, ...]]] = {}
    for (experiment, _), future in zip(walks, futures, strict=True):
        figures.setdefault(id(experiment), []).append(future.result())
    return [
        Outcome(experiment, approach, of_approach)
        for experiment in experiments
        for approach, of_approach in zip(experiment.approaches, zip(*figures[id(experiment)], strict=True), strict=True)
    ]


def follow(approach: Approach, recording: Recording) -> Trajectory:
    """Track a recording the way of an approach."""
    if not approach.ranges_known:
        recording = Recording(recording.t, recording.accel, recording.gyro, name=recording.name)
    return track(recording, approach.config)


def _figures(experiment: Experiment, number: int) -> tuple[float, ...]:
    """Return the figure of each approach on one walk."""
    walk: Walk = experiment.walks.load(number)
    return tuple(experiment.figure(follow(approach, walk.recording), walk) for approach in experiment.approaches)
