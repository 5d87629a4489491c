"""Text and tables of tracks and noise."""

import dataclasses
import io
import math
from collections.abc import Sequence
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from footnav.evaluation import Evaluation
from footnav.noise import AxisNoise, Figure, NoiseFigures
from footnav.recording import STANDARD_GRAVITY
from footnav.summary import Summary

_DEGREE = 180 / math.pi
_HOUR = 3600.0
_MILLI_G = 1e3 / STANDARD_GRAVITY

_NOISE_UNITS = {
    "gyro": (
        ("quantization", "rad", ("deg", _DEGREE)),
        ("angle random walk", "rad/s/sqrt(Hz)", ("deg/sqrt(h)", _DEGREE * _HOUR**0.5)),
        ("bias instability", "rad/s", ("deg/h", _DEGREE * _HOUR)),
        ("bias random walk", "rad/s/sqrt(s)", ("deg/h/sqrt(h)", _DEGREE * _HOUR**1.5)),
    ),
    "accel": (
        ("quantization", "m/s", ("mm/s", 1e3)),
        ("velocity random walk", "m/s^2/sqrt(Hz)", ("m/s/sqrt(h)", _HOUR**0.5)),
        ("bias instability", "m/s^2", ("mg", _MILLI_G)),
        ("bias random walk", "m/s^2/sqrt(s)", ("mg/sqrt(h)", _MILLI_G * _HOUR**0.5)),
    ),
}
"""Name of each noise term, its SI unit, and the unit of data sheets with its factor."""


def describe(summary: Summary, written: Sequence[Path]) -> str:
    """Summarize one walk.

    Parameters
    ----------
    summary : Summary
        Of the walk.
    written : sequence of Path
        Files that were written.

    Returns
    -------
    str
        Several lines.
    """
    lines = [str(dataclasses.replace(summary, health=None))]
    if summary.health is not None:
        lines.append(
            f"  health         {summary.health.status.value}. {summary.health.flags.describe()}"
        )
    lines.append(f"  written        {', '.join(map(str, written))}")
    return "\n".join(lines)


def summary_table(summaries: Sequence[Summary]) -> Table:
    """Tabulate several walks.

    Parameters
    ----------
    summaries : sequence of Summary
        One for each walk.

    Returns
    -------
    Table
        A row for each walk.
    """
    table = _table("walk", "distance", "strides", "start to end", "height", "one sigma", "health")
    for summary in summaries:
        closing, share = summary.closing, summary.closing_percent
        table.add_row(
            Text(summary.name),
            f"{summary.distance:.2f} m",
            f"{summary.strides}",
            f"{closing.horizontal:.2f} m ({share.horizontal:.1f} %)",
            f"{closing.vertical:+.2f} m",
            f"{summary.horizontal_std:.2f} m",
            summary.health.status.value if summary.health else "",
        )
    return table


def comparison_table(track: Summary, truth: Summary, evaluation: Evaluation, rate: float) -> Table:
    """Tabulate a track and its errors against the truth.

    Parameters
    ----------
    track, truth : Summary
        Of the track and of the truth.
    evaluation : Evaluation
        Of the track against the truth.
    rate : float
        Samples tracked in a second.

    Returns
    -------
    Table
        A row for each figure.
    """
    table = _table("", "track", "truth")
    end = evaluation.closing_error
    table.add_row("distance", f"{track.distance:.2f} m", f"{truth.distance:.2f} m")
    table.add_row("strides", f"{track.strides}", f"{truth.strides}")
    table.add_row(
        "zero velocity", _percent(track.zero_velocity_share), _percent(truth.zero_velocity_share)
    )
    table.add_row("mean horizontal error", f"{evaluation.euclidean_mean:.3f} m")
    table.add_row("closing error, horizontal", f"{end.horizontal:.3f} m")
    table.add_row("closing error, vertical", f"{end.vertical:+.3f} m")
    table.add_row("closing error, of the distance", f"{evaluation.percent_of_distance:.2f} %")
    table.add_row("speed", f"{rate:,.0f} samples/s")
    return table


def noise_table(figures: NoiseFigures) -> Table:
    """Tabulate the noise of the axes, in the units of data sheets and in SI.

    Parameters
    ----------
    figures : NoiseFigures
        Of a sensor.

    Returns
    -------
    Table
        A row for each term, with intervals of 95 % or upper limits, and one in SI if it is
        significant.
    """
    table = _table("", "unit", "x", "y", "z")
    for sensor, terms in _NOISE_UNITS.items():
        axes = [axis for axis in figures.axes if axis.channel.startswith(sensor)]
        for term, (title, unit, (sheet_unit, factor)) in enumerate(terms):
            table.add_row(
                f"{sensor} {title}", sheet_unit, *(_interval(axis, term, factor) for axis in axes)
            )
            if any(axis.terms[term].value is not None for axis in axes):
                table.add_row("", unit, *(_value(axis.terms[term]) for axis in axes))
    return table


def _interval(axis: AxisNoise, term: int, factor: float) -> str:
    figure = axis.terms[term].scaled(factor)
    if figure.value is None:
        return f"not seen, < {figure.high:.2g}"
    return f"{figure.value:.3g} ({figure.low:.3g} to {figure.high:.3g})"


def _value(figure: Figure) -> str:
    return "" if figure.value is None else f"{figure.value:.3g}"


def as_text(table: Table) -> str:
    """Render a table without colours."""
    file = io.StringIO()
    Console(file=file, width=100, color_system=None).print(table)
    return "".join(f"{line.rstrip()}\n" for line in file.getvalue().splitlines())


def _table(first: str, *others: str) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column(first, overflow="fold")
    for title in others:
        table.add_column(title, justify="right", no_wrap=True)
    return table


def _percent(share: float) -> str:
    return f"{100 * share:.1f} %"
