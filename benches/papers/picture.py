"""Pictures of experiments: one walk from above, and the errors over all of them."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from footnav.errors import FootnavWarning
from footnav.files import replacing
from footnav.optional import require
from footnav.plot import FAINT, INK, TRACK, TRUTH, make_figure, style_axes
from papers.run import Outcome, follow

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHADES = (TRACK, "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442", "#000000")
"""Colours of the approaches, from Okabe and Ito's palette."""
MARGIN = 0.35
"""How far around the truth a track is drawn, in its greatest extent."""


def draw(outcomes: Sequence[Outcome], folder: Path) -> Path:
    """Draw an experiment.

    Parameters
    ----------
    outcomes : sequence of Outcome
        Results of its approaches.
    folder : Path
        Folder of the picture.

    Returns
    -------
    Path
        The picture, a PNG.

    Raises
    ------
    FootnavError
        When the file cannot be written, or matplotlib is missing.
    """
    experiment = outcomes[0].experiment
    figure = make_figure((11, 4.8))
    from_above, errors = figure.subplots(1, 2, width_ratios=(1, 1.1))
    _draw_tracks(outcomes, style_axes(from_above, "x or east (m)", "y or north (m)"))
    _draw_errors(outcomes, style_axes(errors, f"error ({experiment.unit})", ""))
    figure.suptitle(
        f"{experiment.paper}: {experiment.title}",
        x=0.01,
        ha="left",
        fontsize=12,
        fontweight="bold",
        color=INK,
    )
    path = folder / f"{_file_name(f'{experiment.paper} {experiment.title}')}.png"
    with replacing(path) as file:
        figure.savefig(file, format="png", dpi=120)
    return path


def _draw_tracks(outcomes: Sequence[Outcome], ax: Axes) -> None:
    """Draw the first walk, the approaches one above the other.

    What leaves the picture is cut off.
    """
    walk = outcomes[0].experiment.walks.load(0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FootnavWarning)
        tracks = [follow(outcome.approach, walk.recording).position for outcome in outcomes]
    frame = tracks[0] if walk.truth is None else walk.truth - walk.truth[0]
    for colour, position in zip(_shades(len(tracks)), tracks, strict=True):
        ax.plot(*position[:, :2].T, color=colour, lw=0.8, alpha=0.8)
    if walk.truth is not None:
        ax.plot(*frame[:, :2].T, color=TRUTH, lw=1.2, dashes=(4, 2), label="truth")
        ax.legend(
            loc="lower left", bbox_to_anchor=(0, 1), frameon=False, fontsize=8, borderaxespad=0
        )
    low, high = frame[:, :2].min(axis=0), frame[:, :2].max(axis=0)
    margin = MARGIN * float((high - low).max())
    ax.set_xlim(low[0] - margin, high[0] + margin)
    ax.set_ylim(low[1] - margin, high[1] + margin)
    ax.set_aspect("equal")


def _draw_errors(outcomes: Sequence[Outcome], ax: Axes) -> None:
    """Draw the median and what 90 % of the walks stay within, and where the paper is."""
    for place, (colour, outcome) in enumerate(zip(_shades(len(outcomes)), outcomes, strict=True)):
        ax.plot(
            [outcome.median, outcome.p90],
            [place, place],
            color=colour,
            lw=2.5,
            solid_capstyle="butt",
        )
        ax.plot(outcome.median, place, "o", color=colour, ms=6)
        if outcome.approach.paper is not None:
            ax.plot(outcome.approach.paper, place, "D", mfc="none", mec=INK, ms=6)
    ticker = require("matplotlib.ticker", "footnav[plot]")
    ax.set_xscale("log")
    ax.xaxis.set_major_locator(ticker.LogLocator(subs=(1, 2, 5)))
    ax.xaxis.set_major_formatter("{x:g}")
    ax.xaxis.set_minor_formatter(ticker.NullFormatter())
    ax.set_yticks(np.arange(len(outcomes)), [outcome.approach.name for outcome in outcomes])
    ax.invert_yaxis()
    ax.grid(visible=True, axis="x", color="#EEEEEE", lw=0.6)
    ax.set_axisbelow(True)
    ax.set_title(
        "dot: median, bar: to 90 % of the walks, diamond: paper",
        loc="right",
        fontsize=8,
        color=FAINT,
        pad=2,
    )


def _shades(count: int) -> list[str]:
    return [SHADES[k % len(SHADES)] for k in range(count)]


def _file_name(title: str) -> str:
    return re.sub(r"[^a-z0-9.]+", "-", title.lower()).strip("-")
