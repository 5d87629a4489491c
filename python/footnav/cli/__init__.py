"""The command line: one module a command.

Exit status: 0 done, 1 the data or the run failed, 2 the command or the settings that it names are
wrong.
"""

import sys
from collections.abc import Sequence

from cyclopts import App, Parameter

from footnav._core import __version__
from footnav.cli import calibrate
from footnav.cli.allan import measure_noise
from footnav.cli.capture import app as capture_app
from footnav.cli.demo import run_demo
from footnav.cli.info import examine_files
from footnav.cli.run import run_app
from footnav.cli.simulate import simulate_walk
from footnav.cli.track import track_files

app = App(
    name="footnav",
    help="Foot-mounted inertial navigation: from the IMU on a shoe to the wearer's track.",
    version=f"footnav {__version__}",
    help_format="markdown",
    default_parameter=Parameter(negative=""),
)
app.command(run_demo, name="demo", usage="Usage: footnav demo [OPTIONS]")
app.command(track_files, name="track", usage="Usage: footnav track FILE... [OPTIONS]")
app.command(
    simulate_walk, name="simulate", usage="Usage: footnav simulate ROUTE [SIZE...] [OPTIONS]"
)
app.command(measure_noise, name="allan", usage="Usage: footnav allan FILE [OPTIONS]")
app.command(capture_app)
app.command(calibrate.app)
app.command(examine_files, name="info", usage="Usage: footnav info FILE... [OPTIONS]")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    arguments : sequence of str, optional
        Arguments after the program's name; those of the process unless given.

    Returns
    -------
    int
        Exit status.
    """
    return run_app(app, sys.argv[1:] if arguments is None else arguments)
