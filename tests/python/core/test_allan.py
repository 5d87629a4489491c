"""Allan deviation: closed forms, an independent library, refusals, and derived figures."""

import math
import signal
from dataclasses import replace

import allantools
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter

import footnav
from command_line import Run
from footnav import Config, Recording, _core, allan, load_config, simulate_rest
from footnav.cli import main
from footnav.config import Sensor
from footnav.errors import ConfigError, DataError, FootnavWarning
from footnav.noise import FLICKER_FLOOR, AxisNoise, Figure, NoiseFigures, fit_axis, unit_variances
from footnav.plot import plot_allan
from footnav.simulation import SensorErrors, TriadErrors

GRAVITY = 9.80665
DEG_H = math.radians(1) / 3600
MILLI_G = 1e-3 * GRAVITY
TAUS = np.logspace(-2, 3, 51)


def curve(samples):
    """Return averaging times in samples, deviation and degrees of freedom of one channel."""
    result = _core.allan(np.column_stack([samples] * 3), lambda _: None)
    return (
        result["factors"].astype(int),
        result["deviation"][:, 0],
        result["degrees_of_freedom"][:, 0],
    )


def white(samples, seed=0):
    """Noise of standard deviation one, which at one sample a second has N = 1."""
    return np.random.default_rng(seed).normal(size=samples)


def flicker(samples, instability, seed=0):
    """Make 1/f noise in the frequency domain: one-sided density B²/(pi f), one sample a second."""
    rng = np.random.default_rng(seed)
    f = np.fft.rfftfreq(4 * samples)[1:]
    std = np.sqrt(instability**2 / (math.pi * f) * 4 * samples / 4)
    spectrum = std * (rng.normal(size=len(f)) + 1j * rng.normal(size=len(f)))
    return np.fft.irfft(np.concatenate([[0], spectrum]))[:samples]


def resting(duration=120.0, rate_hz=50.0, seed=0, **columns):
    """Record white noise of 0.02 m/s² and 0.002 rad/s at rest."""
    rng = np.random.default_rng(seed)
    n = round(duration * rate_hz) + 1
    recording = Recording(
        columns.pop("t", np.arange(n) / rate_hz),
        [0, 0, GRAVITY] + 0.02 * rng.normal(size=(n, 3)),
        0.002 * rng.normal(size=(n, 3)),
        name="table.csv",
    )
    return replace(recording, **columns)


def mpu6050(accel_instability, gyro_instability, **walk):
    """Return an MPU6050 with bias instabilities in mg and deg/h."""
    sensor = SensorErrors.preset("mpu6050")
    return sensor.replace(
        accel=sensor.accel.replace(
            bias_instability=accel_instability * MILLI_G, bias_walk=walk.get("accel", 0.0)
        ),
        gyro=sensor.gyro.replace(
            bias_instability=gyro_instability * DEG_H, bias_walk=walk.get("gyro", 0.0)
        ),
    )


# The deviation


@pytest.mark.parametrize(
    "samples",
    [
        white(3000),
        np.cumsum(white(10_007, seed=1)),
        flicker(2048, 0.3) + 5.0,
        1e-3 * np.arange(1000.0) + white(1000, seed=2),
    ],
    ids=["white", "walk", "flicker", "drift"],
)
def test_deviations_are_those_of_allantools(samples):
    factors, deviation, _ = curve(samples)
    taus, expected, _, _ = allantools.oadev(samples, data_type="freq", taus=factors)
    np.testing.assert_array_equal(taus, factors)
    np.testing.assert_allclose(deviation, expected, rtol=1e-9)


@pytest.mark.parametrize(
    ("alpha", "samples"),
    [
        (2, np.diff(white(20_001))),
        (0, white(20_000)),
        (-1, flicker(20_000, 1.0, seed=2)),
        (-2, np.cumsum(white(20_000))),
    ],
    ids=["quantization", "white", "flicker", "walk"],
)
def test_degrees_of_freedom_are_those_of_allantools_for_the_noise_that_the_slope_shows(
    alpha, samples
):
    factors, _, freedom = curve(samples)
    # The slope at longer averaging times is too uncertain to identify the noise, and at the
    # shortest a walk is not one.
    where = (factors >= 4) & (factors <= 200)
    expected = [allantools.edf_simple(len(samples) + 1, int(m), alpha) for m in factors[where]]
    np.testing.assert_allclose(freedom[where], expected, rtol=1e-12)


def test_degrees_of_freedom_are_the_scatter_of_the_estimates():
    """A chi-squared variable over f degrees of freedom has the relative variance 2/f."""
    curves = [curve(white(2000, seed)) for seed in range(300)]
    variances = np.array([deviation**2 for _, deviation, _ in curves])
    scatter = 2 * (variances.mean(axis=0) / variances.std(axis=0)) ** 2
    allowed = {"rtol": 0.3}
    np.testing.assert_allclose(
        scatter, np.median([freedom for *_, freedom in curves], axis=0), **allowed
    )


def test_each_noise_has_its_slope():
    n = 200_000
    cases = {
        "white": (white(n), lambda m: 1 / np.sqrt(m)),
        "walk": (np.cumsum(white(n, seed=1)), lambda m: np.sqrt(m / 3)),
        "flicker": (flicker(n, 1.0), lambda m: np.full(m.shape, FLICKER_FLOOR)),
    }
    for name, (samples, expected) in cases.items():
        factors, deviation, _ = curve(samples)
        middle = (factors >= 10) & (factors <= 1000)
        np.testing.assert_allclose(
            deviation[middle], expected(factors[middle]), rtol=0.1, err_msg=name
        )


def test_a_drift_is_its_slope_times_the_averaging_time_over_root_two():
    factors, deviation, _ = curve(0.25 * np.arange(5000.0))
    np.testing.assert_allclose(deviation, 0.25 * factors / math.sqrt(2), rtol=1e-9)


@settings(deadline=None)
@given(
    offset=st.floats(-100, 100),
    scale=st.floats(1e-3, 1e3),
    seed=st.integers(0, 1000),
    length=st.integers(20, 400),
)
def test_offsets_do_not_count_and_the_unit_of_the_samples_is_that_of_the_deviation(
    offset, scale, seed, length
):
    samples = white(length, seed)
    plain, scaled = curve(samples)[1], curve(scale * (samples + offset))[1]
    np.testing.assert_allclose(scaled, scale * plain, rtol=1e-9)


@settings(max_examples=10, deadline=None)
@given(slower=st.floats(0.5, 3.0))
def test_slower_samples_have_the_same_deviations_at_longer_times(slower):
    recording = resting(300.0)
    plain, slow = allan(recording), allan(replace(recording, t=slower * recording.t))
    np.testing.assert_allclose(slow.taus, slower * plain.taus, rtol=1e-9)
    np.testing.assert_allclose(slow.deviations, plain.deviations, rtol=1e-12)


def test_the_interval_holds_the_true_deviation_as_often_as_it_says():
    inside = []
    for seed in range(10):
        found = allan(resting(seed=seed))
        true = np.repeat([0.02, 0.002], 3) / np.sqrt(50 * found.taus)[:, None]
        inside.append((found.low <= true) & (true <= found.high))
    assert 0.9 < np.mean(inside) < 0.99


def test_channels_units_and_times_are_named():
    found = allan(resting(120.0))
    assert found.channels == ("accel_x", "accel_y", "accel_z", "gyro_x", "gyro_y", "gyro_z")
    assert found.units == ("m/s^2",) * 3 + ("rad/s",) * 3
    assert found.duration == 120.0
    assert (found.taus[0], found.taus[-1]) == pytest.approx((0.02, 10.02))
    assert found.deviations.shape == found.low.shape == found.high.shape == (len(found.taus), 6)


def test_progress_goes_from_nothing_to_all():
    shares = []
    allan(resting(), progress=shares.append)
    assert shares == sorted(shares)
    assert shares[0] > 0
    assert shares[-1] == pytest.approx(1.0)


def test_an_interrupt_ends_the_work():
    heard = []

    def press_control_c(share):
        heard.append(share)
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        allan(resting(), progress=press_control_c)
    assert len(heard) == 1


# The figures


def figures_of(strengths, taus=TAUS, freedom=1000.0):
    """Fit the exact deviations of Q, N, B and K."""
    deviation = np.sqrt(unit_variances(taus) @ np.square(strengths))
    return fit_axis("gyro_x", taus, deviation, np.full(len(taus), freedom))


@given(
    quantization=st.floats(0.15, 0.3),
    white=st.floats(1.0, 1.5),
    instability=st.floats(1.0, 2.0),
    walk=st.floats(0.1, 0.3),
    unit=st.floats(1e-9, 1e3),
)
@settings(deadline=None)
def test_the_terms_of_an_exact_curve_are_found_in_any_unit(
    quantization, white, instability, walk, unit
):
    strengths = unit * np.array([quantization, white, instability, walk])
    for figure, strength in zip(figures_of(strengths).terms, strengths, strict=True):
        assert figure.value == pytest.approx(strength, rel=1e-3)
        assert figure.low < strength < figure.high


@pytest.mark.parametrize("only", range(4))
def test_a_lonely_term_is_the_only_one_that_is_seen(only):
    strengths = np.zeros(4)
    strengths[only] = 0.3
    for term, figure in enumerate(figures_of(strengths).terms):
        if term == only:
            assert figure.value == pytest.approx(0.3)
        else:
            assert figure.value is None
            assert figure.low == 0 < figure.high


def test_fewer_degrees_of_freedom_widen_the_interval():
    strengths = np.array([0, 1.0, 0.3, 0])
    wide, narrow = (
        figures_of(strengths, freedom=freedom).bias_instability for freedom in (20.0, 1000.0)
    )
    assert wide.low < narrow.low < 0.3 < narrow.high < wide.high


def test_a_term_is_drawn_at_its_deviation():
    noise = figures_of([0.3, 1.0, 1.0, 0.1])
    np.testing.assert_allclose(
        noise.deviations(np.array([3.0]))[0], [0.3 / 3**0.5, 1 / 3**0.5, 0.6643, 0.1], rtol=1e-3
    )


def test_a_short_record_of_white_noise_shows_white_noise_only():
    figures = allan(resting()).fit()
    for axis in figures.axes:
        true = (0.02 if axis.channel.startswith("accel") else 0.002) / math.sqrt(50)
        assert axis.random_walk.value == pytest.approx(true, rel=0.1)
        assert axis.random_walk.low < true < axis.random_walk.high
        assert [axis.quantization.value, axis.bias_instability.value, axis.bias_walk.value] == [
            None
        ] * 3
        assert axis.wander is None


def test_a_walking_bias_is_found():
    sensor = mpu6050(0, 0, accel=3e-4, gyro=1e-5)
    for axis in allan(simulate_rest(7200, sensor, seed=2, rate_hz=25)).fit().axes:
        true = 3e-4 if axis.channel.startswith("accel") else 1e-5
        assert axis.bias_walk.low < true < axis.bias_walk.high
        assert axis.bias_walk.value == pytest.approx(true, rel=0.4)


def test_a_low_pass_filter_in_the_sensor_hardly_moves_the_white_noise():
    """Its -3 dB are at a tenth of the rate: the shortest averages show less noise than there is."""
    recording = resting(600.0)
    smooth = lfilter([0.45], [1, -0.55], recording.gyro, axis=0)
    found = allan(replace(recording, gyro=smooth)).fit()
    for axis in found.axes[3:]:
        assert axis.random_walk.value == pytest.approx(0.002 / math.sqrt(50), rel=0.12)


def test_the_figures_of_a_published_sensor_come_back():
    """Wu, Lu, Chen, table 1: gyroscope 22, 20, 26 deg/h, accelerometer 0.62, 0.57, 0.67 mg."""
    accel, gyro = np.array([0.62, 0.57, 0.67]), np.array([22.0, 20.0, 26.0])
    found = []
    for axis in range(3):
        recording = simulate_rest(2000, mpu6050(accel[axis], gyro[axis]), seed=axis, rate_hz=50)
        axes = allan(recording).fit().axes
        found.append((axes[axis].bias_instability, axes[3 + axis].bias_instability))
    for (in_accel, in_gyro), a, g in zip(found, accel * MILLI_G, gyro * DEG_H, strict=True):
        assert in_accel.value == pytest.approx(a, rel=0.15)
        assert in_gyro.value == pytest.approx(g, rel=0.15)
        assert in_accel.low < a < in_accel.high
        assert in_gyro.low < g < in_gyro.high


# Into the settings of the filter


def axis(channel, white=None, instability=None, walk=None):
    return AxisNoise(
        channel, *(Figure(value, 0.0, 9.0) for value in (None, white, instability, walk))
    )


FIGURES = NoiseFigures(
    (
        axis("accel_x", 0.01),
        axis("accel_y", 0.03, instability=0.5, walk=0.02),
        axis("accel_z", 0.02, instability=0.1, walk=0.06),
        axis("gyro_x", 0.001),
        axis("gyro_y", 0.002, instability=0.004),
        axis("gyro_z", 0.001, walk=0.0001),
    )
)


def test_the_worst_axis_is_inflated_into_the_settings():
    sensor = FIGURES.sensor(inflation=(2.0, 10.0))
    assert sensor.accel_noise_density == pytest.approx(0.06)
    assert sensor.gyro_noise_density == pytest.approx(0.004)
    assert sensor.accel_bias_walk == pytest.approx(0.6)
    # A bias instability counts as a walk that goes as far in 100 s.
    assert sensor.gyro_bias_walk == pytest.approx(0.004)


def test_what_was_not_seen_keeps_its_setting():
    base = Sensor(gyro_bias_walk=7e-5, accel_bias_walk=8e-4, gyro_bias_std=0.1)
    sensor = allan(resting()).fit().sensor(base, inflation=(1.0, 1.0))
    assert (
        sensor.replace(
            gyro_noise_density=base.gyro_noise_density, accel_noise_density=base.accel_noise_density
        )
        == base
    )
    assert sensor.gyro_noise_density == pytest.approx(0.002 / math.sqrt(50), rel=0.1)


@pytest.mark.parametrize("inflation", [(0.0, 1.0), (1.0, -2.0), (math.nan, 1.0), (1.0, math.inf)])
def test_an_inflation_that_is_not_positive_is_refused(inflation):
    with pytest.raises(ConfigError, match=r"inflation is .* and .*; expected two positive numbers"):
        FIGURES.sensor(inflation=inflation)


# Refusals


def test_a_short_record_says_how_long_it_must_be():
    with pytest.raises(
        DataError, match=r"^table\.csv: 60 s of rest are too short: .* at least 100 s; two hours"
    ):
        allan(resting(60.0))


def test_a_gap_is_named_and_its_cure_works():
    t = np.arange(9001) / 50 + np.repeat([0.0, 0.5], [3000, 6001])
    recording = resting(180.0, t=t)
    with pytest.raises(
        DataError,
        match=r"59\.980 s and 60\.500 s are 0\.52 s apart, where 0\.02 s are usual; 1 such",
    ) as e:
        allan(recording)
    assert "span=(60.500, 180.500)" in str(e.value)
    assert allan(recording, (60.5, 180.5)).duration == pytest.approx(120.0)


def test_a_repeated_stamp_is_named():
    t = np.arange(6001) / 50
    t[1000] = t[999]
    with pytest.raises(DataError, match=r"19\.980 s and 19\.980 s are 0 s apart"):
        allan(resting(t=t))


def test_stamps_in_whole_milliseconds_are_even_enough():
    t = np.round(np.arange(6001) / 47, 3)
    assert allan(resting(t=t)).taus[0] == pytest.approx(1 / 47, rel=1e-4)


def touched(at, seconds, accel=0.0, gyro=0.0):
    """Shake a resting sensor; from then on gravity is elsewhere, too, when it is tilted."""
    recording = resting(200.0)
    shaken = recording.gyro.copy()
    during = (recording.t >= at) & (recording.t < at + seconds)
    shaken[during, 1] += gyro * np.sin(40 * recording.t[during])
    force = recording.accel.copy()
    force[recording.t >= at, 0] += accel
    return replace(recording, accel=force, gyro=shaken)


def test_a_touch_is_named_and_its_cure_works():
    recording = touched(62.0, 2.0, gyro=0.02)
    message = (
        r"gyro_y scatters by 0\.01\d* rad/s, more than 0\.005\d*, at 62\.0 s: .* in 2 of 200 s;"
    )
    with pytest.raises(DataError, match=message) as e:
        allan(recording)
    assert "span=(64.000, 200.000)" in str(e.value)
    assert allan(recording, (64.0, 200.0)).duration == pytest.approx(136.0)


def test_a_touch_in_the_last_moment_is_named():
    with pytest.raises(DataError, match=r"gyro_y scatters by .* at 199\.0 s: .* in 1 of 200 s"):
        allan(touched(199.8, 1.0, gyro=0.05))


def test_a_tilt_is_named():
    with pytest.raises(
        DataError, match=r"accel_x jumps by 0\.19\d* m/s\^2, more than .* at 120\.0 s"
    ):
        allan(touched(120.0, 0.0, accel=0.2))


def test_a_walk_is_no_rest():
    walk, _ = footnav.simulate(footnav.simulation.Route.straight(130.0), rate_hz=50)
    with pytest.raises(DataError, match="the sensor was moved or touched"):
        allan(walk)


def test_a_recorded_walk_is_no_rest(data_dir):
    """All of them are shorter than a rest must be, so its samples are said to be slower."""
    with np.load(min((data_dir / "vicon").glob("*.npz"))) as file:
        walk = Recording(10 * file["t"], file["accel"], file["gyro"])
    with pytest.raises(DataError, match="the sensor was moved or touched"):
        allan(walk)


def test_shaking_without_a_pause_leaves_no_rest_to_propose():
    recording = resting()
    with pytest.raises(DataError, match=r"in 120 of 120 s; leave it alone$"):
        allan(replace(recording, gyro=100 * recording.gyro))


def test_a_channel_that_never_changes_is_named():
    recording = resting()
    gyro = recording.gyro.copy()
    gyro[:, 2] = 0.01
    with pytest.raises(DataError, match=r"gyro_z reads 0\.01 rad/s in every sample"):
        allan(replace(recording, gyro=gyro))


def test_noise_below_the_resolution_is_warned_of():
    recording = resting()
    gyro = 0.008 * np.round((recording.gyro + 0.003) / 0.008)
    with pytest.warns(
        FootnavWarning,
        match=r"gyro_[xyz] scatters by .* rad/s, less than half of its resolution of 0\.008",
    ):
        allan(replace(recording, gyro=gyro))


def test_a_warming_sensor_is_warned_of():
    recording = resting()
    warming = replace(recording, temperature=20 + 5 * recording.t / 120)
    with pytest.warns(
        FootnavWarning,
        match=r"^table\.csv: the temperature moves from 20\.0 to 25\.0 degrees Celsius",
    ):
        allan(warming)
    steady = replace(recording, temperature=20 + 0.1 * white(len(recording)))
    allan(steady, (0.0, 110.0))


def test_a_span_outside_the_recording_is_refused():
    with pytest.raises(
        ConfigError, match="span is 500 to 600 s, but the stamps go from 0 to 120 s"
    ):
        allan(resting(), (500.0, 600.0))


# The simulated sensor


def test_a_sensor_on_a_table_reads_gravity():
    recording = simulate_rest(2.0, "ideal", rate_hz=100, gravity=9.8)
    np.testing.assert_array_equal(recording.accel, np.tile([0, 0, 9.8], (201, 1)))
    assert not recording.gyro.any()


def test_a_rest_of_no_length_is_refused():
    with pytest.raises(ConfigError, match=r"duration = -1: expected 0 to 1e6 s"):
        simulate_rest(-1.0)


def test_a_negative_bias_instability_is_refused():
    sensor = SensorErrors(gyro=TriadErrors(bias_instability=-1.0))
    with pytest.raises(ConfigError, match=r"sensor\.gyro\.bias_instability = -1"):
        simulate_rest(1.0, sensor)


# Picture and command


def test_the_picture_shows_every_axis_in_the_units_of_data_sheets():
    found = allan(resting())
    gyro, accel = plot_allan(found, found.fit()).axes
    x = next(line for line in gyro.get_lines() if line.get_label() == "x")
    np.testing.assert_allclose(x.get_ydata(), found.deviations[:, 3] / DEG_H)
    z = next(line for line in accel.get_lines() if line.get_label() == "z")
    np.testing.assert_allclose(z.get_ydata(), found.deviations[:, 2] / MILLI_G)
    np.testing.assert_allclose(z.get_xdata(), found.taus)
    assert (gyro.get_xscale(), gyro.get_yscale()) == ("log", "log")
    assert "(deg/h)" in gyro.get_ylabel()
    assert "(mg)" in accel.get_ylabel()
    assert len(gyro.collections) == 3


def test_a_picture_without_a_fit_has_the_curves_alone():
    assert [len(ax.get_lines()) for ax in plot_allan(allan(resting())).axes] == [3, 3]


@pytest.fixture
def table(tmp_path):
    """File of a sensor at rest."""
    path = tmp_path / "table.csv"
    resting(300.0).save(path)
    return path


def test_the_command_prints_both_kinds_of_units(run: Run, table):
    done = run("allan", table)
    assert (done.status, done.err) == (0, "")
    row = next(line for line in done.out.splitlines() if "angle random walk" in line)
    value = float(row.split()[5])
    assert "deg/sqrt(h)" in row
    assert value == pytest.approx(math.degrees(0.002 / math.sqrt(50)) * 60, rel=0.1)
    assert "table.csv: 300 s at rest, averaged over up to 25.18 s" in done.out
    assert "gyro bias instability" in done.out
    assert "not seen, <" in done.out
    assert "white noise times 2 and bias walk times 3" in done.out


def test_the_settings_are_those_that_track_takes(run: Run, table, tmp_path):
    done = run("allan", table, "--out", "noise.toml", "--plot", "noise.png", "--inflation", 3, 5)
    assert done.status == 0
    assert "Written: noise.png, noise.toml" in done.out
    expected = allan(footnav.read(table)).fit().sensor(inflation=(3.0, 5.0))
    settings = load_config(tmp_path / "noise.toml")
    assert settings.sensor.gyro_noise_density == pytest.approx(
        expected.gyro_noise_density, rel=1e-3
    )
    assert settings.replace(sensor=Sensor()) == Config()
    assert settings.sensor.gyro_bias_walk == Sensor().gyro_bias_walk
    assert (
        (tmp_path / "noise.toml")
        .read_text()
        .startswith("# Allan deviation of table.csv; white noise times 3 and bias")
    )
    assert (tmp_path / "noise.png").read_bytes().startswith(b"\x89PNG")


def test_part_of_a_file_is_measured(run: Run, table):
    done = run("allan", table, "--span", 100, 250)
    assert "150 s at rest" in done.out


def test_the_command_says_what_is_wrong(run: Run, table, tmp_path):
    short = tmp_path / "short.csv"
    resting(20.0).save(short)
    failed = run("allan", short)
    assert (failed.status, failed.out) == (1, "")
    assert failed.err.startswith("footnav: short.csv: 20 s of rest are too short")
    misused = run("allan", table, "--plot", "noise.bmp")
    assert misused.status == 2
    assert "noise.bmp: unknown suffix '.bmp', expected one of .png" in misused.err
    assert not (tmp_path / "noise.toml").exists()


def test_one_foot_of_a_pair_is_measured(run: Run, tmp_path):
    path = tmp_path / "pair.csv"
    counts = (
        np.random.default_rng(0).normal([0, 0, 4096, 0, 0, 0] * 2, 8, size=(12_000, 12)).round()
    )
    np.savetxt(path, np.column_stack([10 * np.arange(12_000), counts]), fmt="%d", delimiter=",")
    ranges = ("--accel-range", 8, "--gyro-range", 1000)
    both = run("allan", path, *ranges)
    assert both.status == 2
    assert "holds the sensors of both feet; choose one with --foot left or --foot right" in both.err
    assert main(["allan", str(path), *map(str, ranges), "--foot", "left"]) == 0
