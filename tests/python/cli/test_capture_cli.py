"""`footnav capture`: on a pseudo-terminal, and with sources that are given."""

import contextlib
import os
import re
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
import serial

import footnav
from footnav.capture import Block, Guide, LossCounters, Plan
from footnav.cli import main
from footnav.cli.capture import (
    CaptureDisplay,
    PoseDisplay,
    capture,
    capture_poses,
    check_duration,
    check_target,
)
from footnav.errors import ConfigError, DataError
from poses import blocks, counts, tilts
from stream_lines import AT_REST, Counts, stream

QUICK = Plan(settle=2, hold=1, tilts=1)
COMPLETE = [
    ("+z", 3.0),
    *[(side, 2.0) for side in ("-z", "+x", "-x", "+y", "-y")],
    (tilts(1)[0], 2.0),
]


@dataclass
class ScriptedSource:
    """A source that gives blocks, and then raises."""

    blocks: Iterator[Block]
    end: BaseException
    name: str = "scripted"
    losses: LossCounters = field(default_factory=LossCounters)

    def read(self) -> list[Block]:
        block = next(self.blocks, None)
        if block is None:
            raise self.end
        return [block]


def scripted(
    poses, end: BaseException | None = None, losses: LossCounters | None = None
) -> ScriptedSource:
    return ScriptedSource(
        blocks(counts(poses)),
        end or AssertionError("the capture did not end"),
        losses=losses or LossCounters(),
    )


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def board(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[[list[Counts]], str]]:
    """Connect a board that starts as its port is opened and sends as fast as it is read.

    The port is returned.
    """
    master, slave = os.openpty()
    opened = threading.Event()
    drop_old_bytes = serial.Serial.reset_input_buffer

    def reset(port: serial.Serial) -> None:
        drop_old_bytes(port)
        opened.set()

    monkeypatch.setattr(serial.Serial, "reset_input_buffer", reset)

    def connect(samples: list[Counts]) -> str:
        def send() -> None:
            opened.wait()
            # What is not read when the port is closed has nowhere to go.
            with contextlib.suppress(OSError):
                for line in stream(samples):
                    os.write(master, line)

        threading.Thread(target=send, daemon=True).start()
        return os.ttyname(slave)

    yield connect
    os.close(slave)
    os.close(master)


def test_a_capture_from_a_port_reads_back(board, capsys):
    port = board([AT_REST] * 800)
    assert main(["capture", "serial", port, "--seconds", "3", "--out", "walk.csv"]) == 0
    streams = capsys.readouterr()
    assert re.fullmatch(
        r"walk\.csv: 6\d\d samples, 3\.\d\d s at [\d.]+ Hz, nothing lost\n"
        r"next: footnav track walk\.csv --accel-range 16 --gyro-range 2000\n",
        streams.out,
    )
    assert streams.err == ""
    back = footnav.read("walk.csv")
    assert back.accel[0] == pytest.approx([0, 0, 9.80665])
    assert back.temperature is not None
    assert (
        main(
            ["track", "walk.csv", "--accel-range", "16", "--gyro-range", "2000", "--formats", "csv"]
        )
        == 0
    )


def test_poses_are_recorded_at_a_port(board, capsys):
    port = board(counts(COMPLETE).tolist())
    quick = ("--settle", "2", "--hold", "1", "--tilts", "1")
    assert main(["capture", "poses", "serial", port, *quick, "--out", "poses.csv"]) == 0
    streams = capsys.readouterr()
    assert streams.out.endswith(
        "next: footnav calibrate accel poses.csv --accel-range 16 --gyro-range 2000\n"
    )
    assert streams.err.endswith("  Done: tilt 1.\nAll poses are done.\n")


def test_ctrl_c_ends_a_capture_and_the_samples_are_saved(capsys):
    source = scripted([("+z", 1.5)], KeyboardInterrupt(), LossCounters(missing=7, broken=2))
    assert capture(source, Path("walk.npz")) == 0
    assert capsys.readouterr().out.startswith(
        "walk.npz: 300 samples, 1.50 s at 200 Hz, 7 missing, 2 broken\n"
    )
    assert footnav.read("walk.npz").accel_range == pytest.approx(16 * 9.80665)


def test_an_unplugged_device_ends_a_capture_and_the_samples_are_saved(capsys):
    assert (
        capture(scripted([("+z", 3.0)], DataError("scripted disappeared")), Path("walk.csv")) == 1
    )
    streams = capsys.readouterr()
    assert streams.err == "footnav: scripted disappeared\n"
    assert len(footnav.read("walk.csv")) == 600


def test_a_capture_that_fails_at_once_leaves_nothing(folder):
    with pytest.raises(DataError, match="scripted disappeared"):
        capture(scripted([("+z", 1.0)], DataError("scripted disappeared")), Path("walk.csv"))
    with pytest.raises(DataError, match="scripted: 0 samples arrived"):
        capture(scripted([("+z", 0.0)], KeyboardInterrupt()), Path("walk.csv"))
    assert list(folder.iterdir()) == []


def test_all_poses_are_recorded_and_the_next_step_named(capsys):
    raw = counts(COMPLETE)
    assert capture_poses(scripted(COMPLETE), Path("poses.npz"), QUICK) == 0
    streams = capsys.readouterr()
    assert streams.out.endswith("next: footnav calibrate accel poses.npz\n")
    assert streams.err.startswith("Place the sensor on a firm table")
    assert streams.err.count("  Done: ") == 7
    assert streams.err.endswith("  Done: tilt 1.\nAll poses are done.\n")
    back = footnav.read("poses.npz")
    assert len(raw) - len(back) < 250
    np.testing.assert_allclose(back.accel, raw[: len(back), :3] * 16 * 9.80665 / 32768)


def test_poses_that_are_missing_are_named_and_the_recording_kept(capsys):
    assert capture_poses(scripted(COMPLETE[:4], KeyboardInterrupt()), Path("poses.csv"), QUICK) == 1
    error = capsys.readouterr().err.splitlines()[-1]
    assert error == "footnav: poses.csv is not complete: +y, -y and 1 of 1 tilts are missing"
    assert len(footnav.read("poses.csv")) > 1000
    assert capture_poses(scripted(COMPLETE[:6], KeyboardInterrupt()), Path("tilt.csv"), QUICK) == 1
    assert "no side and 1 of 1 tilts" in capsys.readouterr().err


def test_the_status_line_shows_rate_losses_and_rest():
    shown: list[str] = []

    class StatusLine:
        update = staticmethod(shown.append)

    display = CaptureDisplay(
        scripted([("+z", 0.0)], losses=LossCounters(missing=3)), StatusLine(), 100
    )
    for block in blocks(counts([("+z", 3.0), ("+x", 0.4)])):
        display.process(block)
    assert any(re.fullmatch(r"    3\.0 s    200\.0 Hz  at rest 3 missing", line) for line in shown)
    assert any("moving" in line for line in shown)


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["serial", "/dev/absent"], 1, "/dev/absent cannot be opened: No such file or directory"),
        (["i2c", "99"], 1, "/dev/i2c-99 cannot be opened"),
        (["poses", "serial", "/dev/absent"], 1, "/dev/absent cannot be opened"),
        (["poses", "i2c", "99", "--tilts", "3"], 1, "/dev/i2c-99 cannot be opened"),
        (
            ["serial", "/dev/absent", "--seconds", "0"],
            2,
            "--seconds is 0; expected a positive number",
        ),
        (["serial", "/dev/absent", "--out", "walk.mat"], 2, "walk.mat: unknown suffix"),
        (
            ["serial", "/dev/absent", "--out", "there.csv"],
            2,
            "there.csv exists; a capture does not replace",
        ),
        (
            ["serial", "/dev/absent", "--out", "no/walk.csv"],
            2,
            "no/walk.csv: there is no folder no",
        ),
        (["i2c", "1", "--rate-hz", "300"], 2, "--rate-hz is 300; an MPU6050 divides 1000 Hz"),
        (["i2c", "1", "--accel-range", "3"], 2, "accel_range_g is 3; an MPU6050 has 2, 4, 8, 16"),
        (["i2c", "1", "--address", "0x70"], 2, "address is 0x70; an MPU6050 has 0x68"),
        (["poses", "i2c", "1", "--hold", "0"], 2, "hold is 0 s; expected 1 to 600"),
        (["spi"], 2, '"spi"'),
    ],
)
def test_misuse_is_one_line(folder, capsys, arguments, status, message):
    (folder / "there.csv").touch()
    assert main(["capture", *arguments]) == status
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_the_default_name_of_a_recording_has_the_time():
    assert re.fullmatch(r"poses-\d{8}-\d{6}\.csv", str(check_target(None, "poses")))
    assert check_duration(None) == float("inf")
    with pytest.raises(ConfigError, match="--seconds is nan"):
        check_duration(float("nan"))


def test_the_status_line_shows_the_side_and_the_time():
    shown: list[str] = []

    class StatusLine:
        update = staticmethod(shown.append)
        message = staticmethod(shown.append)

    display = PoseDisplay(Guide(QUICK), StatusLine())
    for block in blocks(counts([("+z", 1.5)])):
        display.process(block)
    assert shown[0].startswith("Place the sensor on a firm table")
    assert shown[-1].startswith(" 10%  +z up now, held for 1.4 of 2 s")


def test_help_names_the_commands(capsys):
    assert main(["capture", "--help"]) == 0
    page = capsys.readouterr().out
    assert all(f" {command} " in page for command in ("serial", "i2c", "poses"))
