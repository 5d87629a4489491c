"""Batch tracking.

Rows, errors and warnings, and the physics of the track.
"""

import warnings

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial
from scipy.spatial.transform import Rotation

import footnav.tracking
from footnav import Config, FootnavWarning, Recording, track
from footnav.config import Alignment, HealthLimits, Mechanization, Output, Sensor
from footnav.detectors import Shoe
from footnav.errors import ConfigError, DataError
from footnav.health import Flag, Status

G = Config().gravity
EARTH_RATE = 7.292115e-5
AXES = {
    "x": (1, 0, 0),
    "y": (0, 1, 0),
    "z": (0, 0, 1),
    "-x": (-1, 0, 0),
    "-y": (0, -1, 0),
    "-z": (0, 0, -1),
}

MINIMUM_JERK = Polynomial([0, 0, 0, 10, -15, 6])
BUMP = 64 * Polynomial([0, 1, -1]) ** 3

REST, SWING, STANCE, STRIDES, STRIDE = 2.0, 0.6, 0.6, 6, 1.2


def resting(mounting=None, n=300, rate=100.0, accel_bias=0.0, gyro_bias=0.0, **more):
    """Return a noiseless recording of a sensor that stands still.

    `mounting` turns its axes into east, north, up.
    """
    up = (mounting or Rotation.identity()).inv().apply([0.0, 0.0, G])
    return Recording(
        np.arange(n) / rate, np.tile(up + accel_bias, (n, 1)), np.zeros((n, 3)) + gyro_bias, **more
    )


def strides(rate=128.0):
    """Return stamps, specific force, angular rate and true position of a foot that walks along x.

    Each swing is a polynomial in the share of it that is done: forward by minimum jerk, up and
    down, toe down and up.
    """
    t = np.arange(int((2 * REST + STRIDES * (SWING + STANCE)) * rate)) / rate
    since = np.clip(t - REST, 0.0, STRIDES * (SWING + STANCE))
    number = np.minimum(since // (SWING + STANCE), STRIDES - 1)
    share = np.clip((since - number * (SWING + STANCE)) / SWING, 0.0, 1.0)
    forward, up, pitch = STRIDE * MINIMUM_JERK, 0.1 * BUMP, 1.5 * BUMP * Polynomial([1, -2])
    zero = np.zeros_like(t)
    acceleration = np.column_stack([forward.deriv(2)(share), zero, up.deriv(2)(share)]) / SWING**2
    attitude = Rotation.from_rotvec(np.column_stack([zero, pitch(share), zero]))
    accel = attitude.inv().apply(acceleration + np.array([0.0, 0.0, G]))
    gyro = np.column_stack([zero, pitch.deriv()(share) / SWING, zero])
    return t, accel, gyro, np.column_stack([number * STRIDE + forward(share), zero, up(share)])


def about_z(position):
    """Turn a track about the vertical until it ends on the positive x axis."""
    yaw = np.arctan2(position[-1, 1], position[-1, 0])
    return Rotation.from_euler("z", -yaw).apply(position.copy())


def attitude_of(trajectory, row=-1):
    """Return the rotation from the sensor to the navigation frame."""
    return Rotation.from_quat(trajectory.quaternion[row].copy())


def norm_at_least(least):
    """Return a filter of tuples by their length."""
    return lambda v: np.linalg.norm(v) > least


mountings = st.tuples(*[st.floats(-1, 1)] * 4).filter(norm_at_least(0.1)).map(Rotation.from_quat)
directions = (
    st.tuples(*[st.floats(-1, 1)] * 3)
    .filter(norm_at_least(0.1))
    .map(lambda v: np.array(v) / np.linalg.norm(v))
)


# Interface of track()


@pytest.mark.parametrize("n", [129, 200, 500])
def test_one_row_per_sample_with_its_stamp(n):
    recording = resting(n=n, name="still.csv")
    states = track(recording)
    np.testing.assert_array_equal(states.t, recording.t)
    assert states.position.shape == states.velocity.shape == states.position_std.shape == (n, 3)
    assert states.quaternion.shape == (n, 4)
    assert (states.name, states.health.status) == ("still.csv", Status.OK)
    assert states.health.counters.samples == n


def test_origin_and_frame_come_from_the_settings():
    output = Output(origin=(48.0, 11.0, 500.0), frame="ned")
    states = track(resting(), Config(output=output))
    assert (states.origin, states.frame) == (output.origin, "ned")


@pytest.mark.parametrize("n", [2, 20, 90])
def test_too_short_a_recording_is_named(n):
    with pytest.raises(DataError, match=rf"^short\.csv: {n} samples .*too few.*1\.0 s"):
        track(resting(n=n, name="short.csv"))


@pytest.mark.parametrize(
    ("accel", "gyro", "unit"), [(1 / 9.80665, 1.0, "in g"), (1.0, 180 / np.pi, "deg/s")]
)
def test_other_units_are_refused_before_they_are_tracked(accel, gyro, unit):
    t, force, rate, _ = strides()
    with pytest.raises(DataError, match=rf"^walk\.csv: .*{unit}"):
        Recording(t, force * accel, 3 * rate * gyro, name="walk.csv")


def test_a_good_walk_has_no_warning_and_is_ok():
    states = track(Recording(*strides()[:3]))
    assert (states.health.status, states.health.flags) == (Status.OK, Flag(0))


def test_a_start_in_motion_is_flagged_over_the_whole_walk():
    t, accel, gyro, _ = strides()
    cut = t > REST + 0.05
    with pytest.warns(FootnavWarning, match=r"^walk\.csv: .*motion"):
        states = track(Recording(t[cut], accel[cut], gyro[cut], name="walk.csv"))
    assert Flag.MOVING_START in states.health.flags
    assert states.health.status is Status.DEGRADED


def test_gaps_are_counted_and_flagged_over_the_whole_walk():
    t, accel, gyro, _ = strides()
    keep = np.ones(len(t), bool)
    keep[[300, 301, 302, 400, 401]] = False
    with pytest.warns(FootnavWarning, match="missing in 2 places"):
        states = track(Recording(t[keep], accel[keep], gyro[keep]))
    assert states.health.counters.gaps == 2
    assert Flag.GAP in states.health.flags
    assert Flag.GAP not in Flag(int(states.flags[-1]))


@pytest.mark.parametrize(
    ("lost", "gap_intervals", "gaps"), [(1, 2.5, 0), (2, 2.5, 1), (2, 3.5, 0), (1, 1.5, 1)]
)
def test_a_gap_is_an_interval_of_so_many_nominal_ones(lost, gap_intervals, gaps):
    t = np.delete(np.arange(400) / 100, slice(200, 200 + lost))
    recording = Recording(t, np.tile([0, 0, G], (len(t), 1)), np.zeros((len(t), 3)))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FootnavWarning)
        states = track(recording, Config(health=HealthLimits(gap_intervals=gap_intervals)))
    assert states.health.counters.gaps == gaps


def test_repeated_stamps_are_counted():
    t, accel, gyro, _ = strides()
    t[[300, 400, 401]] = t[[299, 399, 399]]
    with pytest.warns(FootnavWarning, match="3 samples repeat"):
        states = track(Recording(t, accel, gyro))
    assert states.health.counters.repeated == 3
    assert len(states) == len(t)


def test_clipping_is_detected_by_the_range_of_the_recording():
    t, accel, gyro, _ = strides()
    full_scale = 0.9 * np.abs(gyro).max()
    clipped = np.clip(gyro, -full_scale, full_scale)
    with pytest.warns(FootnavWarning, match=r"walk: .*clipped.*wider range"):
        states = track(Recording(t, accel, clipped, name="walk", gyro_range=full_scale))
    assert states.health.counters.clipped == (np.abs(clipped) == full_scale).any(axis=1).sum()
    assert Flag.CLIPPED in states.health.flags
    assert track(Recording(t, accel, clipped)).health.counters.clipped == 0


def test_a_range_in_the_settings_comes_before_that_of_the_recording():
    t, accel, gyro, _ = strides()
    config = Config(sensor=Sensor(gyro_range=100.0))
    states = track(Recording(t, accel, gyro, gyro_range=np.abs(gyro).max()), config)
    assert states.health.counters.clipped == 0


def test_a_foot_that_never_rests_again_degrades_the_walk():
    t = np.arange(800) / 100
    shaken = np.where(t[:, None] > 2, np.sin(25 * t)[:, None], 0.0)
    recording = Recording(t, [0.0, 0.0, G] + 5 * shaken * [1, 0, 0], 3 * shaken * [1, 1, 1])
    with pytest.warns(FootnavWarning, match="at rest for too long"):
        states = track(recording, Config(detector=Shoe()))
    assert Flag.NO_ZERO_VELOCITY in states.health.flags
    assert states.health.status is Status.DEGRADED


def test_progress_rises_to_one_and_blocks_change_nothing(monkeypatch):
    recording = Recording(*strides()[:3])
    whole, shares = track(recording), []
    monkeypatch.setattr(footnav.tracking, "BLOCK", 100)
    states = track(recording, progress=shares.append)
    np.testing.assert_array_equal(states.position, whole.position)
    assert len(shares) == -(-len(recording) // 100)
    assert shares == sorted(shares)
    assert 0 < shares[0] < shares[-1] == 1.0


def test_exceptions_of_progress_propagate():
    def stop(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        track(resting(), progress=stop)


def test_the_recording_is_left_as_it_was_and_gives_the_same_again():
    t, accel, gyro, _ = strides()
    recording = Recording(t, accel, gyro)
    first, second = track(recording), track(recording)
    np.testing.assert_array_equal(recording.accel, accel)
    for column in ("position", "quaternion", "position_std", "gyro_bias"):
        np.testing.assert_array_equal(getattr(first, column), getattr(second, column))


# Rest


@given(mountings, directions, directions, st.floats(0, 1), st.floats(0, 1))
@example(Rotation.identity(), np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0]), 1.0, 1.0)
@example(Rotation.from_euler("y", 90, degrees=True), np.eye(3)[0], np.eye(3)[0], 0.0, 1.0)
@example(Rotation.from_euler("x", 180, degrees=True), np.eye(3)[0], np.eye(3)[1], 1.0, 0.0)
@settings(max_examples=20, deadline=None)
def test_a_resting_sensor_stays_where_it_is_in_any_mounting(
    mounting, accel_way, gyro_way, accel_share, gyro_share
):
    accel_bias = accel_share * Sensor().accel_bias_std * accel_way
    gyro_bias = gyro_share * Sensor().gyro_bias_std * gyro_way
    states = track(resting(mounting, 6000, accel_bias=accel_bias, gyro_bias=gyro_bias))
    assert np.abs(states.position).max() < 1e-3
    up = attitude_of(states).inv().apply([0.0, 0.0, 1.0])
    tilt = np.arccos(np.clip(up @ mounting.inv().apply([0.0, 0.0, 1.0]), -1, 1))
    assert tilt <= np.arcsin(np.linalg.norm(accel_bias) / G) + 1e-6
    np.testing.assert_allclose(states.gyro_bias[-1], gyro_bias, atol=1e-6)


@given(mountings)
@settings(max_examples=20, deadline=None)
def test_up_is_exact_without_an_accelerometer_bias(mounting):
    states = track(resting(mounting))
    up = attitude_of(states).inv().apply([0.0, 0.0, 1.0])
    np.testing.assert_allclose(up, mounting.inv().apply([0.0, 0.0, 1.0]), atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(states.quaternion, axis=1), 1.0, atol=1e-12)


@given(mountings, st.floats(-360, 360), st.sampled_from(sorted(AXES)))
@settings(max_examples=30, deadline=None)
def test_heading_is_that_of_the_forward_axis_clockwise_from_north(mounting, heading_deg, axis):
    assume(np.linalg.norm(mounting.apply(AXES[axis])[:2]) > 0.5)
    config = Config(alignment=Alignment(heading_deg=heading_deg, forward_axis=axis))
    east, north, _ = attitude_of(track(resting(mounting), config)).apply(AXES[axis])
    heading = np.deg2rad(heading_deg)
    np.testing.assert_allclose(
        np.array([east, north]) / np.hypot(east, north),
        [np.sin(heading), np.cos(heading)],
        atol=1e-9,
    )


@given(mountings, st.sampled_from(sorted(AXES)))
@settings(max_examples=20, deadline=None)
def test_without_a_heading_x_is_where_the_forward_axis_points(mounting, axis):
    assume(np.linalg.norm(mounting.apply(AXES[axis])[:2]) > 0.5)
    x, y, _ = attitude_of(
        track(resting(mounting), Config(alignment=Alignment(forward_axis=axis)))
    ).apply(AXES[axis])
    assert x > 0
    assert abs(y) < 1e-9


@given(
    mountings,
    st.floats(-180, 180),
    st.floats(-80, 80),
    st.sampled_from(sorted(AXES)),
    st.sampled_from([1e-5, 1, 50]),
)
@settings(max_examples=30, deadline=None)
def test_the_magnetic_field_gives_the_whole_attitude(
    mounting, declination_deg, inclination_deg, axis, unit
):
    declination, inclination = np.deg2rad([declination_deg, inclination_deg])
    east, north = (
        np.sin(declination) * np.cos(inclination),
        np.cos(declination) * np.cos(inclination),
    )
    field = mounting.inv().apply(unit * np.array([east, north, -np.sin(inclination)]))
    alignment = Alignment(
        magnetic_field=tuple(field.tolist()), declination_deg=declination_deg, forward_axis=axis
    )
    attitude = attitude_of(track(resting(mounting), Config(alignment=alignment)))
    assert (attitude.inv() * mounting).magnitude() < 1e-7


@pytest.mark.parametrize("axis", ["z", "-z"])
def test_a_heading_of_an_axis_that_stands_upright_is_refused(axis):
    with pytest.raises(DataError, match="forward_axis"):
        track(resting(), Config(alignment=Alignment(heading_deg=0.0, forward_axis=axis)))


@pytest.mark.parametrize("field", [(0.0, 0.0, 0.0), (0.0, 0.0, -4e-5)])
def test_a_field_without_a_horizontal_part_is_refused(field):
    with pytest.raises((DataError, ConfigError), match="magnetic"):
        track(resting(), Config(alignment=Alignment(magnetic_field=field)))


@pytest.mark.parametrize("latitude_deg", [-60.0, 0.0, 45.0])
def test_a_sensor_that_turns_with_the_earth_keeps_its_heading(latitude_deg):
    latitude = np.deg2rad(latitude_deg)
    earth = EARTH_RATE * np.array([0.0, np.cos(latitude), np.sin(latitude)])
    config = Config(
        alignment=Alignment(heading_deg=90.0),
        mechanization=Mechanization(earth_rate=True, latitude_deg=latitude_deg, gravity=G),
    )
    states = track(resting(n=6000, gyro_bias=earth), config)
    turned = (attitude_of(states) * attitude_of(states, 200).inv()).magnitude()
    assert turned < 0.05 * EARTH_RATE * 60
    np.testing.assert_allclose(states.gyro_bias[-1], 0.0, atol=0.1 * EARTH_RATE)


# Gravity


def normal_gravity(latitude_deg, height):
    """Differentiate the normal potential of WGS-84 in ellipsoidal-harmonic coordinates numerically.

    Heiskanen and Moritz 1967, section 2-7, with the series of q (eq. 2-58), whose closed form
    cancels.
    """
    a, f, gm, w = 6378137.0, 1 / 298.257223563, 3.986004418e14, 7.292115e-5
    b = a * (1 - f)
    linear = np.sqrt(a**2 - b**2)

    def q(u):
        n = np.arange(1, 12)
        return np.sum(
            (-1.0) ** (n + 1) * 2 * n / ((2 * n + 1) * (2 * n + 3)) * (linear / u) ** (2 * n + 1)
        )

    def potential(x, z):
        r2 = x**2 + z**2 - linear**2
        u = np.sqrt(r2 / 2 * (1 + np.sqrt(1 + 4 * linear**2 * z**2 / r2**2)))
        sin2 = (z / u) ** 2
        rotating = w**2 * a**2 / 2 * q(u) / q(b) * (sin2 - 1 / 3)
        return gm / linear * np.arctan2(linear, u) + rotating + w**2 / 2 * x**2

    latitude = np.deg2rad(latitude_deg)
    cos, sin = np.cos(latitude), np.sin(latitude)
    radius = a / np.sqrt(1 - f * (2 - f) * sin**2)
    x, z = (radius + height) * cos, (radius * (1 - f) ** 2 + height) * sin
    step = 50.0
    along_x = (potential(x + step, z) - potential(x - step, z)) / (2 * step)
    along_z = (potential(x, z + step) - potential(x, z - step)) / (2 * step)
    return np.hypot(along_x, along_z)


def test_the_independent_formula_gives_the_published_values():
    """NIMA TR8350.2, table 3.4: gravity at the equator and at the pole."""
    assert normal_gravity(0.0, 0.0) == pytest.approx(9.7803253359, abs=1e-8)
    assert normal_gravity(90.0, 0.0) == pytest.approx(9.8321849378, abs=1e-8)


@given(st.floats(-90, 90), st.floats(-400, 9000))
@settings(max_examples=50, deadline=None)
def test_gravity_is_normal_gravity(latitude_deg, height):
    config = Config(mechanization=Mechanization(latitude_deg=latitude_deg, height=height))
    assert config.gravity == pytest.approx(normal_gravity(latitude_deg, height), abs=2e-6)


def test_where_gravity_is_taken_at():
    origin = Output(origin=(60.0, 10.0, 1000.0))
    assert Config().gravity == pytest.approx(normal_gravity(45.0, 0.0), abs=1e-7)
    assert Config(output=origin).gravity == pytest.approx(normal_gravity(60.0, 1000.0), abs=1e-6)
    elsewhere = Config(output=origin, mechanization=Mechanization(latitude_deg=0.0, height=0.0))
    assert elsewhere.gravity == pytest.approx(normal_gravity(0.0, 0.0), abs=1e-7)
    assert Config(output=origin, mechanization=Mechanization(gravity=9.81)).gravity == 9.81


# Motion


@pytest.mark.parametrize("rate", [100.0, 200.0, 400.0])
def test_a_walk_of_known_shape_is_followed(rate):
    """Held samples are late by half an interval, and the error of the track goes with that."""
    t, accel, gyro, truth = strides(rate)
    states = track(Recording(t, accel, gyro))
    error = np.linalg.norm(states.position - truth, axis=1)
    assert error[-1] < 0.002 * STRIDE * STRIDES
    assert error.max() < 4 * STRIDE / rate
    assert states.zero_velocity[(t > 1) & (t < REST - 0.1)].all()


@given(mountings)
@settings(max_examples=15, deadline=None)
def test_turning_the_axes_of_the_sensor_leaves_the_track_the_same_up_to_yaw(mounting):
    t, accel, gyro, _ = strides()
    turned = track(Recording(t, mounting.apply(accel), mounting.apply(gyro)))
    np.testing.assert_allclose(
        about_z(turned.position), about_z(track(Recording(t, accel, gyro)).position), atol=1e-6
    )


@pytest.mark.parametrize("shift", [1.0, -5000.0, 1.7e9])
def test_shifting_time_changes_nothing(shift):
    """Every stamp is a multiple of 1/128 s, so that no shift rounds any."""
    t, accel, gyro, _ = strides(128.0)
    states, shifted = track(Recording(t, accel, gyro)), track(Recording(t + shift, accel, gyro))
    for column in ("position", "velocity", "quaternion", "position_std", "zero_velocity"):
        np.testing.assert_array_equal(
            getattr(shifted, column), getattr(states, column), err_msg=column
        )
    np.testing.assert_array_equal(shifted.t, t + shift)


@pytest.mark.parametrize("rate", [100.0, 200.0, 400.0])
def test_stamps_since_1970_give_the_track_of_stamps_since_the_start(rate):
    """Such stamps are rounded to 0.24 us, which moves a foot by micrometres."""
    t, accel, gyro, _ = strides(rate)
    states, shifted = track(Recording(t, accel, gyro)), track(Recording(t + 1.7e9, accel, gyro))
    np.testing.assert_array_equal(shifted.zero_velocity, states.zero_velocity)
    np.testing.assert_allclose(shifted.position, states.position, atol=1e-4)


level_or_plumb = st.floats(-np.pi, np.pi).map(
    lambda a: np.array([np.cos(a), np.sin(a), 0.0])
) | st.sampled_from([np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])])


@given(mountings, level_or_plumb, st.floats(0.3, 1.0), st.integers(0, 1000))
@example(Rotation.identity(), np.array([0.0, 0.0, 1.0]), 0.875, 0)
@settings(max_examples=20, deadline=None)
def test_a_push_gives_the_displacement_that_it_is_the_second_integral_of(
    mounting, way, length, seed
):
    """Within five sigma of the accelerometer's noise, integrated over push and alignment.

    Along an incline the specific force of a push without rotation may for a while have the
    magnitude of gravity, which no inertial sensor can distinguish from rest on a slope.  The
    example brakes with twice gravity as it rises.
    """
    rate, duration, sensor = 200.0, 0.5, Sensor()
    t = np.arange(int(4.5 * rate)) / rate
    share = np.clip((t - 2) / duration, 0, 1)
    acceleration = length * MINIMUM_JERK.deriv(2)(share)[:, None] / duration**2 * way
    noise = np.random.default_rng(seed).normal(size=(2, len(t), 3)) * np.sqrt(rate)
    accel = (
        mounting.inv().apply(acceleration + np.array([0, 0, G]))
        + sensor.accel_noise_density * noise[0]
    )
    states = track(Recording(t, accel, sensor.gyro_noise_density * noise[1]))
    yaw = attitude_of(states, 300) * mounting.inv()
    displacement = yaw.inv().apply(states.position[-1].copy())
    sigma = sensor.accel_noise_density * np.sqrt(duration**3 / 3 + duration**4 / 4)
    np.testing.assert_allclose(displacement, length * way, atol=5 * sigma + 2e-3 * length)
    assert (np.abs(displacement - length * way) < 5 * np.linalg.norm(states.position_std[-1])).all()


@pytest.mark.parametrize("kind", ["two-sample", "single-sample", "first-order"])
def test_every_mechanization_follows_a_walk(kind):
    t, accel, gyro, truth = strides(400.0)
    states = track(Recording(t, accel, gyro), Config(mechanization=Mechanization(kind=kind)))
    assert np.linalg.norm(states.position[-1] - truth[-1]) < 0.01 * STRIDE * STRIDES


def test_the_heading_turns_the_track():
    """A walk along the forward axis with a heading of 90 degrees goes east.

    With one of 180 degrees, south.
    """
    recording = Recording(*strides()[:3])
    for heading_deg, way in ((90.0, [1, 0]), (180.0, [0, -1]), (0.0, [0, 1])):
        end = track(recording, Config(alignment=Alignment(heading_deg=heading_deg))).position[-1]
        np.testing.assert_allclose(end[:2], STRIDE * STRIDES * np.array(way), atol=0.05)
