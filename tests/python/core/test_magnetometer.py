"""The heading that a magnetometer holds.

A walk whose gyroscope drifts, in the field of the Earth and in bent ones.
"""

import dataclasses
import re
import warnings

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footnav import (
    Config,
    FootnavWarning,
    Navigator,
    Recording,
    Trajectory,
    simulate,
    track,
    track_many,
)
from footnav.config import Filter, Magnetometer, Output, Smoother
from footnav.errors import ConfigError, DataError

RATE = 100.0
FIELD = np.array([15e-6, 5e-6, -48e-6])
DRIFT = 5e-6
"""rad/s^2; what the gyroscope's bias about the vertical gains while one walks."""

HELD = Config(magnetometer=Magnetometer(heading=True))
COLUMNS = (
    "t",
    "position",
    "velocity",
    "quaternion",
    "zero_velocity",
    "position_std",
    "gyro_bias",
    "accel_bias",
)


@pytest.fixture(scope="module")
def walk():
    """Return a walk of 160 m without magnetometer, and the rotation n to b of each sample."""
    recording, truth = simulate(
        [[0, 0], [40, 0], [40, 40], [0, 40], [0, 0]], sensor="ideal", rate_hz=RATE, seed=1
    )
    to_sensor = Rotation.from_quat(truth.quaternion).inv()
    drift = np.outer(DRIFT * np.clip(recording.t - 5, 0, None), [0, 0, 1])
    return dataclasses.replace(recording, gyro=recording.gyro + to_sensor.apply(drift)), to_sensor


def with_field(walk, turned_deg=0.0, strength=1.0):
    """Return the walk with a magnetometer in a field turned about the vertical and stretched."""
    recording, to_sensor = walk
    turned = Rotation.from_rotvec(
        np.outer(np.radians(turned_deg * np.ones(len(recording))), [0, 0, 1])
    )
    field = turned.apply(FIELD) * (strength * np.ones(len(recording)))[:, None]
    return dataclasses.replace(recording, mag=to_sensor.apply(field))


def heading_errors(track, walk):
    """Return how far the track's attitude is turned about the vertical, degrees."""
    return np.degrees((Rotation.from_quat(track.quaternion) * walk[1]).as_rotvec()[:, 2])


def counts(track):
    """Return the number of stances whose field was used, and of those in which it was not."""
    return track.health.counters.magnetic_updates, track.health.counters.magnetic_rejected


def assert_same(one, other):
    """Assert that two tracks are the same to the bit."""
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


def in_blocks(config, samples, length):
    """Push columns in blocks, and return all states."""
    navigator = Navigator(config, rate_hz=RATE)
    starts = range(0, len(samples[0]), length)
    parts = [
        navigator.push_block(*(column[start : start + length] for column in samples))
        for start in starts
    ]
    return Trajectory.concatenate([*parts, navigator.flush()])


def columns(recording):
    """Return what is pushed of a recording."""
    return recording.t, recording.accel, recording.gyro, recording.mag


def between(walk, start, end):
    """Say of each sample of the walk whether it lies between two times, s."""
    return (walk[0].t > start) & (walk[0].t < end)


def test_the_field_holds_the_heading_of_a_gyroscope_that_drifts(walk):
    recording = with_field(walk)
    free, held = track(recording), track(recording, HELD)
    used, rejected = counts(held)
    assert used > 100
    assert rejected == 0
    assert abs(heading_errors(held, walk)[-1]) < abs(heading_errors(free, walk)[-1]) / 5
    assert np.linalg.norm(held.position[-1]) < np.linalg.norm(free.position[-1]) / 4


@pytest.mark.parametrize("smoother", ["stepwise", "rts"])
def test_a_smoother_refines_it(walk, smoother):
    recording = with_field(walk)
    greatest = [
        np.abs(
            heading_errors(track(recording, config.replace(smoother=Smoother(kind=smoother))), walk)
        ).max()
        for config in (Config(), HELD)
    ]
    assert greatest[1] < greatest[0] / 5


@pytest.mark.parametrize(
    "bent",
    [
        lambda inside: {"turned_deg": 60.0 * inside},
        lambda inside: {"strength": 1 + 0.3 * inside},
        lambda inside: {"turned_deg": 60.0 * inside, "strength": 1 - 0.5 * inside},
    ],
    ids=["turned", "stronger", "both"],
)
def test_a_bent_field_is_rejected(walk, bent):
    disturbed = track(with_field(walk, **bent(between(walk, 60, 70))), HELD)
    used, rejected = counts(disturbed)
    assert rejected >= 7
    assert used > 10 * rejected
    undisturbed = np.abs(heading_errors(track(with_field(walk), HELD), walk)).max()
    assert np.abs(heading_errors(disturbed, walk)).max() < 1.2 * undisturbed


def test_a_field_that_is_disturbed_at_the_start_is_rejected_later_and_reported(walk):
    recording = with_field(walk, turned_deg=90.0 * between(walk, -1, 3))
    with pytest.warns(
        FootnavWarning,
        match=r"in \d+ of \d+ stances the magnetic field disagreed.*calibrate the magneto",
    ):
        bent = track(recording, HELD)
    assert counts(bent)[0] <= 1
    np.testing.assert_allclose(bent.position, track(recording).position, atol=0.1)


def test_hard_iron_is_rejected_where_it_shows(walk):
    recording = with_field(walk)
    iron = dataclasses.replace(recording, mag=recording.mag + np.array([30e-6, 0, 0]))
    with pytest.warns(FootnavWarning, match="calibrate the magnetometer"):
        used, rejected = counts(track(iron, HELD))
    assert rejected > 2 * used


def test_any_blocks_give_the_batch_result_to_the_bit(walk):
    recording = with_field(walk)
    smoothed = HELD.replace(smoother=Smoother(kind="stepwise"), output=Output(strides=True))
    for config, length in ((HELD, 5), (HELD, 5000), (smoothed, 37)):
        assert_same(in_blocks(config, columns(recording), length), track(recording, config))


def test_a_slow_magnetometer_reads_nothing_in_between_or_holds_what_it_read(walk):
    recording = with_field(walk)
    slow = np.arange(len(recording)) % 10 == 0
    absent = np.where(slow[:, None], recording.mag, np.nan)
    held = dataclasses.replace(
        recording, mag=recording.mag[::10].repeat(10, axis=0)[: len(recording)]
    )
    whole = track(held, HELD)
    assert counts(whole)[0] > 100
    assert_same(in_blocks(HELD, (*columns(recording)[:3], absent), 500), whole)


def test_the_unit_of_the_field_does_not_matter(walk):
    recording = with_field(walk)
    scaled = dataclasses.replace(recording, mag=recording.mag * 2.0**20)
    assert_same(track(scaled, HELD), track(recording, HELD))


def test_off_the_readings_change_nothing(walk):
    recording = with_field(walk)
    assert_same(track(recording), track(walk[0]))
    assert_same(in_blocks(Config(), columns(recording), 1000), track(walk[0]))


def test_a_navigator_forgets_the_field_on_reset(walk):
    recording = with_field(walk)
    navigator = Navigator(HELD, rate_hz=RATE)
    navigator.push_block(*columns(with_field(walk, turned_deg=90.0)))
    navigator.reset()
    assert_same(
        Trajectory.concatenate([navigator.push_block(*columns(recording)), navigator.flush()]),
        track(recording, HELD),
    )


def test_the_heading_is_recovered_after_a_gap(walk):
    recording = with_field(walk)
    keep = ~between(walk, 60, 75)
    gappy = Recording(*(column[keep] for column in columns(recording)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FootnavWarning)
        free, held = track(gappy), track(gappy, HELD)
    turned = [
        (Rotation.from_quat(found.quaternion) * walk[1][keep]).as_rotvec()[-1, 2]
        for found in (free, held)
    ]
    assert abs(turned[0]) > np.radians(60)
    assert abs(turned[1]) < np.radians(5)


def test_without_a_magnetometer_the_error_has_a_remedy(walk):
    cure = (
        r"magnetometer\.heading is set, but there is no reading.*pass its readings.*"
        r"or leave the setting out"
    )
    with pytest.raises(DataError, match=f"simulated 1: {cure}"):
        track(walk[0], HELD)
    with pytest.raises(DataError, match=cure):
        Navigator(HELD, rate_hz=RATE).push_block(walk[0].t, walk[0].accel, walk[0].gyro)


@pytest.mark.parametrize("reading", [[np.inf, 0, 0], [np.nan, 1e-5, 1e-5]])
def test_a_reading_that_is_not_finite_is_refused_with_its_block(walk, reading):
    samples = columns(with_field(walk))
    bad = samples[3].copy()
    bad[17] = reading
    navigator = Navigator(HELD, rate_hz=RATE)
    with pytest.raises(
        DataError,
        match=r"at 0\.\d+ s the magnetic field is .*expected three finite numbers.*three NaN",
    ):
        navigator.push_block(*samples[:3], bad)
    assert navigator.health.counters.samples == 0
    assert_same(
        Trajectory.concatenate([navigator.push_block(*samples), navigator.flush()]),
        in_blocks(HELD, samples, 500),
    )


def test_a_field_of_the_wrong_shape_is_refused(walk):
    t, accel, gyro, mag = columns(with_field(walk))
    for wrong in (mag[:-1], mag[:, :2], mag.T, mag[:, 0]):
        with pytest.raises(DataError, match=r"mag.*shape"):
            Navigator(HELD, rate_hz=RATE).push_block(t, accel, gyro, wrong)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"std_deg": 0.0}, "magnetometer.std_deg = 0: expected between 0.1 and 90"),
        (
            {"strength_tolerance": -0.1},
            "magnetometer.strength_tolerance = -0.1: expected a positive number",
        ),
        (
            {"dip_tolerance_deg": 0.0},
            "magnetometer.dip_tolerance_deg = 0: expected a positive number",
        ),
    ],
)
def test_settings_out_of_range_are_named(settings, message):
    with pytest.raises(ConfigError, match=re.escape(message)):
        Config(magnetometer=Magnetometer(**settings))


def test_only_a_kalman_filter_takes_a_heading():
    with pytest.raises(
        ConfigError, match=r"magnetometer\.heading corrects.*set filter\.kind = \"kf\""
    ):
        HELD.replace(filter=Filter(kind="dr"))


def test_tracks_of_other_fields_are_kept_apart(walk, tmp_path):
    fields = (with_field(walk), with_field(walk, strength=1 + 0.2 * between(walk, 60, 70)))
    resumed = [
        [result.resumed for result in track_many(fields, config, folder=tmp_path)]
        for config in (HELD, HELD, Config())
    ]
    assert resumed[:2] == [[False, False], [True, True]]


def test_the_health_counts_magnetic_updates(walk):
    used, rejected = counts(track(with_field(walk), HELD))
    described = str(track(with_field(walk), HELD).health)
    assert f"{used:,} magnetic updates ({rejected:,} rejected)." in described
    assert "magnetic" not in str(track(walk[0]).health)


def test_where_the_field_is_bent_nearly_everywhere_it_does_no_harm(data_dir):
    paths = sorted((data_dir / "openshoe").glob("*.npz"))
    for path in paths:
        with np.load(path) as file:
            t, accel, gyro, mag = (file[name] for name in ("t", "accel", "gyro", "mag"))
        navigator = Navigator(HELD, rate_hz=250.0)
        states = Trajectory.concatenate(
            [navigator.push_block(t, accel, gyro, mag), navigator.flush()]
        )
        assert np.linalg.norm(states.position[-1, :2]) < 0.3, path.name
        assert (
            navigator.health.counters.magnetic_rejected
            > navigator.health.counters.magnetic_updates
            > 0
        )
    assert paths
