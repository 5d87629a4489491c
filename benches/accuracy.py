"""Effect of each ingredient of the default configuration.

``python benches/accuracy.py --data DIR [OPTIONS]``.

One ingredient at a time is taken out, or one added, and all recordings are tracked with what is
left.  DIR holds

    vicon/*.npz        t, accel, gyro and the true position of each sample; SI units
    openshoe/*.npz     t, accel, gyro of walks that end where they began
    mpu6050/*.csv      raw counts of an MPU6050 on each foot, conf-ABCD: indices of the ranges
                       of accelerometer and gyroscope, left and then right; walks that end
                       where they began
    xio/*.csv          an NGIMU's file of a walk that ends where it began

and a set that is not there is left out.  Under motion capture the figures are the ARMSE of Wagstaff
et al. 2019 and the RMS of the height; for the others, the distance between start and end, in
percent of the distance.
"""

from __future__ import annotations

import argparse
import json
import os
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.progress import track as progress

from footnav import Config, FootnavWarning, Recording, read, track
from footnav.config import Smoother
from footnav.detectors import AdaptiveShoe, Shoe
from footnav.evaluation import YAW_DISTANCE, path_length
from footnav.summary import Displacement

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

MPU6050_ACCEL_G = (2, 4, 8, 16)
MPU6050_GYRO_DPS = (250, 500, 1000, 2000)
DEFAULT = "default"


def without(**settings: Any) -> Config:
    """Return the default configuration with some settings of its sections changed.

    ``filter={"kind": "dr"}``.
    """
    base = Config()
    return base.replace(
        **{name: getattr(base, name).replace(**changes) for name, changes in settings.items()}
    )


CONFIGURATIONS = {
    DEFAULT: Config(),
    "fixed threshold (1e4)": Config(detector=Shoe(threshold=1e4)),
    "fixed threshold (3e4)": Config(detector=Shoe(threshold=3e4)),
    "no max_fraction": without(detector={"max_fraction": 1.0}),
    "no noise_floor": without(detector={"noise_floor": 0.0}),
    "no upper_bound": without(detector={"upper_bound": 1e12}),
    "no lever arm": without(filter={"contact_rate": 0.0}),
    "no zupt_lever_std": without(filter={"zupt_lever_std": 0.0}),
    "no zero-angular-rate update": without(filter={"zero_angular_rate": False}),
    "gyro_bias_std of 0.5 rad/s": without(sensor={"gyro_bias_std": 0.5}),
    "sensor noise only": without(filter={"specific_force_noise": 0.0, "angular_rate_noise": 0.0}),
    "no clipped_noise_factor": without(filter={"clipped_noise_factor": 1.0}),
    "chi2_gate of 16": without(filter={"chi2_gate": 16.0}),
    "chi2_gate of 16, no rejection_limit": without(
        filter={"chi2_gate": 16.0, "rejection_limit": 1e9}
    ),
    "no chi2_gate": without(filter={"chi2_gate": 1e12}),
    "single-sample mechanization": without(mechanization={"kind": "single-sample"}),
    "first-order mechanization": without(mechanization={"kind": "first-order"}),
    "velocity reset only (dr)": without(filter={"kind": "dr"}),
    "step-wise smoother": Config(smoother=Smoother(kind="stepwise")),
    "RTS smoother": Config(smoother=Smoother(kind="rts")),
    "live: 0.275 s latency": Config(detector=AdaptiveShoe.live()),
}


@dataclass(frozen=True, slots=True)
class Walk:
    """A recording and its truth.

    Attributes
    ----------
    group : str
        The set that it counts for.
    recording : Recording
        The samples.
    truth : ndarray of shape (n, 3) or None
        Position of each sample, m; without it the walk ends where it began.
    """

    group: str
    recording: Recording
    truth: NDArray[np.float64] | None = None


def main() -> None:
    """Track everything and print the table."""
    arguments = _arguments()
    console = Console(stderr=True)
    walks = list(walks_in(arguments.data))
    if not walks:
        raise SystemExit(f"{arguments.data} has none of the sets: see {Path(__file__).name} --help")
    jobs = list(CONFIGURATIONS.items())
    with ProcessPoolExecutor(os.cpu_count(), initializer=_share, initargs=(walks,)) as pool:
        rows = progress(
            pool.map(figures, [config for _, config in jobs]),
            "tracking",
            len(jobs),
            console=console,
        )
        table = {name: row for (name, _), row in zip(jobs, rows, strict=True)}
    print(markdown(table) if arguments.markdown else plain(table))
    if arguments.json is not None:
        arguments.json.write_text(json.dumps(table, indent=2) + "\n", encoding="utf-8")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--data", type=Path, required=True, help="folder with the sets")
    parser.add_argument("--json", type=Path, help="file for the figures")
    parser.add_argument(
        "--markdown", action="store_true", help="print the table as it stands in docs/accuracy.md"
    )
    return parser.parse_args()


def walks_in(folder: Path) -> Iterator[Walk]:
    """Read the sets that there are."""
    for group in ("vicon", "openshoe"):
        for path in sorted((folder / group).glob("*.npz")):
            with np.load(path) as file:
                recording = Recording(file["t"], file["accel"], file["gyro"], name=path.stem)
                yield Walk(group, recording, file.get("position"))
    for path in sorted((folder / "mpu6050").glob("conf-*.csv")):
        yield from _both_feet(path)
    for path in sorted((folder / "xio").glob("*.csv")):
        yield Walk("xio", read(path))


def _both_feet(path: Path) -> Iterator[Walk]:
    """Read a walk of two sensors; ranges of 2 g or 250 deg/s clip it."""
    ranges = [int(digit) for digit in path.name[5:9]]
    for foot, (accel, gyro) in (("left", ranges[:2]), ("right", ranges[2:])):
        recording = read(
            path,
            format="mpu6050-pair",
            foot=foot,
            accel_range=MPU6050_ACCEL_G[accel],
            gyro_range=MPU6050_GYRO_DPS[gyro],
        )
        yield Walk("mpu6050" if accel and gyro else "mpu6050 clipped", recording)


_walks: list[Walk] = []


def _share(walks: list[Walk]) -> None:
    """Give a process the recordings once, not with each task."""
    _walks[:] = walks
    warnings.simplefilter("ignore", FootnavWarning)


def figures(config: Config) -> dict[str, dict[str, float]]:
    """Return the figures of each set with a configuration."""
    errors: dict[str, list[dict[str, float]]] = {}
    for walk in _walks:
        errors.setdefault(walk.group, []).append(score(walk, config))
    return {group: summary(rows) for group, rows in errors.items()}


def score(walk: Walk, config: Config) -> dict[str, float]:
    """Return the errors of one walk, m and %."""
    states = track(walk.recording, config)
    if walk.truth is not None:
        return against(walk.truth, states.position)
    error = Displacement.of(states.position[-1] - states.position[0])
    share = error.percent_of(path_length(states.t, states.position))
    return {
        "horizontal_m": error.horizontal,
        "spatial_m": error.spatial,
        "horizontal_pct": share.horizontal,
        "spatial_pct": share.spatial,
    }


def against(truth: NDArray[np.float64], position: NDArray[np.float64]) -> dict[str, float]:
    """Return the errors against the truth, m: starts joined, yaw aligned 0.8 m from the start.

    As in Wagstaff et al. 2019 a track that stays nearer is aligned at its sample 300, not at its
    farthest one as `footnav.evaluate` does.
    """
    estimate, reference = (points - points[0] for points in (position, truth))
    way, true_way = (points[:, 0] + 1j * points[:, 1] for points in (estimate, reference))
    far = np.flatnonzero(np.abs(way) >= YAW_DISTANCE)
    k = far[0] if far.size else min(300, len(way) - 1)
    turn = np.exp(1j * (np.angle(true_way[k]) - np.angle(way[k])))
    height = estimate[:, 2] - reference[:, 2]
    return {
        "armse": float(np.abs(turn * way - true_way).mean() / np.sqrt(2)),
        "height": float(np.sqrt((height**2).mean())),
    }


def summary(rows: list[dict[str, float]]) -> dict[str, float]:
    """Mean, 90th percentile and maximum under motion capture.

    Medians for the walks that are closed.
    """
    columns = {key: np.array([row[key] for row in rows]) for key in rows[0]}
    if "armse" not in columns:
        return {key: float(np.median(values)) for key, values in columns.items()}
    armse = columns["armse"]
    return {
        "armse_mean": float(armse.mean()),
        "armse_p90": float(np.quantile(armse, 0.9, method="higher")),
        "armse_max": float(armse.max()),
        "height_rms": float(columns["height"].mean()),
    }


COLUMNS = {
    "vicon mean": ("vicon", "armse_mean", ".3f"),
    "p90": ("vicon", "armse_p90", ".3f"),
    "max": ("vicon", "armse_max", ".3f"),
    "height": ("vicon", "height_rms", ".2f"),
    "openshoe": ("openshoe", "horizontal_pct", ".2f"),
    "3D": ("openshoe", "spatial_pct", ".2f"),
    "mpu6050": ("mpu6050", "horizontal_pct", ".2f"),
    "3D ": ("mpu6050", "spatial_pct", ".2f"),
    "clipped": ("mpu6050 clipped", "horizontal_pct", ".2f"),
    "3D  ": ("mpu6050 clipped", "spatial_pct", ".2f"),
    "xio": ("xio", "horizontal_m", ".2f"),
    "3D   ": ("xio", "spatial_m", ".2f"),
}


def cells(table: dict[str, dict[str, dict[str, float]]]) -> list[list[str]]:
    """Return the table as text, a row for each configuration, its head first."""
    columns = {head: place for head, place in COLUMNS.items() if place[0] in table[DEFAULT]}
    body = [
        [name, *(format(row[group][key], digits) for group, key, digits in columns.values())]
        for name, row in table.items()
    ]
    return [["", *(head.strip() for head in columns)], *body]


def markdown(table: dict[str, dict[str, dict[str, float]]]) -> str:
    """Return the table as Markdown."""
    head, *body = ["| " + " | ".join(row) + " |" for row in cells(table)]
    return "\n".join([head, "|---" * len(cells(table)[0]) + "|", *body])


def plain(table: dict[str, dict[str, dict[str, float]]]) -> str:
    """Return the table as aligned text."""
    rows = cells(table)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = [
        [cell.rjust(width) for cell, width in zip(row[1:], widths[1:], strict=True)] for row in rows
    ]
    return "\n".join(
        "  ".join([row[0].ljust(widths[0]), *line]) for row, line in zip(rows, lines, strict=True)
    )


if __name__ == "__main__":
    main()
