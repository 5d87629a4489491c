"""Speed as Python sees it: `python benches/speed.py [--data DIR] [--json FILE]`.

The figures are medians of interleaved repeats, in nanoseconds of processor time per sample, so that
what else runs on the machine disturbs all of them alike.  Compare ratios: each figure is also given
in units of one dense 15x15 prediction F P F' + Q in NumPy, which the machine needs at the same
time.

Without recordings, a walk of a fixed seed is simulated.  The baseline is measured in a process of
its own, since the kernel is chosen once per process.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import time
import warnings
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING

import numpy as np

import footnav
from footnav import Config
from footnav.recording import STANDARD_GRAVITY

if TYPE_CHECKING:
    from collections.abc import Callable

    from footnav import Recording

REPEATS = 7
STREAMED = 4
"""Recordings that are also streamed; a stream is slow to feed from Python."""
BLOCK = 20

Task = tuple[int, "Callable[[], object]"]
"""Number of samples, and the work on them."""


def main() -> None:
    """Measure, print and write."""
    arguments = _arguments()
    warnings.simplefilter("ignore", footnav.FootnavWarning)
    recordings = _recordings(arguments.data)
    tasks = _tasks(recordings)
    if not arguments.baseline:
        tasks |= _peers(recordings, _samples(recordings))
    figures = _measure(tasks, arguments.repeats)
    report = {
        "footnav": footnav.__version__,
        "machine": f"{platform.machine()}, {_processor()}",
        "python": platform.python_version(),
        "kernel": os.environ.get("FOOTNAV_KERNEL", "the processor's best"),
        "recordings": len(recordings),
        "samples": _samples(recordings),
        "ns_per_sample": figures,
    }
    if arguments.baseline:
        print(json.dumps(report))
        return
    report["ns_per_sample_plain"] = _baseline(arguments)
    _print(report)
    if arguments.json is not None:
        arguments.json.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Speed of footnav as Python sees it.")
    parser.add_argument(
        "--data", type=Path, help="folder with vicon/*.npz; a walk is simulated without it"
    )
    parser.add_argument("--json", type=Path, help="file for the figures")
    parser.add_argument(
        "--repeats", type=int, default=REPEATS, help="interleaved repeats of each figure"
    )
    parser.add_argument("--baseline", action="store_true", help=argparse.SUPPRESS)
    return parser.parse_args()


def _recordings(data: Path | None) -> list[Recording]:
    if data is None:
        recording, _ = footnav.simulate([[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]], seed=1)
        return [recording]
    files = sorted((data / "vicon").glob("*.npz"))
    if not files:
        raise SystemExit(f"{data / 'vicon'} holds no .npz")
    return [footnav.read(file) for file in files]


def _samples(recordings: list[Recording]) -> int:
    return sum(len(recording) for recording in recordings)


def _tasks(recordings: list[Recording]) -> dict[str, Task]:
    shoe = Config(detector=footnav.detectors.Shoe())
    rts = Config(smoother=footnav.config.Smoother(kind="rts"))
    samples = _samples(recordings)
    streamed = recordings[:STREAMED]
    rows = [np.column_stack([r.t, r.accel, r.gyro]).tolist() for r in streamed]
    fed = sum(len(row) for row in rows)
    return {
        "dense F P F' + Q": (1_000, _dense),
        "track, shoe": (samples, lambda: _track(recordings, shoe)),
        "track": (samples, lambda: _track(recordings, Config())),
        "track, rts": (samples, lambda: _track(recordings, rts)),
        "push, shoe": (fed, lambda: _push(streamed, rows, shoe)),
        "push": (fed, lambda: _push(streamed, rows, Config())),
        "push_block of 20": (fed, lambda: _push_blocks(streamed)),
        "an empty Python function of seven floats": (fed, lambda: _call(rows)),
    }


def _dense() -> None:
    f, p, q = np.eye(15), np.eye(15), np.eye(15)
    for _ in range(1_000):
        f @ p @ f.T + q


def _track(recordings: list[Recording], config: Config) -> None:
    for recording in recordings:
        footnav.track(recording, config)


def _push(recordings: list[Recording], rows: list[list[list[float]]], config: Config) -> None:
    for recording, samples in zip(recordings, rows, strict=True):
        push = footnav.Navigator(config, rate_hz=recording.rate_hz).push
        for t, ax, ay, az, gx, gy, gz in samples:
            push(t, ax, ay, az, gx, gy, gz)


def _push_blocks(recordings: list[Recording]) -> None:
    for recording in recordings:
        navigator = footnav.Navigator(rate_hz=recording.rate_hz)
        for start in range(0, len(recording), BLOCK):
            part = slice(start, start + BLOCK)
            navigator.push_block(recording.t[part], recording.accel[part], recording.gyro[part])


def _call(rows: list[list[list[float]]]) -> None:
    def nothing(t: float, ax: float, ay: float, az: float, gx: float, gy: float, gz: float) -> None:
        pass

    for samples in rows:
        for t, ax, ay, az, gx, gy, gz in samples:
            nothing(t, ax, ay, az, gx, gy, gz)


def _peers(recordings: list[Recording], samples: int) -> dict[str, Task]:
    """Find other libraries, as far as they are installed; what they are given is in their units."""
    found = {"imufusion 1.3, attitude alone": _imufusion, "gaitmap RtsKalman": _gaitmap}
    peers: dict[str, Task] = {}
    for name, prepare in found.items():
        try:
            peers[name] = (samples, prepare(recordings))
        except ImportError:
            continue
    return peers


def _imufusion(recordings: list[Recording]) -> Callable[[], None]:
    """Attitude and heading, one call for each sample."""
    import imufusion

    inputs = [
        (1 / r.rate_hz, list(np.degrees(r.gyro)), list(r.accel / STANDARD_GRAVITY))
        for r in recordings
    ]

    def work() -> None:
        for interval, gyro, accel in inputs:
            update = imufusion.Ahrs().set_sample_period(interval).update_no_magnetometer
            for rates, force in zip(gyro, accel, strict=True):
                update(rates, force)

    return work


def _gaitmap(recordings: list[Recording]) -> Callable[[], None]:
    """Smoothed track of each recording as a whole; compiled before the clock runs."""
    import pandas as pd
    from gaitmap.trajectory_reconstruction import RtsKalman

    columns = [f"{sensor}_{axis}" for sensor in ("acc", "gyr") for axis in "xyz"]
    tables = [
        pd.DataFrame(np.hstack([r.accel, np.degrees(r.gyro)]), columns=columns) for r in recordings
    ]

    def work() -> None:
        for recording, table in zip(recordings, tables, strict=True):
            RtsKalman().estimate(table, sampling_rate_hz=recording.rate_hz)

    RtsKalman().estimate(tables[0], sampling_rate_hz=recordings[0].rate_hz)
    return work


def _measure(tasks: dict[str, Task], repeats: int) -> dict[str, float]:
    times: dict[str, list[float]] = {name: [] for name in tasks}
    for _ in range(repeats):
        for name, (samples, work) in tasks.items():
            start = time.process_time()
            work()
            times[name].append(1e9 * (time.process_time() - start) / samples)
    return {name: median(values) for name, values in times.items()}


def _baseline(arguments: argparse.Namespace) -> dict[str, float]:
    """Measure again with the kernel that runs on every processor."""
    command = [sys.executable, __file__, "--baseline", "--repeats", str(arguments.repeats)]
    if arguments.data is not None:
        command += ["--data", str(arguments.data)]
    environment = os.environ | {"FOOTNAV_KERNEL": "plain"}
    result = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    figures: dict[str, float] = json.loads(result.stdout)["ns_per_sample"]
    return figures


def _processor() -> str:
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor()
    names = [
        line.partition(":")[2].strip()
        for line in text.splitlines()
        if line.startswith("model name")
    ]
    return names[0] if names else platform.processor()


def _print(report: dict[str, object]) -> None:
    best, plain = report["ns_per_sample"], report["ns_per_sample_plain"]
    assert isinstance(best, dict)
    assert isinstance(plain, dict)
    dense = best["dense F P F' + Q"]
    print(
        f"{report['samples']:,} samples of {report['recordings']} recordings; {report['machine']}"
    )
    print(f"{'':42} {'ns':>8} {'dense':>7} {'plain':>8} {'ratio':>6}")
    for name, value in best.items():
        line = f"{name:42} {value:8.0f} {value / dense:7.3f}"
        print(f"{line} {plain[name]:8.0f} {plain[name] / value:6.2f}" if name in plain else line)


if __name__ == "__main__":
    main()
