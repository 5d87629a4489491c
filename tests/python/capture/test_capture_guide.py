"""The guide through the poses of a calibration."""

import numpy as np
import pytest

from footnav.capture import Block, Guide, Plan, Setup, Stage
from footnav.capture.rest_detection import RestMonitor
from footnav.errors import ConfigError
from poses import RATE, blocks, counts, tilts

SIX = ("+z", "-z", "+x", "-x", "+y", "-y")
QUICK = Plan(settle=5, hold=2, tilts=3)


def guide_through(poses, plan: Plan = QUICK, size: int = 7, **motion) -> tuple[Guide, list[str]]:
    """Go through poses; return the guide and its messages."""
    guide = Guide(plan)
    return guide, [
        message for block in blocks(counts(poses, **motion), size) for message in guide.feed(block)
    ]


def test_all_poses_complete_the_guide():
    poses = [("+z", 6.0), *[(side, 3.0) for side in SIX[1:]], *[(tilt, 3.0) for tilt in tilts(3)]]
    guide, messages = guide_through(poses)
    assert messages == [f"Done: {side} up." for side in SIX] + [
        f"Done: tilt {k}." for k in (1, 2, 3)
    ]
    assert (guide.stage, guide.progress, guide.sides, guide.tilts) == (Stage.DONE, 1.0, SIX, 3)
    assert guide.instruction == "All poses are done."


def test_the_usual_plan_can_be_followed():
    poses = [
        ("-y", 21.0),
        *[(side, 4.0) for side in SIX if side != "-y"],
        *[(tilt, 4.0) for tilt in tilts(12)],
    ]
    guide, messages = guide_through(poses, Plan())
    assert guide.stage is Stage.DONE
    assert len(messages) == 18


@pytest.mark.parametrize("size", [1, 3, 40, 5000])
def test_blocks_of_any_size_give_the_same(size):
    poses = [("+z", 6.0), ("+x", 1.0), ("+y", 3.0), ("+z", 3.0), ("-x", 3.0)]
    guide, messages = guide_through(poses, size=size)
    reference, expected = guide_through(poses)
    assert messages == expected
    assert (guide.stage, guide.sides, guide.held) == (
        reference.stage,
        reference.sides,
        reference.held,
    )


def test_every_stage_has_an_instruction():
    guide, _ = guide_through([("+z", 2.0)])
    assert guide.stage is Stage.SETTLE
    assert guide.instruction.startswith(
        "Place the sensor on a firm table, one side flat, and do not touch it for 5 s"
    )
    guide, _ = guide_through([("+z", 6.0)])
    assert guide.stage is Stage.PLACE
    assert guide.instruction == "Turn it until +x points up (remaining: +x, -x, +y, -y, -z)."
    guide, _ = guide_through([("+z", 6.0), ("-y", 1.5)])
    assert guide.stage is Stage.HOLD
    assert guide.up == "-y"
    assert guide.instruction == "Do not touch it: -y up."
    guide, _ = guide_through([("+z", 6.0), *[(side, 3.0) for side in SIX[1:]]])
    assert guide.instruction == "Tilt it to a new angle: tilt 1 of 3."


def test_progress_falls_only_when_a_pose_is_interrupted():
    guide = Guide(QUICK)
    poses = [("+z", 6.0), *[(side, 3.0) for side in SIX[1:]], *[(tilt, 3.0) for tilt in tilts(3)]]
    shares = [guide.progress for block in blocks(counts(poses)) if guide.feed(block) is not None]
    assert np.diff(shares).min() >= -0.01 / 9
    assert (shares[0], shares[-1]) == (0.0, 1.0)


def test_moved_too_early():
    guide, messages = guide_through([("+z", 6.0), ("+x", 1.3), ("-x", 3.0)])
    assert messages[0] == "Done: +z up."
    assert messages[1].startswith("Moved too early: 1.")
    assert messages[1].endswith(" s of 2 s.  Repeat the pose.")
    assert messages[2:] == ["Done: -x up."]
    assert guide.missing_sides == ("+x", "+y", "-y", "-z")


def test_the_initial_rest_restarts_when_it_is_disturbed():
    guide, messages = guide_through([("+z", 3.0), ("+z", 3.0)])
    assert messages[0].startswith("Moved too early: ")
    assert messages[0].endswith("of 5 s.  Repeat the pose.")
    assert guide.stage is Stage.SETTLE
    assert guide.held < 4


def test_an_impact_as_it_is_placed_gives_no_message():
    _, messages = guide_through([("+z", 6.0), ("+x", 0.4), ("+x", 3.0)])
    assert messages == ["Done: +z up.", "Done: +x up."]


def test_a_side_that_is_repeated_is_named_once():
    guide, messages = guide_through([("+z", 6.0), ("+x", 3.0), ("+x", 4.0)])
    assert messages[:2] == ["Done: +z up.", "Done: +x up."]
    assert [
        message for message in messages[2:] if message.startswith("Repeated: this is +x")
    ] == messages[2:]
    assert len(messages) == 3
    assert guide.sides == ("+z", "+x")


def test_a_tilt_that_is_repeated_is_named():
    again = (1.1, 1.0, 1.0)
    poses = [
        ("+z", 6.0),
        *[(side, 3.0) for side in SIX[1:]],
        (tilts(1)[0], 3.0),
        (again, 3.0),
        ("-y", 3.0),
    ]
    guide, messages = guide_through(poses)
    assert messages[-2].startswith("Repeated: this is tilt 1, within ")
    assert messages[-1].startswith("Repeated: this is -y")
    assert guide.tilts == 1


def test_a_side_that_is_not_squarely_up_is_refused():
    guide, messages = guide_through([("+z", 6.0), ((1, 0.5, 0), 3.0)])
    assert messages[1].startswith("No side is up: +x is off by 2")
    assert guide.sides == ("+z",)


def test_the_pose_that_is_done_does_not_count_again():
    guide, messages = guide_through([("+z", 30.0)])
    assert messages == ["Done: +z up."]
    assert guide.stage is Stage.PLACE


def test_a_sensor_in_a_hand_is_not_at_rest():
    guide, messages = guide_through([("+z", 6.0)], noise=8.0)
    assert (guide.held, messages) == (0.0, [])


def test_a_creeping_sensor_is_not_at_rest():
    raw = counts([("+z", 6.0), ("+x", 8.0)])
    creep = np.radians(np.clip(np.arange(len(raw)) - 7 * RATE, 0, None) / RATE * 3)
    x = raw[:, 0].copy()
    raw[:, 0] = np.rint(x * np.cos(creep))
    raw[:, 1] += np.rint(x * np.sin(creep)).astype(int)
    guide = Guide(QUICK)
    messages = [message for block in blocks(raw) for message in guide.feed(block)]
    assert messages[0] == "Done: +z up."
    assert any(message.startswith("Moved too early") for message in messages)
    assert guide.sides == ("+z",)


def test_a_sensor_that_reads_nothing_has_no_side_up():
    guide = Guide(QUICK)
    messages = [
        message for block in blocks(np.zeros((400, 7), dtype=int)) for message in guide.feed(block)
    ]
    assert [message.startswith("No side is up") for message in messages] == [True]


def test_samples_that_are_missing_are_not_rest():
    monitor = RestMonitor()
    t = np.delete(np.arange(200) / RATE, slice(50, 100))
    windows = list(monitor.feed(Block.from_counts(t, counts([("+z", 1.0)])[: len(t)], Setup())))
    assert [window.at_rest for window in windows] == [True, False, True, True]
    assert sum(window.duration for window in windows) == pytest.approx(t[-1], abs=0.2)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"settle": 0.5}, "settle is 0.5 s; expected 1 to 600"),
        ({"hold": float("nan")}, "hold is nan s; expected 1 to 600"),
        ({"tilts": -1}, "tilts is -1; expected 0 to 60"),
    ],
)
def test_a_plan_out_of_range_is_refused(settings, message):
    with pytest.raises(ConfigError, match=message):
        Plan(**settings)
