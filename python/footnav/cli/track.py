"""`footnav track`."""

import dataclasses
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from footnav.calibration import SensorCalibration, read_calibration
from footnav.cli.console import each_file, make_folder, print_table, print_warning, reporting
from footnav.cli.reading import AS_FOUND, Reading, read_walks
from footnav.cli.report import describe, summary_table
from footnav.config import Calibration, Config, load_config
from footnav.errors import ConfigError, nearest
from footnav.export.save import WRITERS
from footnav.plot import PICTURES, save_overview
from footnav.recording import Recording
from footnav.summary import Summary
from footnav.tracking import track
from footnav.trajectory import Trajectory

FORMATS = tuple(suffix.removeprefix(".") for suffix in (*WRITERS, *PICTURES))
_FORMATS_HELP = (
    f"Formats of the output, of {', '.join(FORMATS)}, separated by commas; csv,png unless given."
)


@dataclass(frozen=True, slots=True)
class Task:
    """Settings for every walk.

    Attributes
    ----------
    config : Config
        Settings.
    magnetic : bool
        Whether the heading comes from the magnetometer.
    formats : tuple of str
        Formats of the tracks.
    out : Path
        Folder of the tracks.
    """

    config: Config
    magnetic: bool
    formats: tuple[str, ...]
    out: Path


def track_files(
    files: list[Path],
    /,
    *,
    out: Path = Path(),
    formats: Annotated[str | None, Parameter(help=_FORMATS_HELP)] = None,
    name: str | None = None,
    config: Path | None = None,
    preset: str | None = None,
    calibration: Path | None = None,
    device: str | None = None,
    temperature_degc: float | None = None,
    origin: tuple[float, float, float] | None = None,
    heading_deg: float | None = None,
    heading_from_magnetometer: Annotated[bool, Parameter(show_default=False)] = False,
    reading: Reading = AS_FOUND,
) -> int:
    """Track recordings and print a summary of each.

    Parameters
    ----------
    files : list of Path
        Recordings.
    out : Path
        Folder for the tracks.
    formats : str, optional
        Formats of the output, separated by commas.
    name : str, optional
        Name of the track, for a single file; that of the file unless given.
    config : Path, optional
        Settings as a TOML file.
    preset : str, optional
        Settings for a known sensor: mpu6050, mti-g710, stim300, ngimu or vn100.
    calibration : Path, optional
        Calibration of the sensor, as `footnav calibrate` writes it.
    device : str, optional
        Name of the device; a calibration of another device is refused.
    temperature_degc : float, optional
        Temperature of the sensor, for a calibration over temperature and a recording without.
    origin : tuple of float, optional
        Start of the walk: latitude, longitude and height, in degrees and m (WGS-84).
    heading_deg : float, optional
        Heading of the sensor's x axis at the start, degrees clockwise from north.
    heading_from_magnetometer : bool
        Take the heading at the start from the magnetometer.
    reading : Reading
        How to read the recordings.

    Returns
    -------
    int
        Exit status.
    """
    _check_names(files, name)
    settings = _settings(config, preset, origin, heading_deg, heading_from_magnetometer)
    known = _calibration(calibration, settings)
    task = Task(settings, heading_from_magnetometer, _formats(formats), make_folder(out))
    summaries: list[Summary] = []

    def work(path: Path) -> None:
        with reporting(path.name):
            walks = read_walks(path, reading, name)
        for walk, recording in walks.items():
            if known is not None:
                recording = known.apply(recording, device=device, temperature=temperature_degc)
            summaries.append(_track(walk, recording, task))

    status = each_file(files, work)
    if len(summaries) > 1:
        print_table(summary_table(summaries))
    return status


def _track(name: str, recording: Recording, task: Task) -> Summary:
    """Track one walk, write it and print its summary."""
    with reporting(recording.name) as progress:
        config = task.config.with_heading_from(recording) if task.magnetic else task.config
        trajectory = dataclasses.replace(track(recording, config, progress=progress), name=name)
        written = [_write(trajectory, task.out / f"{name}.track.{form}") for form in task.formats]
    summary = trajectory.summary()
    print(describe(summary, written), end="\n\n")
    return summary


def _write(trajectory: Trajectory, path: Path) -> Path:
    write = save_overview if path.suffix in PICTURES else Trajectory.save
    write(trajectory, path)
    return path


def _settings(
    config: Path | None,
    preset: str | None,
    origin: tuple[float, float, float] | None,
    heading_deg: float | None,
    magnetic: bool,
) -> Config:
    """Combine the settings of a file or a preset with those of the command line."""
    if config is not None and preset is not None:
        raise ConfigError("--config and --preset both give all settings; leave one out")
    if magnetic and heading_deg is not None:
        raise ConfigError(
            "--heading-deg and --heading-from-magnetometer both give the heading; leave one out"
        )
    settings = Config()
    if config is not None:
        settings = load_config(config)
    if preset is not None:
        settings = Config.preset(preset)
    if heading_deg is not None:
        aligned = settings.alignment.replace(heading_deg=heading_deg, magnetic_field=None)
        settings = settings.replace(alignment=aligned)
    if origin is not None:
        settings = settings.replace(output=settings.output.replace(origin=origin))
    return settings


def _calibration(path: Path | None, settings: Config) -> SensorCalibration | None:
    """Read the calibration, unless the settings hold one already."""
    if path is None:
        return None
    if settings.calibration != Calibration():
        raise ConfigError(
            "--calibration and the [calibration] of --config both correct the readings; leave one "
            "out"
        )
    return read_calibration(path)


def _formats(given: str | None) -> tuple[str, ...]:
    if given is None:
        return _usual_formats()
    formats = tuple(form.strip().lower() for form in given.split(","))
    for form in formats:
        if form not in FORMATS:
            raise ConfigError(
                f"format {form!r} is unknown: expected some of "
                f"{', '.join(FORMATS)}{nearest(form, FORMATS)}"
            )
    return formats


def _usual_formats() -> tuple[str, ...]:
    if find_spec("matplotlib"):
        return "csv", "png"
    print_warning("footnav", "no pictures, since matplotlib is missing: pip install footnav[plot]")
    return ("csv",)


def _check_names(files: list[Path], name: str | None) -> None:
    """Reject names by which one track would overwrite another."""
    if name is not None and len(files) > 1:
        raise ConfigError(f"--name names one track, but there are {len(files)} files")
    first: dict[str, Path] = {}
    for path in files:
        other = first.setdefault(path.stem, path)
        if other is not path:
            raise ConfigError(
                f"the tracks of {other} and {path} would have one name; track them one by one, "
                "with --name"
            )
