"""P4: Wang Libing, Yang Songpu, Luo Wei, Pi Yanyan 2016, on MEMS pedestrian navigation."""

from footnav.config import Config
from footnav.detectors import ThreeCondition
from footnav.simulation import Gait, Route, SensorErrors
from papers.experiment import ZUPT_ALONE, Approach, Experiment, Simulated, standing

RATE_HZ = 200.0
LIMIT = 2.0
"""Every closed route of the paper ends within this percentage of its length."""

STIM300 = SensorErrors.preset("stim300")
UNCLIPPED = STIM300.replace(
    gyro=STIM300.gyro.replace(range=None), accel=STIM300.accel.replace(range=None)
)

REST = 10.0
"""Rest at the start, s; the paper does not give it."""
GAIT = Gait.preset("walk").replace(rest_before=REST + 1.0)

PUBLISHED = Config.preset("stim300").replace(
    alignment=standing(REST), detector=ThreeCondition(), filter=ZUPT_ALONE
)
APPROACHES = (Approach("ZUPT", PUBLISHED, paper=LIMIT, limit=LIMIT),)

ROUTES = (
    ("170 m out and back", Route.out_and_back(85.0), 170.0),
    ("448 m square", Route.square(112.0), 448.0),
    ("604 m figure of eight", Route.figure_of_eight(604.0), 604.0),
)
SENSORS = (
    ("", UNCLIPPED, "a STIM300 that holds the foot's motion"),
    (", clipped", STIM300, "the data sheet's 400 deg/s and 10 g"),
)


def experiments() -> tuple[Experiment, ...]:
    """Return the three routes, with a sensor of sufficient ranges and one that clips."""
    return tuple(
        Experiment(
            "P4",
            title + suffix,
            Simulated(route, GAIT, sensor, RATE_HZ),
            APPROACHES,
            distance=distance,
            unit="%",
            note=note,
        )
        for suffix, sensor, note in SENSORS
        for title, route, distance in ROUTES
    )
