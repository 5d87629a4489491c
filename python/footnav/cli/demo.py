"""`footnav demo`."""

import time
from pathlib import Path

from footnav.cli.console import make_folder, print_table, reporting
from footnav.cli.report import as_text, comparison_table
from footnav.config import Config
from footnav.evaluation import evaluate
from footnav.files import replacing
from footnav.optional import require
from footnav.plot import save_overview
from footnav.simulation import Route, simulate
from footnav.tracking import track

SIDE = 10.0
"""Side of the square, m."""

RATE_HZ = 200.0

EASTWARDS_DEG = 90.0
"""Heading of the first side of the square."""

ORIGIN = (45.0, 7.0, 0.0)
"""Georeference of the walk: the latitude and height of the default gravity."""


def run_demo(*, out: Path = Path("demo"), seed: int = 1) -> int:
    """Simulate a walk with an MPU6050 on the shoe, track it, and compare the track with the truth.

    Parameters
    ----------
    out : Path
        Folder for the recording, the track, its picture and the table.
    seed : int
        Seed of the walk and of the sensor.

    Returns
    -------
    int
        Exit status.
    """
    require("matplotlib", "footnav[plot]")
    make_folder(out)
    config = Config.preset("mpu6050")
    config = config.replace(alignment=config.alignment.replace(heading_deg=EASTWARDS_DEG))
    recording, truth = simulate(Route.square(SIDE), "walk", "mpu6050", seed, rate_hz=RATE_HZ)
    title = f"A simulated walk around a square of {SIDE:g} m with an MPU6050"
    with reporting(recording.name) as progress:
        started = time.perf_counter()
        trajectory = track(recording, config, progress=progress)
        rate = len(recording) / (time.perf_counter() - started)
        recording.save(out / "recording.csv")
        trajectory.save(out / "track.csv")
        trajectory.save(out / "track.geojson", origin=ORIGIN)
        save_overview(trajectory, out / "track.png", truth, title=title)
    table = comparison_table(
        trajectory.summary(), truth.summary(), evaluate(trajectory, truth), rate
    )
    with replacing(out / "table.txt") as file:
        file.write(as_text(table).encode())
    print(title)
    print_table(table)
    print(f"Written to {out}: recording.csv, track.csv, track.geojson, track.png, table.txt")
    return 0
