"""`footnav simulate`."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

from footnav.errors import ConfigError
from footnav.export.recording import check_suffix
from footnav.simulation import Route, simulate

Shape = Literal["square", "straight", "rectangle", "figure-of-eight", "out-and-back", "stairs"]

_ROUTES: dict[Shape, tuple[Callable[..., Route], tuple[float, ...]]] = {
    "square": (Route.square, (10.0,)),
    "straight": (Route.straight, (20.0,)),
    "rectangle": (Route.rectangle, (20.0, 10.0)),
    "figure-of-eight": (Route.figure_of_eight, (40.0,)),
    "out-and-back": (Route.out_and_back, (20.0,)),
    "stairs": (Route.stairs, (2,)),
}
"""Constructor and default sizes of each shape."""


def simulate_walk(
    route: Shape,
    sizes: Annotated[tuple[float, ...], Parameter(show_default=False)] = (),
    /,
    *,
    gait: str = "walk",
    sensor: str = "mpu6050",
    seed: int = 0,
    rate_hz: float = 200.0,
    out: Path | None = None,
    truth: Path | None = None,
) -> int:
    """Simulate a walk and write the samples of the sensor on the shoe.

    Parameters
    ----------
    route : str
        The route.
    sizes : tuple of float
        Sizes of the route in m; of stairs the number of floors.  Default: square 10, straight 20,
        rectangle 20 10, figure-of-eight 40, out-and-back 20, stairs 2.
    gait : str
        walk, slow or run.
    sensor : str
        ideal, mpu6050, mti-g710 or stim300.
    seed : int
        The same seed gives the same walk.
    rate_hz : float
        Samples per second.
    out : Path, optional
        The recording, .csv or .npz; ROUTE.csv unless given.
    truth : Path, optional
        The true track, in any format of a track.

    Returns
    -------
    int
        Exit status.
    """
    out = out or Path(f"{route}.csv")
    check_suffix(out)
    if truth == out:
        raise ConfigError(f"--out and --truth are both {out}: two files are needed")
    recording, true_track = simulate(make_route(route, sizes), gait, sensor, seed, rate_hz=rate_hz)
    if truth is not None:
        true_track.save(truth)
        print(f"{truth}: the truth, {true_track.distance:.2f} m")
    recording.save(out)
    print(
        f"{out}: {len(recording):,} samples, {recording.duration:.2f} s at "
        f"{recording.rate_hz:.5g} Hz"
    )
    return 0


def make_route(shape: Shape, sizes: tuple[float, ...] = ()) -> Route:
    """Make a route.

    Parameters
    ----------
    shape : str
        Its shape.
    sizes : tuple of float
        All of its sizes, m or a number of floors, or none of them.

    Returns
    -------
    Route
        The route.

    Raises
    ------
    ConfigError
        For too few or too many sizes, or an impossible one.
    """
    make, usual = _ROUTES[shape]
    for size in sizes:
        if not 0 < size < math.inf:
            raise ConfigError(f"{shape} with size {size:g}: expected a positive number")
    if sizes and len(sizes) != len(usual):
        expected = "1 size" if len(usual) == 1 else f"{len(usual)} sizes"
        raise ConfigError(f"{shape} takes {expected}, not {len(sizes)}")
    return make(*(sizes or usual))
