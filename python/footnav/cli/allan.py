"""`footnav allan`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from footnav.allan import allan
from footnav.cli.console import print_table, reporting
from footnav.cli.reading import AS_FOUND, Reading, read_walks
from footnav.cli.report import noise_table
from footnav.errors import ConfigError
from footnav.files import replacing
from footnav.noise import INFLATION
from footnav.plot import check_picture, plot_allan, save_figure
from footnav.recording import Recording


def measure_noise(
    file: Path,
    /,
    *,
    plot: Path | None = None,
    out: Path | None = None,
    inflation: Annotated[tuple[float, float], Parameter(show_default=False)] = INFLATION,
    span: tuple[float, float] | None = None,
    reading: Reading = AS_FOUND,
) -> int:
    """Measure the noise of a sensor at rest, by its Allan deviation.

    Parameters
    ----------
    file : Path
        Recording of the sensor at rest: 100 s or more, better two hours.
    plot : Path, optional
        Picture of the Allan deviation: .png, .svg or .pdf.
    out : Path, optional
        What was seen as settings for footnav track --config, as TOML; all others keep their
        defaults.
    inflation : tuple of float
        Factors of the white noise and of the bias walk in these settings, since a worn sensor is
        noisier than one at rest; 2 3 unless given.
    span : tuple of float, optional
        First and last stamp of the rest in s; all of the recording unless given.
    reading : Reading
        How to read the recording.

    Returns
    -------
    int
        Exit status.
    """
    if plot is not None:
        check_picture(plot)
    with reporting(file.name) as progress:
        deviation = allan(_read_one(file, reading), span, progress=progress)
        figures = deviation.fit()
        settings = [
            "[sensor]",
            *(f"{key} = {value:.4g}" for key, value in figures.settings(inflation).items()),
        ]
        if plot is not None:
            save_figure(plot_allan(deviation, figures), plot)
        if out is not None:
            _write([f"# Allan deviation of {file.name}; {_inflated(inflation)}.", *settings], out)
    print(
        f"{file.name}: {deviation.duration:,.0f} s at rest, averaged over up to {deviation.taus[-1]:,.4g} s"
    )
    print_table(noise_table(figures))
    print(f"For the filter, {_inflated(inflation)}:", *settings, sep="\n")
    written = [str(path) for path in (plot, out) if path is not None]
    if written:
        print(f"Written: {', '.join(written)}")
    return 0


def _read_one(file: Path, reading: Reading) -> Recording:
    recordings = read_walks(file, reading)
    if len(recordings) > 1:
        raise ConfigError(
            f"{file} holds the sensors of both feet; choose one with --foot left or --foot right"
        )
    return next(iter(recordings.values()))


def _inflated(inflation: tuple[float, float]) -> str:
    return f"white noise times {inflation[0]:g} and bias walk times {inflation[1]:g}"


def _write(lines: list[str], path: Path) -> None:
    with replacing(path) as file:
        file.write("".join(f"{line}\n" for line in lines).encode())
