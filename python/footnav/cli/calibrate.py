"""`footnav calibrate`."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import App, Parameter
from rich import box
from rich.table import Table

from footnav.calibration import (
    SensorCalibration,
    Triad,
    calibrate_accel,
    calibrate_gyro,
    calibrate_mag,
    calibrate_six_position,
    calibrate_temperature,
    load_calibration,
)
from footnav.calibration.model import SENSORS
from footnav.cli.console import print_table, print_warning, reporting
from footnav.cli.reading import AS_FOUND, Reading, read_walks
from footnav.config import Vector
from footnav.errors import ConfigError
from footnav.mpu6050 import Setup
from footnav.recording import Recording

app = App(
    name="calibrate",
    help="Calibrate the sensors from recordings on a table.",
    default_parameter=Parameter(negative=""),
)


@Parameter(name="*")
@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """Output of a calibration, and the device.

    Attributes
    ----------
    out : Path
        File to write.
    update : Path, optional
        Calibration to update; its other sensors are kept.
    device : str
        Name of the device.
    dlpf_cfg : int, optional
        DLPF_CFG of an MPU6050, to be stored with the calibration; needs both ranges.
    smplrt_div : int, optional
        SMPLRT_DIV of an MPU6050.
    """

    out: Path = Path("calibration.toml")
    update: Path | None = None
    device: str = ""
    dlpf_cfg: int | None = None
    smplrt_div: int | None = None

    def setup(self, reading: Reading) -> Setup | None:
        """Return the registers of the MPU6050, if they were given.

        Raises
        ------
        ConfigError
            Only some of them were given, or the chip has no such value.
        """
        if self.dlpf_cfg is None and self.smplrt_div is None:
            return None
        if (
            self.dlpf_cfg is None
            or self.smplrt_div is None
            or not (reading.accel_range and reading.gyro_range)
        ):
            raise ConfigError(
                "--dlpf-cfg and --smplrt-div need each other, and --accel-range and --gyro-range"
            )
        return Setup(
            accel_range_g=_whole("accel_range", reading.accel_range),
            gyro_range_deg_s=_whole("gyro_range", reading.gyro_range),
            dlpf_cfg=self.dlpf_cfg,
            smplrt_div=self.smplrt_div,
        )


HERE = Target()
"""calibration.toml in this folder."""


@app.command(name="accel", usage="Usage: footnav calibrate accel FILE... [OPTIONS]")
def accel(
    files: list[Path],
    /,
    *,
    six_position: Annotated[bool, Parameter(show_default=False)] = False,
    turn_deg: float = 360.0,
    gravity: float | None = None,
    latitude_deg: float | None = None,
    initial: float = 2.0,
    target: Target = HERE,
    reading: Reading = AS_FOUND,
) -> int:
    """Calibrate accelerometer and gyroscope from rests in nine or more poses and turns between.

    Parameters
    ----------
    files : list of Path
        Recordings that start at rest and rest in pose after pose.
    six_position : bool
        The sensor is in a box that rests on each of its six sides; turns about its edges are of
        --turn-deg.
    turn_deg : float
        Angle of the known turns, degrees.
    gravity : float, optional
        Gravity, m/s^2.
    latitude_deg : float, optional
        Latitude to take gravity from, degrees; 45 unless it or --gravity is given.
    initial : float
        Length of the rest at the start, s.
    target : Target
        Output of the calibration.
    reading : Reading
        How to read the recordings.

    Returns
    -------
    int
        Exit status.
    """
    setup = target.setup(reading)

    def work(recordings: list[Recording]) -> SensorCalibration:
        known = {"gravity": gravity, "latitude_deg": latitude_deg}
        if six_position:
            return calibrate_six_position(
                recordings,
                turn=math.radians(turn_deg),
                initial=initial,
                device=target.device,
                setup=setup,
                **known,
            )
        return calibrate_accel(
            recordings, initial=initial, device=target.device, setup=setup, **known
        )

    return _calibrate(files, target, reading, work)


@app.command(name="gyro", usage="Usage: footnav calibrate gyro FILE... [OPTIONS]")
def gyro(files: list[Path], /, *, target: Target = HERE, reading: Reading = AS_FOUND) -> int:
    """Measure the gyroscope's bias at rest.

    Parameters
    ----------
    files : list of Path
        Recordings that rest from the first sample to the last.
    target : Target
        Output of the calibration.
    reading : Reading
        How to read the recordings.

    Returns
    -------
    int
        Exit status.
    """
    setup = target.setup(reading)
    return _calibrate(
        files, target, reading, lambda each: calibrate_gyro(each, device=target.device, setup=setup)
    )


@app.command(name="mag", usage="Usage: footnav calibrate mag FILE... [OPTIONS]")
def mag(files: list[Path], /, *, target: Target = HERE, reading: Reading = AS_FOUND) -> int:
    """Find hard and soft iron from recordings with rotations about all axes.

    Parameters
    ----------
    files : list of Path
        Recordings with a magnetometer, far from iron.
    target : Target
        Output of the calibration.
    reading : Reading
        How to read the recordings.

    Returns
    -------
    int
        Exit status.
    """
    return _calibrate(
        files, target, reading, lambda each: calibrate_mag(each, device=target.device)
    )


@app.command(name="temperature", usage="Usage: footnav calibrate temperature FILE... [OPTIONS]")
def temperature(
    files: list[Path], /, *, order: int = 2, target: Target = HERE, reading: Reading = AS_FOUND
) -> int:
    """Measure bias and scale over temperature, from recordings at rest that warm up or cool down.

    Parameters
    ----------
    files : list of Path
        Recordings with temperature.
    order : int
        Order of the polynomials, 1 to 3.
    target : Target
        Output of the calibration.
    reading : Reading
        How to read the recordings.

    Returns
    -------
    int
        Exit status.
    """
    base = None if target.update is None else load_calibration(target.update)

    def work(recordings: list[Recording]) -> SensorCalibration:
        return calibrate_temperature(recordings, base, order=order, device=target.device)

    return _calibrate(files, target, reading, work)


def tabulate(calibration: SensorCalibration) -> Table:
    """Tabulate a calibration.

    Parameters
    ----------
    calibration : SensorCalibration
        The calibration.

    Returns
    -------
    Table
        A row for each sensor's axis, with standard deviations.
    """
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("axis")
    for title in ("bias", "scale", "misalignment"):
        table.add_column(title, justify="right", no_wrap=True)
    for label, triad in calibration.triads().items():
        for axis in range(3):
            table.add_row(f"{label}_{'xyz'[axis]}", *_row(label, triad, axis))
    return table


def tabulate_temperature(calibration: SensorCalibration) -> Table | None:
    """Tabulate the dependence on temperature, or return None where there is none.

    Parameters
    ----------
    calibration : SensorCalibration
        The calibration.

    Returns
    -------
    Table or None
        A row for each axis and polynomial, with standard deviations.
    """
    models = {
        label: triad.thermal
        for label, triad in calibration.triads().items()
        if triad.thermal is not None
    }
    if not models:
        return None
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("over temperature")
    for order in range(1, 1 + max(len(model.bias) for model in models.values())):
        table.add_column(f"(T - T0)^{order}", justify="right", no_wrap=True)
    for label, model in models.items():
        factor, unit = _UNITS[label]
        for axis in range(3):
            name = f"{label}_{'xyz'[axis]}"
            table.add_row(
                f"{name} bias, {unit}", *_coefficients(model.bias, model.bias_std, axis, factor)
            )
            if model.scale:
                table.add_row(
                    f"{name} scale", *_coefficients(model.scale, model.scale_std, axis, 1.0)
                )
    return table


def _coefficients(
    values: Sequence[Vector], stds: Sequence[Vector], axis: int, factor: float
) -> list[str]:
    return [
        f"{factor * value[axis]:+.2e} +- {factor * std[axis]:.1e}"
        for value, std in zip(values, stds, strict=True)
    ]


_UNITS = {"accel": (1.0, "m/s^2"), "gyro": (180 / math.pi, "deg/s"), "mag": (1e6, "uT")}
"""Factor and unit of the bias of each sensor in tables."""


def _row(label: str, triad: Triad, axis: int) -> tuple[str, str, str]:
    factor, unit = _UNITS[label]
    bias = f"{factor * triad.bias[axis]:+.4f}"
    if triad.bias_std is not None:
        bias += f" +- {factor * triad.bias_std[axis]:.4f}"
    if triad.matrix_std is None:
        return f"{bias} {unit}", "not measured", "not measured"
    row, std = triad.matrix[axis], triad.matrix_std[axis]
    # An element without uncertainty is zero because it defines the frame.
    degrees = ", ".join(
        f"{math.degrees(row[k]):+.3f} +- {math.degrees(std[k]):.3f}" if std[k] else "0"
        for k in range(3)
        if k != axis
    )
    return f"{bias} {unit}", f"{row[axis]:.5f} +- {std[axis]:.5f}", f"{degrees} deg"


def _calibrate(
    files: list[Path],
    target: Target,
    reading: Reading,
    work: Callable[[list[Recording]], SensorCalibration],
) -> int:
    """Read the files, calibrate, write the calibration and print it."""
    existing = None if target.update is None else load_calibration(target.update)
    with reporting(", ".join(path.name for path in files)):
        recordings = [recording for path in files for recording in _read(path, reading)]
        found = work(recordings)
    calibration = found if existing is None else existing.update(found)
    calibration.save(target.out)
    print_table(tabulate(found))
    over_temperature = tabulate_temperature(found)
    if over_temperature is not None:
        print_table(over_temperature)
    for line in _remarks(found):
        print(line)
    if existing is not None:
        _warn_of_loss(existing, calibration, target.out)
    print(f"{target.out}: {', '.join(SENSORS[label] for label in calibration.triads())}")
    return 0


def _read(path: Path, reading: Reading) -> list[Recording]:
    walks = list(read_walks(path, reading).values())
    if len(walks) > 1:
        raise ConfigError(
            f"{path} holds the sensors of both feet; calibrate one at a time, with --foot left or "
            "right"
        )
    return walks


def _remarks(calibration: SensorCalibration) -> list[str]:
    """Describe quality and limits of each sensor's estimate."""
    lines = []
    for label, triad in calibration.triads().items():
        parts = [f"{triad.observations} observations"] if triad.observations else []
        if triad.residual is not None:
            parts.append(f"residual {_residual(label, triad)}")
        if triad.condition is not None:
            parts.append(f"condition {triad.condition:.1f}")
        if triad.thermal is not None:
            span = f"from {triad.thermal.lowest:.1f} to {triad.thermal.highest:.1f} degC"
            factor, unit = _UNITS[label]
            parts.append(
                f"{span}, T0 {triad.thermal.reference:.1f}, residual "
                f"{factor * triad.thermal.residual:.4f} {unit}"
            )
        if triad.note:
            parts.append(triad.note)
        lines.append(f"{SENSORS[label]}: {', '.join(parts)}")
    return lines


def _residual(label: str, triad: Triad) -> str:
    residual = triad.residual or 0.0
    if label == "gyro":
        return f"{math.degrees(residual):.3f} deg"
    factor, unit = _UNITS[label]
    return f"{factor * residual:.4f} {unit}"


def _warn_of_loss(existing: SensorCalibration, calibration: SensorCalibration, out: Path) -> None:
    for label, triad in existing.triads().items():
        if triad.thermal is not None and getattr(calibration, label).thermal is None:
            print_warning(
                str(out),
                f"the {SENSORS[label]} has no temperature model any more: calibrate temperature "
                "again",
            )


def _whole(label: str, value: float) -> int:
    if value != round(value):
        raise ConfigError(f"{label} is {value:g}; an MPU6050 has whole ones")
    return round(value)
