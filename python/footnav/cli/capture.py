"""`footnav capture`: record from a live MPU6050, with or without the poses of a calibration."""

import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter

from footnav.capture.block import Block
from footnav.capture.guide import Guide, Plan, Stage
from footnav.capture.i2c_chip import ADDRESSES, check_address
from footnav.capture.i2c_source import I2cSource
from footnav.capture.recorder import Recorder
from footnav.capture.rest_detection import RestMonitor
from footnav.capture.serial_source import BAUD, SerialSource
from footnav.capture.source import Source, stream
from footnav.cli.console import print_error
from footnav.cli.live import StatusLine, status_line
from footnav.errors import ConfigError, DataError
from footnav.export.recording import check_suffix
from footnav.mpu6050 import Setup

_FAILED = 1
"""Exit status."""

_MIN_DURATION = 2.0
"""s; a capture that fails earlier leaves no file."""

_RATE_WINDOW = 2.0
"""s; interval of the rate in the status line."""

OnBlock = Callable[[Block], bool]
"""Called with every block; returns whether the capture is complete."""


@Parameter(name="*", group="Settings of the chip")
@dataclass(frozen=True, slots=True, kw_only=True)
class Chip:
    """Settings of an MPU6050 on an I2C bus.

    Attributes
    ----------
    rate_hz : float
        Samples per second: 1000 over a whole number.
    accel_range : int
        Full scale of the accelerometer in g: 2, 4, 8 or 16.
    gyro_range : int
        Full scale of the gyroscope in deg/s: 250, 500, 1000 or 2000.
    dlpf : int
        Low-pass filter, 0 (256 Hz) to 6 (5 Hz); 2 passes 94 Hz.
    address : int
        0x68, or 0x69 with the pin AD0 high.

    Raises
    ------
    ConfigError
        The chip does not have a value.
    """

    rate_hz: float = 200.0
    accel_range: int = 16
    gyro_range: int = 2000
    dlpf: int = 2
    address: Annotated[int, Parameter(show_default=hex)] = ADDRESSES[0]

    def __post_init__(self) -> None:
        """Validate the settings before any bus is opened."""
        check_address(self.address)
        self.setup()

    def setup(self) -> Setup:
        """Return the settings of the chip's registers."""
        return Setup.at_rate(
            self.rate_hz,
            accel_range_g=self.accel_range,
            gyro_range_deg_s=self.gyro_range,
            dlpf_cfg=self.dlpf,
        )


DEFAULT_CHIP = Chip()
"""Settings for a foot."""

PosePlan = Annotated[Plan, Parameter(name="*", group="Poses")]
ALL_POSES = Plan()
"""Default poses: enough for scale, misalignment and bias."""

app = App(name="capture", help="Record from a live MPU6050, at an Arduino or on an I2C bus.")
poses_app = App(
    name="poses", help="Record the poses of a calibration with instructions for each pose."
)
app.command(poses_app)


@app.command(name="serial", usage="Usage: footnav capture serial PORT [OPTIONS]")
def capture_serial(
    port: str, /, *, baud: int = BAUD, seconds: float | None = None, out: Path | None = None
) -> int:
    """Record from an Arduino with the sketch mpu6050_stream until Ctrl-C.

    Parameters
    ----------
    port : str
        Such as /dev/ttyUSB0, /dev/ttyACM0 or COM3.
    baud : int
        Bits per second, as in the sketch.
    seconds : float, optional
        Duration, s; until Ctrl-C unless given.
    out : Path, optional
        The recording, .csv or .npz, which must not exist; named after the time unless given.

    Returns
    -------
    int
        Exit status.
    """
    duration, target = check_duration(seconds), check_target(out, "capture")
    with SerialSource.open(port, baud) as source:
        return capture(source, target, duration)


@app.command(name="i2c", usage="Usage: footnav capture i2c BUS [OPTIONS]")
def capture_i2c(
    bus: int, /, *, seconds: float | None = None, out: Path | None = None, chip: Chip = DEFAULT_CHIP
) -> int:
    """Record from an MPU6050 on an I2C bus until Ctrl-C.

    Parameters
    ----------
    bus : int
        Number of the bus; 1 on a Raspberry Pi.
    seconds : float, optional
        Duration, s; until Ctrl-C unless given.
    out : Path, optional
        The recording, .csv or .npz, which must not exist; named after the time unless given.
    chip : Chip
        Settings of the chip.

    Returns
    -------
    int
        Exit status.
    """
    duration, target = check_duration(seconds), check_target(out, "capture")
    with I2cSource.open(bus, chip.setup(), chip.address) as source:
        return capture(source, target, duration)


@poses_app.command(name="serial", usage="Usage: footnav capture poses serial PORT [OPTIONS]")
def poses_serial(
    port: str, /, *, baud: int = BAUD, out: Path | None = None, plan: PosePlan = ALL_POSES
) -> int:
    """Record the poses of a calibration from an Arduino with the sketch mpu6050_stream.

    Parameters
    ----------
    port : str
        Such as /dev/ttyUSB0, /dev/ttyACM0 or COM3.
    baud : int
        Bits per second, as in the sketch.
    out : Path, optional
        The recording, .csv or .npz, which must not exist; named after the time unless given.
    plan : Plan
        Number and duration of the poses.

    Returns
    -------
    int
        Exit status.
    """
    target = check_target(out, "poses")
    with SerialSource.open(port, baud) as source:
        return capture_poses(source, target, plan)


@poses_app.command(name="i2c", usage="Usage: footnav capture poses i2c BUS [OPTIONS]")
def poses_i2c(
    bus: int, /, *, out: Path | None = None, plan: PosePlan = ALL_POSES, chip: Chip = DEFAULT_CHIP
) -> int:
    """Record the poses of a calibration from an MPU6050 on an I2C bus.

    Parameters
    ----------
    bus : int
        Number of the bus; 1 on a Raspberry Pi.
    out : Path, optional
        The recording, .csv or .npz, which must not exist; named after the time unless given.
    plan : Plan
        Number and duration of the poses.
    chip : Chip
        Settings of the chip.

    Returns
    -------
    int
        Exit status.
    """
    target = check_target(out, "poses")
    with I2cSource.open(bus, chip.setup(), chip.address) as source:
        return capture_poses(source, target, plan)


def capture(source: Source, target: Path, seconds: float = math.inf) -> int:
    """Record without poses.

    Parameters
    ----------
    source : Source
        The sensor.
    target : Path
        File of the recording.
    seconds : float
        How long.

    Returns
    -------
    int
        Exit status.

    Raises
    ------
    DataError
        The sensor gave too few samples to save.
    FootnavError
        The recording cannot be written.
    """
    with status_line() as shown:
        display = CaptureDisplay(source, shown, seconds)
        recorder, status = _record(source, display.process)
    _save(recorder, target, source)
    print(f"next: footnav track {_as_argument(target, recorder.setup)}")
    return status


def capture_poses(source: Source, target: Path, plan: Plan) -> int:
    """Guide through the poses of a calibration, and record all samples.

    Parameters
    ----------
    source : Source
        The sensor.
    target : Path
        File of the recording.
    plan : Plan
        Number and duration of the poses.

    Returns
    -------
    int
        Exit status: 1 if poses are missing; the recording is saved in any case.

    Raises
    ------
    DataError
        The sensor gave too few samples to save.
    FootnavError
        The recording cannot be written.
    """
    guide = Guide(plan)
    with status_line() as shown:
        recorder, status = _record(source, PoseDisplay(guide, shown).process)
    _save(recorder, target, source)
    if guide.stage is not Stage.DONE:
        missing = ", ".join(guide.missing_sides) or "no side"
        print_error(
            f"{target} is not complete: {missing} and {plan.tilts - guide.tilts} of {plan.tilts} "
            "tilts are missing"
        )
        return _FAILED
    print(f"next: footnav calibrate accel {_as_argument(target, recorder.setup)}")
    return status


class CaptureDisplay:
    """Shows the state of a capture: time, rate, losses, and whether the sensor moves.

    Parameters
    ----------
    source : Source
        The sensor.
    shown : StatusLine
        The status line.
    seconds : float
        Duration of the capture, s.
    """

    def __init__(self, source: Source, shown: StatusLine, seconds: float) -> None:
        self._source, self._shown, self._seconds = source, shown, seconds
        self._rest_monitor = RestMonitor()
        self._state = "..."
        self._start: float | None = None
        self._recent: deque[tuple[float, int]] = deque()

    def process(self, block: Block) -> bool:
        """Process a block; True once the capture is complete."""
        for window in self._rest_monitor.feed(block):
            self._state = "at rest" if window.at_rest else "moving"
        now = float(block.t[-1])
        self._start = float(block.t[0]) if self._start is None else self._start
        self._shown.update(
            f"{now - self._start:7.1f} s  {self._rate(now, len(block)):7.1f} Hz  "
            f"{self._state:8}{self._losses}"
        )
        return now - self._start >= self._seconds

    @property
    def _losses(self) -> str:
        return str(self._source.losses)

    def _rate(self, now: float, samples: int) -> float:
        """Return the rate over the last `_RATE_WINDOW`, Hz."""
        self._recent.append((now, samples))
        while len(self._recent) > 2 and now - self._recent[1][0] >= _RATE_WINDOW:
            self._recent.popleft()
        span = now - self._recent[0][0]
        return (
            (sum(count for _, count in self._recent) - self._recent[0][1]) / span if span else 0.0
        )


class PoseDisplay:
    """Prints the instructions and messages of the guide, each once.

    Parameters
    ----------
    guide : Guide
        The guide.
    shown : StatusLine
        The status line.
    """

    def __init__(self, guide: Guide, shown: StatusLine) -> None:
        self._guide, self._shown = guide, shown
        self._printed = ""
        self._print_instruction()

    def process(self, block: Block) -> bool:
        """Process a block; True once all poses are done."""
        for message in self._guide.feed(block):
            self._shown.message(f"  {message}")
        self._print_instruction()
        guide = self._guide
        held = f", held for {guide.held:.1f} of {guide.needed:g} s" if guide.held else ""
        self._shown.update(f"{guide.progress:4.0%}  {guide.up or '..'} up now{held}")
        return guide.stage is Stage.DONE

    def _print_instruction(self) -> None:
        if self._guide.instruction != self._printed:
            self._printed = self._guide.instruction
            self._shown.message(self._printed)


def check_target(out: Path | None, kind: str) -> Path:
    """Validate the file of a recording before the capture starts.

    Parameters
    ----------
    out : Path or None
        File of the command line.
    kind : str
        Start of the default name.

    Returns
    -------
    Path
        A file that does not exist, in a folder that does.

    Raises
    ------
    ConfigError
        The suffix is unknown, the file exists, or the folder does not.
    """
    target = out or Path(time.strftime(f"{kind}-%Y%m%d-%H%M%S.csv"))
    check_suffix(target)
    if target.exists():
        raise ConfigError(
            f"{target} exists; a capture does not replace a recording: give another --out"
        )
    if not target.absolute().parent.is_dir():
        raise ConfigError(f"{target}: there is no folder {target.parent}")
    return target


def check_duration(seconds: float | None) -> float:
    """Return the duration of a capture, s, or raise ConfigError."""
    if seconds is None:
        return math.inf
    if not 0 < seconds < math.inf:
        raise ConfigError(f"--seconds is {seconds:g}; expected a positive number")
    return seconds


def _record(source: Source, on_block: OnBlock) -> tuple[Recorder, int]:
    """Record until completion, Ctrl-C, or a failure after enough samples to save."""
    recorder = Recorder(source.name)
    status = 0
    try:
        for block in stream(source):
            recorder.add(block)
            if on_block(block):
                break
    except KeyboardInterrupt:
        pass
    except DataError as error:
        if recorder.duration < _MIN_DURATION:
            raise
        print_error(error)
        status = _FAILED
    return recorder, status


def _save(recorder: Recorder, target: Path, source: Source) -> None:
    recording = recorder.recording()
    recording.save(target)
    length = f"{len(recording):,} samples, {recording.duration:.2f} s at {recording.rate_hz:.5g} Hz"
    print(f"{target}: {length}, {source.losses}")


def _as_argument(target: Path, setup: Setup | None) -> str:
    """Return a recording as an argument of other commands.

    A table does not hold the full scales.
    """
    if setup is None or target.suffix.lower() != ".csv":
        return str(target)
    return f"{target} --accel-range {setup.accel_range_g} --gyro-range {setup.gyro_range_deg_s}"
