"""Instructions per sample, which noise cannot move: `python benches/instructions.py [--accept]`.

Valgrind counts what one simulated walk through `Batch` executes, with each kernel and two
detectors, and the counts are compared with those in instructions.toml: more by over the tolerance
is a failure, fewer is worth an `--accept`, which rewrites the file.  The counts belong to one
compiler; with another one they are shown, and nothing fails.  Valgrind knows AVX2 and FMA, but not
AVX-512.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import msgspec

ACCEPTED = Path(__file__).with_suffix(".toml")
ROOT = ACCEPTED.parent.parent
TOLERANCE = 0.03
DETECTORS = ("shoe", "default")
KERNELS = {"plain": "plain", "avx2": ""}
"""Value of FOOTNAV_KERNEL for each."""


def main() -> int:
    """Count and compare; return the exit status."""
    parser = argparse.ArgumentParser(description="Count the instructions of one fixed walk.")
    parser.add_argument(
        "--accept", action="store_true", help="make the counts of now those to compare with"
    )
    arguments = parser.parse_args()
    missing = _what_is_missing()
    if missing:
        print(f"instructions are not counted: {missing}")
        return 0
    counts = _count(_build())
    if arguments.accept:
        ACCEPTED.write_text(_toml(counts), encoding="utf-8")
    return _compare(counts, msgspec.toml.decode(ACCEPTED.read_bytes()))


def _what_is_missing() -> str:
    if platform.machine() not in ("x86_64", "AMD64"):
        return f"they are known for x86-64, and this is {platform.machine()}"
    return "" if shutil.which("valgrind") else "valgrind is missing (apt-get install valgrind)"


def _build() -> Path:
    """Build the walk with the settings of a release and return the program."""
    command = ["cargo", "bench", "--bench", "instructions", "--no-run", "--message-format=json"]
    built = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    messages = map(json.loads, built.stdout.splitlines())
    return next(Path(message["executable"]) for message in messages if message.get("executable"))


def _count(program: Path) -> dict[str, float]:
    kernels = {name: value for name, value in KERNELS.items() if name in ("plain", *_flags())}
    return {
        f"{detector}, {name}": _instructions_per_sample(program, detector, value)
        for detector in DETECTORS
        for name, value in kernels.items()
    }


def _flags() -> list[str]:
    """Return what the processor can do."""
    found = re.search(
        r"^flags\s*:(.*)$", Path("/proc/cpuinfo").read_text(encoding="utf-8"), re.MULTILINE
    )
    return found[1].split() if found else []


def _instructions_per_sample(program: Path, detector: str, kernel: str) -> float:
    with TemporaryDirectory() as folder:
        counts = Path(folder) / "counts"
        command = [
            "valgrind",
            "--tool=callgrind",
            f"--callgrind-out-file={counts}",
            "--toggle-collect=*follow*",
        ]
        environment = os.environ | {"FOOTNAV_KERNEL": kernel}
        run = subprocess.run(
            [*command, str(program), detector],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        if run.returncode != 0:
            raise SystemExit(f"{program} failed under valgrind:\n{run.stderr}")
        total = re.search(
            r"^(?:summary|totals): (\d+)", counts.read_text(encoding="utf-8"), re.MULTILINE
        )
    assert total is not None, "callgrind writes a summary"
    return int(total[1]) / int(run.stdout)


def _compare(counts: dict[str, float], accepted: dict[str, object]) -> int:
    before, compiler = accepted["instructions_per_sample"], accepted["compiler"]
    assert isinstance(before, dict)
    comparable = compiler == _compiler()
    if not comparable:
        print(
            f"the accepted counts belong to {compiler}; this is {_compiler()}, so nothing can fail"
        )
    worse = False
    for name, count in counts.items():
        change = count / before[name] - 1
        worse |= change > TOLERANCE
        remark = "too many" if change > TOLERANCE else "accept these" if change < -TOLERANCE else ""
        print(
            f"{name:16} {count:8.0f} {before[name]:8.0f} {100 * change:+6.1f} % {remark}".rstrip()
        )
    return int(worse and comparable)


def _compiler() -> str:
    return subprocess.run(
        ["rustc", "--version"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.strip()


def _toml(counts: dict[str, float]) -> str:
    lines = [f'"{name}" = {count:.0f}' for name, count in counts.items()]
    return "\n".join(
        [
            "# Written by: python benches/instructions.py --accept",
            f'compiler = "{_compiler()}"',
            "",
            "[instructions_per_sample]",
            *lines,
            "",
        ]
    )


if __name__ == "__main__":
    sys.exit(main())
