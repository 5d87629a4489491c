"""Experiments, run over many walks."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np

from footnav.errors import FootnavWarning
from footnav.recording import Recording
from footnav.tracking import track
from papers.experiment import Approach, Experiment

if TYPE_CHECKING:
    from footnav.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class Outcome:
    """Results of an approach in an experiment.

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
        """90th percentile over the walks."""
        return float(np.quantile(self.figures, 0.9, method="higher"))

    @property
    def met(self) -> bool | None:
        """Whether the median is within the limit; None without one."""
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
    # The core releases the interpreter's lock, so threads keep all processors busy.
    with warnings.catch_warnings(), ThreadPoolExecutor(os.cpu_count()) as executor:
        warnings.simplefilter("ignore", FootnavWarning)
        futures = [
            [
                executor.submit(_figures, experiment, number)
                for number in range(experiment.walks.count(seeds))
            ]
            for experiment in experiments
        ]
        try:
            _wait(list(chain.from_iterable(futures)), progress)
        finally:
            executor.shutdown(cancel_futures=True)
    return [
        Outcome(experiment, approach, figures)
        for experiment, of_walks in zip(experiments, futures, strict=True)
        for approach, figures in zip(
            experiment.approaches,
            zip(*(future.result() for future in of_walks), strict=True),
            strict=True,
        )
    ]


def _wait(
    futures: list[Future[tuple[float, ...]]], progress: Callable[[float], None] | None
) -> None:
    """Wait for all, or raise what the first that fails raises."""
    for done, future in enumerate(as_completed(futures), start=1):
        future.result()
        if progress is not None:
            progress(done / len(futures))


def follow(approach: Approach, recording: Recording) -> Trajectory:
    """Track a recording the way of an approach."""
    if not approach.ranges_known:
        recording = Recording(recording.t, recording.accel, recording.gyro, name=recording.name)
    return track(recording, approach.config)


def _figures(experiment: Experiment, number: int) -> tuple[float, ...]:
    """Return the figure of each approach on one walk."""
    walk = experiment.walks.load(number)
    return tuple(
        experiment.figure(follow(approach, walk.recording), walk)
        for approach in experiment.approaches
    )
