"""A recording accepts array-likes, and rejects invalid samples with a helpful message."""

import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footnav.errors import ConfigError, DataError
from footnav.recording import STANDARD_GRAVITY, Recording

N = 50


def samples(n=N, dt=0.01):
    """Return stamps, specific force and angular rate of a sensor at rest, as writable arrays."""
    return np.arange(n) * dt, np.tile([0.0, 0.0, STANDARD_GRAVITY], (n, 1)), np.full((n, 3), 0.01)


@pytest.mark.parametrize(
    "convert",
    [
        lambda a: a.tolist(),
        np.asfortranarray,
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a.astype(np.longdouble),
        np.ma.asarray,
    ],
    ids=["list", "fortran", "strided", "longdouble", "masked"],
)
def test_array_likes_give_the_same_contiguous_float64(convert):
    arrays = samples()
    recording = Recording(*map(convert, arrays))
    for got, expected in zip((recording.t, recording.accel, recording.gyro), arrays, strict=True):
        np.testing.assert_array_equal(got, expected)
        assert got.dtype == np.float64
        assert got.flags.c_contiguous


def test_float32_and_integers_are_widened():
    t, accel, _ = samples()
    recording = Recording(
        t.astype(np.float32), np.rint(accel).astype(np.int16), np.zeros((N, 3), np.uint8)
    )
    assert recording.accel[0].tolist() == [0.0, 0.0, 10.0]
    assert recording.t.dtype == np.float64


def test_arrays_are_read_only_copies():
    t, accel, gyro = samples()
    recording = Recording(t, accel, gyro)
    accel[:] = 0.0
    assert recording.accel[0, 2] == STANDARD_GRAVITY
    with pytest.raises(ValueError, match="read-only"):
        recording.gyro[0] = 1.0
    with pytest.raises(AttributeError):
        recording.t = t


def test_properties_and_repr():
    t, accel, gyro = samples()
    t[10] = t[9]
    recording = Recording(t, accel, gyro, name="walk.csv")
    assert len(recording) == N
    assert recording.duration == t[-1] - t[0]
    assert recording.rate_hz == pytest.approx(100.0)
    assert repr(recording) == "Recording('walk.csv', 50 samples, 0.49 s, 100 Hz)"


def test_mean_magnetic_field_is_that_of_the_start():
    mag = np.tile([20e-6, 5e-6, -43e-6], (N, 1))
    mag[:10:2, 0] += 1e-6
    mag[1:10:2, 0] -= 1e-6
    mag[10:] = 1.0
    recording = Recording(*samples(), mag)
    assert recording.mean_magnetic_field(0.095) == pytest.approx((20e-6, 5e-6, -43e-6))
    with pytest.raises(DataError, match="walk has no magnetometer"):
        Recording(*samples(), name="walk").mean_magnetic_field(1.0)


def test_repeated_stamps_and_gaps_are_kept():
    t, accel, gyro = samples()
    t[10] = t[9]
    t[30:] += 1.0
    np.testing.assert_array_equal(Recording(t, accel, gyro).t, t)


def test_pickles_to_the_same_samples():
    recording = Recording(*samples(), pressure=np.full(N, 101325.0), accel_range=156.9)
    copy = pickle.loads(pickle.dumps(recording))
    np.testing.assert_array_equal(copy.accel, recording.accel)
    np.testing.assert_array_equal(copy.pressure, recording.pressure)
    assert copy.accel_range == 156.9
    assert copy.rate_hz == recording.rate_hz
    assert not copy.gyro.flags.writeable


@pytest.mark.parametrize(
    ("label", "values", "message"),
    [
        ("t", np.zeros((N, 1)), r"t has shape \(50, 1\); expected \(50,\)"),
        ("accel", np.ones((3, N)), r"accel has shape \(3, 50\); expected \(50, 3\).*transpose"),
        ("gyro", np.ones((N - 1, 3)), r"gyro has shape \(49, 3\)"),
        ("gyro", [[0.0, 0.0, 0.0]] * (N - 1) + [[0.0, 0.0]], "gyro is ragged"),
        ("accel", [["0", "0", "9.8"]] * N, "accel holds <U3 values; expected real numbers"),
        ("accel", np.ones((N, 3), complex), "accel holds complex128"),
        ("accel", [[None, 0.0, 9.8]] * N, "accel holds object"),
        ("mag", np.ones(N), r"mag has shape \(50,\)"),
        ("pressure", np.ones((N, 3)), r"pressure has shape \(50, 3\)"),
        ("t", np.arange(N).astype("datetime64[ms]"), "t holds datetime64"),
    ],
)
def test_wrong_shape_or_type_is_refused(label, values, message):
    arrays = dict(zip(("t", "accel", "gyro"), samples(), strict=True)) | {label: values}
    with pytest.raises(DataError, match=message):
        Recording(**arrays)


@pytest.mark.parametrize("n", [0, 1])
def test_fewer_than_two_samples_are_refused(n):
    with pytest.raises(DataError, match=f"there are {n} samples; at least 2"):
        Recording(*samples(n))


def test_first_value_that_is_not_finite_is_named():
    t, accel, gyro = samples()
    gyro[12, 1] = np.nan
    accel[20:22, 0] = -np.inf
    with pytest.raises(
        DataError, match=r"^walk: row 12 \(counted from 0\): gyro_y is nan; 3 value"
    ):
        Recording(t, accel, gyro, name="walk")


def test_masked_values_are_seen():
    t, accel, gyro = samples()
    masked = np.ma.array(accel, mask=False)
    masked[7, 2] = np.ma.masked
    with pytest.raises(DataError, match=r"row 7.*accel_z is nan"):
        Recording(t, masked, gyro)


def test_scalar_channel_that_is_not_finite_is_named():
    pressure = np.full(N, 101325.0)
    pressure[3] = np.inf
    with pytest.raises(DataError, match=r"row 3.*pressure is inf; 1 value"):
        Recording(*samples(), pressure=pressure)


def test_time_that_goes_back_is_refused():
    t, accel, gyro = samples()
    t[30:] -= 0.1
    with pytest.raises(DataError, match=r"row 30 .*from 0.29 s to 0.19"):
        Recording(t, accel, gyro)


def test_time_that_stands_still_is_refused():
    _, accel, gyro = samples()
    with pytest.raises(DataError, match=r"all 50 stamps are 2.0 s.*rate_hz"):
        Recording(np.full(N, 2.0), accel, gyro)


@pytest.mark.parametrize(
    ("dt", "cure"), [(10.0, '"ms"'), (1e4, '"us"'), (1e7, '"ns"'), (10e-6, '"us"')]
)
def test_stamps_that_are_not_seconds_are_refused(dt, cure):
    with pytest.raises(DataError, match=f"not in seconds; read them with .*{cure}"):
        Recording(*samples(dt=dt))


@pytest.mark.parametrize(
    ("factor", "message"),
    [
        (1 / STANDARD_GRAVITY, 'in g; read them with accel_unit="g"'),
        (1000 / STANDARD_GRAVITY, 'accel_unit="mg"'),
        (0.01, "gravity was removed"),
        (2.0, "about 2 g .*accel_range is twice.*i2cdevlib"),
        (1.95, "about 2 g"),
        (0.3, "neither m/s"),
        (1e200, r"neither m/s"),
        (16384 / STANDARD_GRAVITY, "raw counts need their full scale"),
    ],
)
def test_specific_force_in_another_unit_is_refused(factor, message):
    t, accel, gyro = samples()
    with pytest.raises(DataError, match=message):
        Recording(t, accel * factor, gyro)


def test_a_runner_whose_median_is_near_two_g_is_accepted():
    t, accel, gyro = samples(400)
    accel[50:] *= 1.9 + 0.4 * np.sin(np.arange(350) * 0.9)[:, None]
    assert np.median(accel[:, 2]) > 1.8 * STANDARD_GRAVITY
    assert len(Recording(t, accel, gyro)) == 400


def test_angular_rate_in_degrees_is_refused():
    t, accel, gyro = samples()
    gyro[25, 2] = -400.0
    with pytest.raises(DataError, match=r'reaches 400 rad/s.*gyro_unit="deg/s"'):
        Recording(t, accel, gyro)


@pytest.mark.parametrize("value", [0, -1.0, np.nan, np.inf, "16", True, [16.0]])
def test_full_scale_must_be_a_positive_number(value):
    with pytest.raises(ConfigError, match=r"accel_range is .*positive number"):
        Recording(*samples(), accel_range=value)


def test_full_scale_in_another_unit_is_refused():
    with pytest.raises(ConfigError, match=r"accel_range is 8 m/s\^2, but the samples reach 9.807"):
        Recording(*samples(), accel_range=8)


@settings(deadline=None)
@given(
    st.lists(st.floats(0.005, 0.05), min_size=3, max_size=30),
    st.floats(0.0, 2e9),
)
def test_rate_and_duration_follow_from_the_intervals(intervals, start):
    t = start + np.concatenate(([0.0], np.cumsum(intervals)))
    _, accel, gyro = samples(len(t))
    recording = Recording(t, accel, gyro)
    resolution = np.spacing(t[-1])
    assert recording.duration == pytest.approx(sum(intervals), abs=4 * resolution, rel=1e-9)
    assert 1 / recording.rate_hz == pytest.approx(
        np.median(intervals), abs=4 * resolution, rel=1e-9
    )
