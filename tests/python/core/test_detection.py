"""Stance detectors against the published formulas, written out sample by sample."""

import itertools
import math
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from footnav import Config, Navigator, Recording, Trajectory, _core, detect, load_config, track
from footnav.config import Mechanization
from footnav.detection import Detection
from footnav.detectors import (
    AccelerationMagnitude,
    AdaptiveShoe,
    AngularRateEnergy,
    Detector,
    GraphTheoretic,
    MagnitudeDebounced,
    MagnitudeVariance,
    MovingVariance,
    Shoe,
    ThreeCondition,
    WindowedEnergies,
)
from footnav.errors import ConfigError
from footnav.health import Flag
from footnav.settings import by_kind

DETECTORS = {kind: settings() for kind, settings in by_kind(get_args(Detector)).items()}
WINDOWED = [
    detector for detector in DETECTORS.values() if not isinstance(detector, MagnitudeDebounced)
]


def recording(n=240, rate=100.0, seed=3, phase=0.0):
    """Return a foot that comes to rest again and again."""
    t = np.arange(n) / rate
    motion = np.clip(np.sin(2 * np.pi * t + phase), 0.0, None)[:, None]
    noise = np.random.default_rng(seed).normal(size=(2, n, 3))
    accel = [0.5, -0.3, 9.78] + 0.02 * noise[0] + motion * 3 * noise[0]
    return Recording(t, accel, 0.005 * noise[1] + motion * 3 * noise[1])


def window_length(seconds, rate):
    """Return the odd number of samples nearest to a duration, three at the least."""
    return max(3, 2 * math.floor((seconds * rate - 1) / 2 + 0.5) + 1)


def over_windows(length, n, statistic):
    """Evaluate a statistic over the window centred on each sample; nan where it does not fit."""
    half = length // 2
    values = np.full(n, np.nan)
    for k in range(half, n - half):
        values[k] = statistic(slice(k - half, k + half + 1))
    return values


def shoe_statistic(rec, length, accel_std, gyro_std, gravity):
    """Skog et al. 2010: mean of |f - g mean(f)/|mean(f)||^2 / sigma_a^2 + |w|^2 / sigma_w^2."""

    def statistic(window):
        accel, gyro = rec.accel[window], rec.gyro[window]
        mean = accel.mean(axis=0)
        residual = accel - gravity * mean / np.linalg.norm(mean)
        return np.mean(
            (residual**2).sum(axis=1) / accel_std**2 + (gyro**2).sum(axis=1) / gyro_std**2
        )

    return over_windows(length, len(rec), statistic)


seconds = st.sampled_from([0.001, 0.023, 0.051, 0.074, 0.107, 0.153])
rates = st.sampled_from([50.0, 100.0, 128.0, 200.0])
stds = st.floats(1e-3, 1.0)


@given(seconds, rates, stds, stds, st.floats(9.7, 9.9))
@settings(max_examples=25, deadline=None)
def test_shoe(window, rate, accel_std, gyro_std, gravity):
    rec = recording(rate=rate)
    config = Config(
        detector=Shoe(window=window, accel_std=accel_std, gyro_std=gyro_std),
        mechanization=Mechanization(gravity=gravity),
    )
    expected = shoe_statistic(rec, window_length(window, rate), accel_std, gyro_std, gravity)
    np.testing.assert_allclose(detect(rec, config).statistic, expected, rtol=1e-9, equal_nan=True)


@given(seconds, st.integers(0, 60), st.integers(0, 60), st.floats(1.0, 5.0), st.floats(1.0, 1e4))
@settings(max_examples=25, deadline=None)
def test_adaptive_shoe(window, behind, ahead, factor, floor):
    rec = recording()
    detector = AdaptiveShoe(
        window=window,
        look_behind=behind / 100,
        look_ahead=ahead / 100,
        min_factor=factor,
        noise_floor=floor,
    )
    result = detect(rec, detector)
    length = window_length(window, rec.rate_hz)
    statistic = shoe_statistic(rec, length, detector.accel_std, detector.gyro_std, Config().gravity)
    np.testing.assert_allclose(result.statistic, statistic, rtol=1e-9, equal_nan=True)
    inside = np.isfinite(statistic)
    around = [statistic[max(0, k - behind) : k + ahead + 1] for k in np.flatnonzero(inside)]
    stillest = np.array([factor * np.nanmin(part) for part in around])
    below_swing = np.array([detector.max_fraction * np.nanmax(part) for part in around])
    expected = np.clip(np.minimum(stillest, below_swing), floor, detector.upper_bound)
    np.testing.assert_allclose(result.threshold[inside], expected, rtol=1e-9)


@given(seconds, rates, st.floats(0.01, 1.0), st.floats(0.001, 1.0))
@settings(max_examples=25, deadline=None)
def test_magnitude_variance(window, rate, magnitude_gate, variance_gate):
    """Wu et al., eqs. 4-5: motion from |f| - g at its gate, or the variance of |f| at its own."""
    rec = recording(rate=rate)
    result = detect(
        rec,
        MagnitudeVariance(
            window=window, magnitude_gate=magnitude_gate, variance_gate=variance_gate
        ),
    )
    magnitude = np.linalg.norm(rec.accel, axis=1)
    deviation = np.abs(magnitude - Config().gravity)
    variance = over_windows(window_length(window, rate), len(rec), lambda at: magnitude[at].var())
    expected = np.maximum(deviation / magnitude_gate, variance / variance_gate)
    np.testing.assert_allclose(result.statistic, expected, rtol=1e-9, equal_nan=True)
    np.testing.assert_array_equal(
        result.decision, (deviation < magnitude_gate) & (variance < variance_gate)
    )


def magnitude(rec):
    """|f| and by how much it exceeds gravity."""
    norm = np.linalg.norm(rec.accel, axis=1)
    return norm, norm - Config().gravity


limits = st.floats(0.01, 5.0)


@given(seconds, rates, stds, stds, st.floats(1.0, 1e4), st.floats(1.0, 1e4))
@settings(max_examples=25, deadline=None)
def test_windowed_energies(window, rate, accel_std, gyro_std, accel_threshold, gyro_threshold):
    """Wang et al. 2019, eq. 3, each energy against its threshold."""
    rec = recording(rate=rate)
    thresholds = {"accel_threshold": accel_threshold, "gyro_threshold": gyro_threshold}
    result = detect(
        rec, WindowedEnergies(window=window, accel_std=accel_std, gyro_std=gyro_std, **thresholds)
    )
    length, (_, excess) = window_length(window, rate), magnitude(rec)
    accel = over_windows(
        length, len(rec), lambda at: (excess[at] ** 2).sum() / (accel_std**2 * length)
    )
    gyro = over_windows(
        length, len(rec), lambda at: (rec.gyro[at] ** 2).sum() / (gyro_std**2 * length)
    )
    expected = np.maximum(accel / accel_threshold, gyro / gyro_threshold)
    np.testing.assert_allclose(result.statistic, expected, rtol=1e-9, equal_nan=True)
    np.testing.assert_array_equal(
        result.decision, (accel < accel_threshold) & (gyro < gyro_threshold)
    )


@given(seconds, rates, limits, limits, limits)
@settings(max_examples=25, deadline=None)
def test_three_conditions(window, rate, band, variance_threshold, rate_threshold):
    """Wang Libing et al. 2016: a threshold for each quantity; all conditions hold together."""
    rec = recording(rate=rate)
    thresholds = {
        "magnitude_band": band,
        "variance_threshold": variance_threshold,
        "rate_threshold": rate_threshold,
        "window": window,
    }
    norm, excess = magnitude(rec)
    variance = over_windows(window_length(window, rate), len(rec), lambda at: norm[at].var())
    edge = np.isnan(variance)
    expected = {
        "magnitude": np.where(edge, np.nan, np.abs(excess) / band),
        "variance": variance / variance_threshold,
        "rate": np.where(edge, np.nan, np.linalg.norm(rec.gyro, axis=1) / rate_threshold),
    }
    for n in (1, 2, 3):
        for conditions in itertools.permutations(expected, n):
            result = detect(rec, ThreeCondition(conditions=conditions, **thresholds))
            parts = [expected[condition] for condition in conditions]
            np.testing.assert_allclose(
                result.statistic, np.max(parts, axis=0), rtol=1e-9, equal_nan=True
            )
            np.testing.assert_array_equal(
                result.decision, np.all([part < 1.0 for part in parts], axis=0)
            )


@given(seconds, rates, limits)
@settings(max_examples=25, deadline=None)
def test_the_detectors_of_skog(window, rate, threshold):
    """ARE, MV and MAG of Skog et al. 2010, in SI units instead of those of the sensor's noise."""
    rec = recording(rate=rate)
    _, excess = magnitude(rec)
    statistics = {
        AngularRateEnergy: lambda at: (rec.gyro[at] ** 2).sum(axis=1).mean(),
        MovingVariance: lambda at: (
            ((rec.accel[at] - rec.accel[at].mean(axis=0)) ** 2).sum(axis=1).mean()
        ),
        AccelerationMagnitude: lambda at: (excess[at] ** 2).mean(),
    }
    for kind, statistic in statistics.items():
        result = detect(rec, kind(window=window, threshold=threshold))
        expected = over_windows(window_length(window, rate), len(rec), statistic)
        np.testing.assert_allclose(result.statistic, expected, rtol=1e-9, equal_nan=True)
        np.testing.assert_array_equal(result.decision, expected <= threshold)


def contrast(points):
    """Return the largest mean distance between two parts of a window, less that within them."""
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    earlier, later = np.triu_indices(len(points), 1)
    edges = apart[earlier, later]
    cuts = [(earlier < cut) & (later >= cut) for cut in range(1, len(points))]
    return max(edges[between].mean() - edges[~between].mean() for between in cuts)


@given(seconds, rates, limits)
@settings(max_examples=15, deadline=None)
def test_the_graph_theoretic_detector(window, rate, threshold):
    rec = recording(rate=rate)
    result = detect(rec, GraphTheoretic(window=window, threshold=threshold))
    expected = over_windows(
        window_length(window, rate), len(rec), lambda at: contrast(rec.accel[at])
    )
    np.testing.assert_allclose(result.statistic, expected, rtol=1e-9, atol=1e-12, equal_nan=True)
    np.testing.assert_array_equal(result.decision, expected <= threshold)


def runs(flags):
    """Yield value, start and end of every run of equal flags."""
    start = 0
    for value, run in itertools.groupby(flags.tolist()):
        end = start + len(list(run))
        yield value, start, end
        start = end


def debounced(flags, longest_gap, shortest):
    """Fill the gaps that have detections on both sides, then drop what is too short."""
    filled, believed = flags.copy(), np.zeros_like(flags)
    for value, start, end in runs(flags):
        if not value and start > 0 and end < len(flags) and end - start <= longest_gap:
            filled[start:end] = True
    for value, start, end in runs(filled):
        if value and end - start >= shortest:
            believed[start:end] = True
    return believed


@given(
    st.integers(0, 400),
    st.floats(0.05, 3.0),
    st.integers(0, 12),
    st.integers(0, 12),
    st.integers(0, 9),
)
@settings(max_examples=60, deadline=None)
def test_magnitude_debounced(n, gate, longest_gap, shortest, seed):
    """Abdulrahim et al.: neither an isolated detection nor a gap is believed."""
    rec = recording(n=n + 2, seed=seed)
    detector = MagnitudeDebounced(
        magnitude_gate=gate, longest_gap=longest_gap / 100, shortest_stance=shortest / 100
    )
    result = detect(rec, detector)
    statistic = np.abs(magnitude(rec)[1])
    np.testing.assert_allclose(result.statistic, statistic, rtol=1e-9, atol=1e-12)
    np.testing.assert_array_equal(result.threshold, np.full(len(rec), gate))
    np.testing.assert_array_equal(
        result.decision, debounced(statistic < gate, longest_gap, shortest)
    )
    assert Navigator(Config(detector=detector), 100.0).latency == longest_gap + max(shortest, 1) - 1


@pytest.mark.parametrize("detector", WINDOWED, ids=lambda d: type(d).__name__)
def test_stance_is_a_statistic_below_the_threshold(detector):
    result = detect(recording(), detector)
    inside = np.isfinite(result.statistic)
    np.testing.assert_array_equal(
        result.decision[inside], (result.statistic < result.threshold)[inside]
    )


@pytest.mark.parametrize("detector", WINDOWED, ids=lambda d: type(d).__name__)
def test_the_edges_are_nan_and_never_stance(detector):
    rec = Recording(
        np.arange(200) / 100, np.tile([0.0, 0.0, Config().gravity], (200, 1)), np.zeros((200, 3))
    )
    result = detect(rec, detector)
    half = window_length(detector.window, 100.0) // 2
    edge = np.r_[0:half, 200 - half : 200]
    assert half >= 1
    assert np.isnan(result.statistic[edge]).all()
    assert not result.decision[edge].any()
    assert np.isfinite(result.statistic[half:-half]).all()
    assert result.decision[half:-half].all()


@pytest.mark.parametrize("detector", WINDOWED, ids=lambda d: type(d).__name__)
def test_the_threshold_is_nan_where_the_window_is_not_full(detector):
    result = detect(recording(), detector)
    np.testing.assert_array_equal(np.isnan(result.threshold), np.isnan(result.statistic))


@pytest.mark.parametrize("detector", WINDOWED, ids=lambda d: type(d).__name__)
def test_a_recording_shorter_than_the_window_has_no_stance(detector):
    rec = recording(n=2)
    result = detect(rec, detector)
    assert np.isnan(result.statistic).all()
    assert not result.decision.any()


@pytest.mark.parametrize("detector", DETECTORS.values(), ids=DETECTORS)
def test_a_steady_foot_is_found_at_rest_and_a_shaken_one_is_not(detector):
    """The graph separates different parts of a window; uniform shaking has none."""
    rec = recording(n=1000)
    moving = np.sin(2 * np.pi * rec.t) > 0.5
    resting = np.sin(2 * np.pi * rec.t) < -0.5
    steady = detect(rec, detector)
    if not isinstance(detector, GraphTheoretic):
        assert not steady.decision[moving].any()
    if not isinstance(detector, (MagnitudeVariance, MagnitudeDebounced)):
        assert steady.decision[resting][1:-1].all()


def test_what_names_a_detector():
    rec = recording()
    for kind, detector in DETECTORS.items():
        by_settings = detect(rec, detector)
        for named in (kind, Config(detector=detector)):
            np.testing.assert_array_equal(detect(rec, named).statistic, by_settings.statistic)
            np.testing.assert_array_equal(detect(rec, named).threshold, by_settings.threshold)
    np.testing.assert_array_equal(detect(rec).statistic, detect(rec, AdaptiveShoe()).statistic)


def test_it_unpacks_as_statistic_and_decision():
    rec = recording()
    result = detect(rec)
    statistic, decision = result
    assert isinstance(result, Detection)
    assert statistic is result.statistic
    assert decision is result.decision
    assert decision.dtype == np.bool_
    np.testing.assert_array_equal(result.t, rec.t)


@pytest.mark.parametrize("detector", ["sheo", "", "AdaptiveShoe"])
def test_an_unknown_detector_lists_the_known_ones(detector):
    with pytest.raises(ConfigError) as error:
        detect(recording(), detector)
    assert all(kind in str(error.value) for kind in (repr(detector), *DETECTORS))


def test_a_misspelt_detector_is_hinted_at():
    with pytest.raises(ConfigError, match="did you mean 'moving-variance'"):
        detect(recording(), "moving-varience")


@pytest.mark.parametrize("kind", DETECTORS)
def test_the_defaults_are_those_of_the_core(kind, tmp_path):
    """An empty table of the kind is filled in by the core before the statistic."""
    path = tmp_path / "shoe.toml"
    path.write_text(f'[detector]\nkind = "{kind}"\n')
    assert load_config(path) == Config(detector=DETECTORS[kind])
    rec = recording()
    config = f'{{"detector": {{"kind": "{kind}"}}}}'.encode()
    ours, cores = detect(rec, kind), _core.detect(config, rec.rate_hz, rec.t, rec.accel, rec.gyro)
    np.testing.assert_array_equal(ours.statistic, cores["statistic"])
    np.testing.assert_array_equal(ours.threshold, cores["threshold"])
    np.testing.assert_array_equal(ours.decision, cores["decision"])


@pytest.mark.parametrize("kind", DETECTORS)
def test_a_detector_survives_a_file(kind, tmp_path):
    config = Config(detector=DETECTORS[kind])
    config.save(tmp_path / "shoe.toml")
    assert load_config(tmp_path / "shoe.toml") == config


def every_setting():
    """Yield every numerical setting of every detector."""
    for detector in DETECTORS.values():
        for name in detector.__struct_fields__:
            if isinstance(getattr(detector, name), float):
                yield pytest.param(detector, name, id=f"{type(detector).__name__}.{name}")


@pytest.mark.parametrize(("detector", "name"), list(every_setting()))
def test_settings_out_of_range_are_refused(detector, name):
    with pytest.raises(ConfigError, match=rf"detector\.{name} = -1: expected"):
        detect(recording(), detector.replace(**{name: -1.0}))


@pytest.mark.parametrize("conditions", [(), ("rate", "rate")])
def test_conditions_are_one_or_more_each_once(conditions):
    with pytest.raises(
        ConfigError,
        match=r"detector\.conditions = \[.*\]: expected one or more of magnitude, variance",
    ):
        detect(recording(), ThreeCondition(conditions=conditions))


def test_an_unknown_condition_is_named_with_the_known_ones(tmp_path):
    with pytest.raises(ConfigError, match=r"speed.*magnitude.*variance.*rate"):
        detect(recording(), ThreeCondition(conditions=("speed",)))
    path = tmp_path / "shoe.toml"
    path.write_text('[detector]\nkind = "three-condition"\nconditions = ["speed"]\n')
    with pytest.raises(ConfigError, match=r"shoe\.toml: detector\.conditions.*speed"):
        load_config(path)


def test_the_statistic_does_not_depend_on_the_axes():
    rec = recording()
    turn = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    turned = Recording(rec.t, rec.accel @ turn, rec.gyro @ turn)
    for detector in DETECTORS.values():
        a, b = detect(rec, detector), detect(turned, detector)
        np.testing.assert_allclose(a.statistic, b.statistic, rtol=1e-9, atol=1e-12, equal_nan=True)


def test_the_statistic_after_a_long_time_is_as_exact_as_at_the_start():
    """A sum that runs along with the window must not drift, even past a sample of enormous size."""
    short = recording(n=400)
    accel = np.concatenate([np.full((1, 3), 1e9), np.tile(short.accel, (50, 1))])
    gyro = np.concatenate([np.zeros((1, 3)), np.tile(short.gyro, (50, 1))])
    rec = Recording(np.arange(len(accel)) / 100, accel, gyro)
    for detector in (AdaptiveShoe(), Shoe()):
        length = window_length(detector.window, 100.0)
        tail = detect(rec, detector).statistic[-400 + length : -length]
        expected = shoe_statistic(
            short, length, detector.accel_std, detector.gyro_std, Config().gravity
        )
        np.testing.assert_allclose(tail, expected[length:-length], rtol=1e-9)


@pytest.mark.parametrize("start", [0.0, 1.7e9])
@pytest.mark.parametrize("detector", DETECTORS.values(), ids=DETECTORS)
def test_track_stops_the_foot_where_the_detector_says(detector, start):
    """Stamps since 1970 make 199.995 Hz of 200, but the length of the window is the same."""
    noise = np.random.default_rng(2).normal(size=(2, 1200, 3))
    motion = (
        np.clip(np.sin(np.arange(1200) / 20), 0, None)[:, None] * (np.arange(1200) > 400)[:, None]
    )
    rec = Recording(
        start + np.arange(1200) / 200,
        [0.0, 0.0, Config().gravity] + (0.01 + motion) * noise[0],
        (0.001 + 0.3 * motion) * noise[1],
    )
    states, decision = track(rec, Config(detector=detector)), detect(rec, detector).decision
    aligned = (states.flags & Flag.ALIGNING) == 0
    assert 0 < decision[aligned].sum() < aligned.sum()
    np.testing.assert_array_equal(states.zero_velocity[aligned], decision[aligned])


@pytest.mark.filterwarnings("ignore::footnav.FootnavWarning")
@pytest.mark.parametrize("detector", DETECTORS.values(), ids=DETECTORS)
def test_any_chunking_gives_the_same_states_to_the_bit(detector):
    rec = recording(n=600)
    navigator = Navigator(Config(detector=detector), 100.0)
    parts, start = [], 0
    for size in itertools.cycle((1, 7, 0, 64, 3)):
        at = slice(start, start + size)
        parts.append(navigator.push_block(rec.t[at], rec.accel[at], rec.gyro[at]))
        start += size
        if start >= len(rec):
            break
    assert sum(map(len, parts)) == len(rec) - navigator.latency
    states, batch = (
        Trajectory.concatenate([*parts, navigator.flush()]),
        track(rec, Config(detector=detector)),
    )
    np.testing.assert_array_equal(states.position, batch.position)
    np.testing.assert_array_equal(states.zero_velocity, batch.zero_velocity)


@pytest.mark.parametrize("detector", DETECTORS.values(), ids=DETECTORS)
def test_samples_too_large_to_square_are_never_stance(detector):
    """Sums that overflow are not finite and never count as small; a recording rejects them."""
    rec, config = recording(n=60), Config(detector=detector).to_json()
    shaken, turned = rec.accel.copy(), rec.gyro.copy()
    shaken[20:40] = turned[20:40] = 1e200
    shaken[20:40:2] = -1e200
    both = _core.detect(config, rec.rate_hz, rec.t, shaken, turned)
    assert not both["decision"][20:40].any()
    force_alone = _core.detect(config, rec.rate_hz, rec.t, shaken, np.zeros_like(turned))
    assert force_alone["decision"][20:40].any() == isinstance(detector, AngularRateEnergy)


@pytest.mark.filterwarnings("ignore::footnav.FootnavWarning")
@pytest.mark.parametrize("detector", DETECTORS.values(), ids=DETECTORS)
def test_real_walks_close_with_the_default_settings(detector, data_dir):
    """OpenShoe's walks of about 79 m end where they began."""
    closing = []
    for path in sorted((data_dir / "openshoe").glob("*.npz")):
        with np.load(path) as file:
            position = track(
                Recording(file["t"], file["accel"], file["gyro"]), Config(detector=detector)
            ).position
        closing.append(np.linalg.norm(position[-1, :2] - position[0, :2]))
    assert len(closing) == 7
    assert np.median(closing) < 0.3
