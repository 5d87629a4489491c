"""P2: Wang, Liu, Sun, Cai, Cheng 2019, heading calibration, Electronics 8(12):1405."""

from footnav.config import Alignment, Config, Mechanization
from footnav.detectors import WindowedEnergies
from footnav.simulation import Route, SensorErrors
from papers.experiment import ZUPT_ALONE, Approach, Experiment, Simulated, gait_at, standing

RATE_HZ = 100.0
SENSOR = SensorErrors.preset("mti-g710")
REST = 10.0
"""Rest at the start, s."""
THRESHOLD = 0.004
"""T_md of the paper, m/s²."""

RECTANGLE = (300.0, 320.0, 8.0)
"""Length (m), duration (s) and error with IAA (m)."""

TRIALS = (
    (0.870, 90.0, 3.0, 15.0),
    (1.262, 68.0, 12.0, 14.5),
    (0.696, 230.0, 4.5, 7.0),
    (2.051, 80.0, 5.0, 10.0),
    (0.770, 475.0, 4.0, 48.0),
    (2.410, 160.0, 3.0, 50.0),
)
"""Table 3: speed (m/s), duration (s), error with IAA and without (m)."""

ZUPT = Config.preset("mti-g710").replace(
    # No rest is quiet enough, so the gyroscope's bias is not averaged at the start: the paper does
    # not mention it.
    alignment=Alignment(rest_gyro_std=1e-9),
    mechanization=Mechanization(kind="first-order"),
    detector=WindowedEnergies(),
    filter=ZUPT_ALONE,
)
ATTITUDE = ZUPT.filter.replace(attitude_threshold=THRESHOLD)
IAA = ZUPT.replace(filter=ATTITUDE.replace(attitude_update="iaa"))
GRAVITY = ZUPT.replace(filter=ATTITUDE.replace(attitude_update="gravity"))
AVERAGED = standing(REST)

NOTE = "route of the trials not stated: a rectangle twice as long as wide"


def _approaches(iaa: float, zupt: float | None) -> tuple[Approach, ...]:
    return (
        Approach("ZUPT", ZUPT, paper=zupt),
        Approach("ZUPT + gravity", GRAVITY, note="the roll and pitch part of IAA"),
        Approach("ZUPT + IAA", IAA, paper=iaa),
        Approach(
            "ZUPT, gyro averaged",
            ZUPT.replace(alignment=AVERAGED),
            note="over 10 s of rest at the start",
        ),
        Approach(
            "ZUPT + IAA, gyro averaged",
            IAA.replace(alignment=AVERAGED),
            note="over 10 s of rest at the start",
        ),
    )


def _experiment(
    title: str, speed: float, distance: float, approaches: tuple[Approach, ...]
) -> Experiment:
    walks = Simulated(
        Route.rectangle(distance / 3, distance / 6),
        gait_at(speed, rest_before=REST + 1.0),
        SENSOR,
        RATE_HZ,
    )
    return Experiment("P2", title, walks, approaches, distance=distance, note=NOTE)


def experiments() -> tuple[Experiment, ...]:
    """Return the rectangle and the six trials of table 3."""
    length, duration, error = RECTANGLE
    rectangle = _experiment(
        "300 m rectangle in 320 s", length / duration, length, _approaches(error, None)
    )
    trials = (
        _experiment(
            f"trial {number}: {speed:g} m/s, {duration:g} s",
            speed,
            speed * duration,
            _approaches(iaa, zupt),
        )
        for number, (speed, duration, iaa, zupt) in enumerate(TRIALS, start=1)
    )
    return (rectangle, *trials)
