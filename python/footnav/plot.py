"""Pictures of a track, and of a sensor's noise.

Every function draws on the given axes, or on a new figure that pyplot does not manage
of, and returns the axes or the figure; ``.figure.savefig(...)`` writes it.
"""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, get_args

import numpy as np
from numpy.typing import NDArray

from footnav.detection import Detection, detect
from footnav.detectors import Condition, ThreeCondition
from footnav.errors import ConfigError, DataError
from footnav.evaluation import Truth, find_alignment, true_positions
from footnav.files import replacing
from footnav.optional import require
from footnav.recording import STANDARD_GRAVITY
from footnav.strides import find_stances
from footnav.trajectory import Trajectory

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from footnav.allan import AllanDeviation
    from footnav.noise import NoiseFigures
    from footnav.recording import Recording

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

PICTURES = (".png", ".svg", ".pdf")

# Okabe and Ito's palette, which colour-blind readers can distinguish.
TRACK = "#0072B2"
TRUTH = "#D55E00"
INK = "#333333"
FAINT = "#767676"
STANCE = "#DCE6EE"
AXES = {"x": "#0072B2", "y": "#D55E00", "z": "#009E73"}
BEHIND_TEXT = {"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 0.8}

SHARE_DRAWN = 0.1
"""Share of the variance from which on a kind of noise is drawn separately."""


def plot_track(
    traj: Trajectory, truth: Truth | None = None, ax: Axes | None = None, *, align: str = "yaw"
) -> Axes:
    """Draw a track from above, with the stances.

    Parameters
    ----------
    traj : Trajectory
        The track; two samples or more when there is a truth.
    truth : optional
        As for `footnav.evaluate`; drawn dashed, in the frame of the track.
    ax : Axes, optional
        Axes to draw on; new ones unless given.
    align : str
        Alignment of the truth with the track, as for `footnav.evaluate`.

    Returns
    -------
    Axes
        Equal scales, m.

    Raises
    ------
    DataError
        For an empty track, or a truth that does not fit it.
    FootnavError
        When matplotlib is missing.
    """
    _check_not_empty(traj)
    ax = style_axes(ax, "x or east (m)", "y or north (m)")
    if truth is not None:
        position = true_positions(traj, truth)
        position = find_alignment(traj.position, position, align).undo(position)
        ax.plot(*position[:, :2].T, color=TRUTH, lw=1.1, dashes=(4, 2), label="truth", zorder=3)
    ax.plot(*traj.position[:, :2].T, color=TRACK, lw=1.0, alpha=0.65, label="track", zorder=2)
    standing = traj.position[_stance_middles(traj)]
    ax.plot(*standing[:, :2].T, "o", color=TRACK, ms=3, mew=0, label="stance", zorder=4)
    _mark_ends(ax, traj.position)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.08)
    ax.grid(visible=True, color="#EEEEEE", lw=0.6)
    ax.set_axisbelow(True)
    _legend_above(ax)
    return ax


def plot_height(
    traj: Trajectory, truth: Truth | None = None, ax: Axes | None = None, *, align: str = "yaw"
) -> Axes:
    """Draw the height over time; parameters, errors and return value as for `plot_track`."""
    _check_not_empty(traj)
    ax = style_axes(ax, "time (s)", "height (m)")
    if truth is not None:
        position = true_positions(traj, truth)
        position = find_alignment(traj.position, position, align).undo(position)
        ax.plot(traj.t, position[:, 2], color=TRUTH, lw=1.1, dashes=(4, 2), zorder=3)
    ax.plot(traj.t, traj.position[:, 2], color=TRACK, lw=0.9, alpha=0.65)
    middles = _stance_middles(traj)
    ax.plot(traj.t[middles], traj.position[middles, 2], "o", color=TRACK, ms=2.5, mew=0, zorder=4)
    _fit_time(ax, traj.t)
    return ax


def plot_velocity(traj: Trajectory, ax: Axes | None = None) -> Axes:
    """Draw the speed over time, the samples at rest shaded.

    Parameters
    ----------
    traj : Trajectory
        The track.
    ax : Axes, optional
        Axes to draw on; new ones unless given.

    Returns
    -------
    Axes
        Time in s, speed in m/s.

    Raises
    ------
    DataError
        For an empty track.
    FootnavError
        When matplotlib is missing.
    """
    _check_not_empty(traj)
    ax = style_axes(ax, "time (s)", "speed (m/s)")
    _shade(ax, traj.t, traj.zero_velocity)
    ax.plot(traj.t, np.linalg.norm(traj.velocity, axis=1), color=TRACK, lw=0.9)
    ax.set_ylim(bottom=0)
    _fit_time(ax, traj.t)
    return ax


def plot_detector(detection: Detection, ax: Axes | None = None) -> Axes:
    """Draw a detector's statistic and threshold, with the stances shaded.

    Parameters
    ----------
    detection : Detection
        As `footnav.detect` returns it, one sample or more.
    ax : Axes, optional
        Axes to draw on; new ones unless given.

    Returns
    -------
    Axes
        Time in s; the statistic's axis is logarithmic.

    Raises
    ------
    DataError
        For a detection without samples, or a statistic or threshold that is nowhere positive.
    FootnavError
        When matplotlib is missing.
    """
    t, statistic, threshold = detection.t, detection.statistic, detection.threshold
    if not (np.any(statistic > 0) and np.any(threshold > 0)):
        raise DataError(
            "the detection is empty, or its statistic or threshold is nowhere positive: nothing "
            "to draw"
        )
    ax = style_axes(ax, "time (s)", "detector statistic")
    _shade(ax, t, detection.decision)
    ax.set_yscale("log")
    ax.plot(t, np.where(statistic > 0, statistic, np.nan), color=INK, lw=0.7)
    ax.plot(t, np.where(threshold > 0, threshold, np.nan), color=TRUTH, lw=1.0)
    last = np.flatnonzero(threshold > 0)[-1]
    ax.annotate(
        "threshold",
        (t[last], threshold[last]),
        xytext=(-3, 3),
        textcoords="offset points",
        ha="right",
        color=TRUTH,
        fontsize=8,
        bbox=BEHIND_TEXT,
    )
    _fit_time(ax, t)
    return ax


def plot_conditions(recording: Recording, detector: ThreeCondition | None = None) -> Figure:
    """Draw each condition of the three-condition detector alone, and all of them together.

    Wang Libing et al. 2016 compare them so in their fig. 3.

    Parameters
    ----------
    recording : Recording
        The samples.
    detector : ThreeCondition, optional
        The thresholds; which of the conditions it uses does not matter.

    Returns
    -------
    Figure
        One panel for each condition and one for all, as `plot_detector` draws them: each quantity
        in units of its threshold.

    Raises
    ------
    ConfigError
        Settings out of range.
    DataError
        As `plot_detector`.
    FootnavError
        When matplotlib is missing.
    """
    detector = detector or ThreeCondition()
    every: tuple[Condition, ...] = get_args(Condition)
    panels = [*((condition,) for condition in every), every]
    figure = make_figure((8, 8))
    for ax, conditions in zip(figure.subplots(len(panels), sharex=True), panels, strict=True):
        plot_detector(detect(recording, detector.replace(conditions=conditions)), ax)
        ax.set_ylabel(conditions[0] if len(conditions) == 1 else "all")
        ax.label_outer()
    return figure


def overview(
    traj: Trajectory,
    truth: Truth | None = None,
    detection: Detection | None = None,
    title: str | None = None,
    *,
    align: str = "yaw",
) -> Figure:
    """Draw the track with its height, its speed and, when given, the detector.

    Parameters
    ----------
    traj : Trajectory
        The track.
    truth : optional
        As for `plot_track`.
    detection : Detection, optional
        As for `plot_detector`.
    title : str, optional
        Default: the name of the track.
    align : str
        As for `plot_track`.

    Returns
    -------
    Figure
        Unknown to pyplot.

    Raises
    ------
    DataError
        As the plots that it is made of.
    FootnavError
        When matplotlib is missing.
    """
    rows = 3 if detection is not None else 2
    figure = make_figure((11, 6))
    grid = figure.add_gridspec(rows, 2, width_ratios=(1.35, 1))
    plot_track(traj, truth, figure.add_subplot(grid[:, 0]), align=align)
    beside = [figure.add_subplot(grid[0, 1])]
    beside += [figure.add_subplot(grid[row, 1], sharex=beside[0]) for row in range(1, rows)]
    plot_height(traj, truth, beside[0], align=align)
    plot_velocity(traj, beside[1])
    if detection is not None:
        plot_detector(detection, beside[2])
    for ax in beside[:-1]:
        ax.set_xlabel("")
        ax.tick_params(labelbottom=False)
    title = traj.name if title is None else title
    if title:
        figure.suptitle(title, x=0.01, ha="left", fontsize=12, fontweight="bold", color=INK)
    return figure


def save_overview(
    traj: Trajectory,
    path: str | PathLike[str],
    truth: Truth | None = None,
    detection: Detection | None = None,
    title: str | None = None,
    *,
    align: str = "yaw",
) -> None:
    """Write the overview to a picture, atomically.

    Parameters
    ----------
    traj : Trajectory
        As for `overview`.
    path : path
        ``.png``, ``.svg`` or ``.pdf``.
    truth : optional
        As for `overview`.
    detection : Detection, optional
        As for `overview`.
    title : str, optional
        As for `overview`.
    align : str
        As for `overview`.

    Raises
    ------
    ConfigError
        For another suffix.
    DataError
        As `overview`.
    FootnavError
        When the file cannot be written, or matplotlib is missing.
    """
    check_picture(path)
    save_figure(overview(traj, truth, detection, title, align=align), path)


def plot_allan(deviation: AllanDeviation, figures: NoiseFigures | None = None) -> Figure:
    """Draw the Allan deviation of each axis over the averaging time, gyroscope above accelerometer.

    Parameters
    ----------
    deviation : AllanDeviation
        As `footnav.allan` returns it; drawn with the interval that holds the true one in 95 % of
        all recordings.
    figures : NoiseFigures, optional
        Fitted noise: drawn dashed, and each kind of noise dotted where it makes up a tenth of the
        variance.

    Returns
    -------
    Figure
        Unknown to pyplot; s, deg/h and mg.

    Raises
    ------
    FootnavError
        When matplotlib is missing.
    """
    figure = make_figure((7, 8))
    panels = {
        "gyro": ("gyroscope (deg/h)", np.degrees(3600.0)),
        "accel": ("accelerometer (mg)", 1e3 / STANDARD_GRAVITY),
    }
    for ax, (sensor, (label, factor)) in zip(
        figure.subplots(2, sharex=True), panels.items(), strict=True
    ):
        style_axes(ax, "averaging time (s)", f"Allan deviation of the {label}")
        ax.set(xscale="log", yscale="log")
        for column, channel in enumerate(deviation.channels):
            if channel.startswith(sensor):
                _draw_axis(ax, deviation, figures, column, factor)
        ax.yaxis.get_major_locator().set_params(subs=(1, 2, 5))
        ax.yaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_minor_formatter("")
        ax.grid(visible=True, which="major", color="#EEEEEE", lw=0.6)
        ax.set_axisbelow(True)
        _legend_above(ax)
        if figures is not None:
            ax.set_title(
                "dashed: fit, dotted: each noise alone", loc="right", fontsize=8, color=FAINT, pad=2
            )
        ax.label_outer()
    if deviation.name:
        figure.suptitle(
            deviation.name, x=0.01, ha="left", fontsize=12, fontweight="bold", color=INK
        )
    return figure


def _draw_axis(
    ax: Axes, deviation: AllanDeviation, figures: NoiseFigures | None, column: int, factor: float
) -> None:
    """Draw one channel, scaled by `factor`."""
    taus, axis = deviation.taus, deviation.channels[column][-1]
    color = AXES[axis]
    ax.fill_between(
        taus,
        factor * deviation.low[:, column],
        factor * deviation.high[:, column],
        color=color,
        alpha=0.15,
        lw=0,
    )
    ax.plot(taus, factor * deviation.deviations[:, column], color=color, lw=1.2, label=axis)
    if figures is not None:
        terms = figures.axes[column].deviations(taus)
        total = np.linalg.norm(terms, axis=1)
        ax.plot(taus, factor * total, color=color, lw=0.8, dashes=(4, 2))
        weighty = np.where(terms**2 > SHARE_DRAWN * total[:, None] ** 2, terms, np.nan)
        ax.plot(taus, factor * weighty, color=color, lw=0.9, ls=":")


def check_picture(path: str | PathLike[str]) -> None:
    """Raise ConfigError for a suffix that is not a format of a picture."""
    suffix = Path(path).suffix.lower()
    if suffix not in PICTURES:
        raise ConfigError(
            f"{path}: unknown suffix {suffix!r}, expected one of {', '.join(PICTURES)}"
        )


def save_figure(figure: Figure, path: str | PathLike[str]) -> None:
    """Write a figure to a picture, atomically.

    Parameters
    ----------
    figure : Figure
        The figure.
    path : path
        ``.png``, ``.svg`` or ``.pdf``.

    Raises
    ------
    ConfigError
        For another suffix.
    FootnavError
        When the file cannot be written.
    """
    check_picture(path)
    with replacing(path) as file:
        figure.savefig(file, format=Path(path).suffix[1:].lower(), dpi=150)


def make_figure(size: tuple[float, float]) -> Figure:
    """Make a figure that pyplot does not manage."""
    figure: Figure = require("matplotlib.figure", "footnav[plot]").Figure(
        figsize=size, layout="constrained"
    )
    return figure


def style_axes(ax: Axes | None, xlabel: str, ylabel: str) -> Axes:
    """Set labels and style of axes, new ones if None."""
    if ax is None:
        ax = make_figure((6, 4.5)).add_subplot()
    ax.set_xlabel(xlabel, color=INK, fontsize=9)
    ax.set_ylabel(ylabel, color=INK, fontsize=9)
    ax.spines[["top", "right"]].set_visible(False)
    ax.spines[["left", "bottom"]].set(linewidth=0.6, color=FAINT)
    ax.tick_params(width=0.6, color=FAINT, labelcolor=INK, labelsize=8)
    return ax


def _mark_ends(ax: Axes, position: Floats) -> None:
    """Mark both ends; on a closed walk they coincide, so the legend names them."""
    for label, row, marker, size in (("start", 0, "o", 8), ("end", -1, "s", 5)):
        ax.plot(
            *position[row, :2],
            marker,
            mfc="white",
            mec=INK,
            mew=1.2,
            ms=size,
            label=label,
            lw=0,
            zorder=5,
        )


def _legend_above(ax: Axes) -> None:
    legend = ax.legend(
        loc="lower left", bbox_to_anchor=(0, 1), ncols=5, frameon=False, fontsize=8, borderaxespad=0
    )
    for text in legend.get_texts():
        text.set_color(INK)


def _shade(ax: Axes, t: Floats, flag: Flags) -> None:
    """Mark the samples at rest over the whole height of the axes."""
    ax.fill_between(
        t, 0, 1, where=flag, transform=ax.get_xaxis_transform(), color=STANCE, lw=0, zorder=0
    )
    ax.set_title("shaded: foot at rest", loc="right", fontsize=8, color=FAINT, pad=2)


def _fit_time(ax: Axes, t: Floats) -> None:
    if t[-1] > t[0]:
        ax.set_xlim(t[0], t[-1])


def _stance_middles(traj: Trajectory) -> NDArray[np.intp]:
    first, last = find_stances(traj.t, traj.zero_velocity)
    return (first + last) // 2


def _check_not_empty(traj: Trajectory) -> None:
    if len(traj) == 0:
        raise DataError("the track is empty: there is nothing to draw")
