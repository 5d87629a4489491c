"""A walk of 14 hours in one stream: `python benches/long_run.py [--millions N]`.

A simulated round is walked again and again.  Each line gives, after another million samples, the
processor time of one sample in that million and the memory that the process holds: neither may
grow.  In the end the detector, which keeps running sums, is compared with one that saw the last
seconds only.
"""

from __future__ import annotations

import argparse
import resource
import sys
import time
from pathlib import Path

import numpy as np

import footnav
from footnav import Navigator, Recording

MILLION = 1_000_000
BLOCK = 1_000
LAST = 4_000
"""Samples that the second detector sees; its window is full long before the last of them."""


def main() -> None:
    """Walk, and compare."""
    parser = argparse.ArgumentParser(description="Walk for 14 hours in one stream.")
    parser.add_argument("--millions", type=int, default=10, help="samples, in millions")
    millions = parser.parse_args().millions
    walk, _ = footnav.simulate(
        [[0, 0], [20, 0], [20, 20], [0, 20], [0, 0]],
        sensor=footnav.simulation.SensorErrors.preset("mpu6050"),
        seed=1,
    )
    navigator = Navigator(rate_hz=walk.rate_hz)
    print("samples        ns/sample   MB held")
    for number in range(millions):
        start = time.process_time()
        for first in range(number * MILLION, (number + 1) * MILLION, BLOCK):
            navigator.push_block(*_rows(walk, np.arange(first, first + BLOCK)))
        spent = time.process_time() - start
        print(
            f"{(number + 1) * MILLION:11,} {1e9 * spent / MILLION:10.0f} {_held() / 1e6:9.1f}",
            flush=True,
        )
    print(navigator.health)
    _compare(walk, millions * MILLION)


def _rows(walk: Recording, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return these rows of the endless walk."""
    rounds, row = np.divmod(rows, len(walk))
    duration = walk.t[-1] - walk.t[0] + 1 / walk.rate_hz
    return walk.t[row] + rounds * duration, walk.accel[row], walk.gyro[row]


def _held() -> float:
    """Return the memory that the process holds now, bytes.

    The most that it ever held where that is not known.
    """
    status = Path("/proc/self/statm")
    if status.exists():
        return int(status.read_text().split()[1]) * resource.getpagesize()
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (
        1 if sys.platform == "darwin" else 1024
    )


def _compare(walk: Recording, samples: int) -> None:
    """Compare the last statistic with that of a detector that begins near the end."""
    end = Recording(*_rows(walk, np.arange(samples - LAST, samples)))
    whole = Recording(*_rows(walk, np.arange(samples)))
    for kind in ("shoe", "magnitude-variance"):
        streamed = footnav.detect(whole, kind).statistic[-LAST // 2 :]
        afresh = footnav.detect(end, kind).statistic[-LAST // 2 :]
        seen = np.isfinite(afresh)
        apart = np.abs(streamed[seen] / afresh[seen] - 1).max()
        print(
            f"{kind}: the last {seen.sum():,} statistics are apart by {apart:.1e} of their values at most"
        )


if __name__ == "__main__":
    main()
