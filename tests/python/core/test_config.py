"""Settings: the core's defaults, rejection of invalid keys and values, and files."""

import re
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import get_args

import msgspec
import numpy as np
import pytest
import tomli_w
from hypothesis import given, settings
from hypothesis import strategies as st

import footnav
from footnav import Config, _core, load_config
from footnav.config import (
    Alignment,
    Calibration,
    Filter,
    HealthLimits,
    Mechanization,
    Output,
    Sensor,
)
from footnav.detectors import AdaptiveShoe, Detector, MagnitudeVariance, Shoe
from footnav.errors import ConfigError, FootnavError
from footnav.settings import by_kind

PRESETS = ("mpu6050", "mti-g710", "stim300", "ngimu", "vn100")
DETECTORS = by_kind(get_args(Detector))
SECTIONS = {
    name: type(getattr(Config(), name)) for name in Config.__struct_fields__ if name != "detector"
}


def written(folder, text):
    """Return the path of a TOML file with this text."""
    path = folder / "shoe.toml"
    path.write_text(text)
    return path


def every_field():
    """Yield section, the lines that open it in TOML, and field, for every setting that there is."""
    for section, kind in SECTIONS.items():
        for field in kind.__struct_fields__:
            yield section, f"[{section}]\n", field
    for tag, kind in DETECTORS.items():
        for field in kind.__struct_fields__:
            yield "detector", f'[detector]\nkind = "{tag}"\n', field


FIELDS = [
    pytest.param(*field, id=f"{field[0]}.{field[2]}-{i}") for i, field in enumerate(every_field())
]


def test_defaults_are_those_of_the_core():
    assert msgspec.json.decode(_core.default_config()) == msgspec.json.decode(
        msgspec.json.encode(Config())
    )


@pytest.mark.parametrize("tag", DETECTORS)
def test_default_detectors_are_those_of_the_core(tag, tmp_path):
    path = written(tmp_path, f'[detector]\nkind = "{tag}"\n')
    assert load_config(path).detector == DETECTORS[tag]()


def test_an_empty_file_gives_the_defaults(tmp_path):
    assert load_config(written(tmp_path, "")) == Config()


def test_every_section_is_immutable():
    config = Config()
    for section in Config.__struct_fields__:
        with pytest.raises(AttributeError):
            setattr(config, section, None)
        field = getattr(config, section).__struct_fields__[0]
        with pytest.raises(AttributeError):
            setattr(getattr(config, section), field, 1.0)


def test_equal_settings_are_equal_and_hash_alike():
    assert Config(filter=Filter(rest_rate=0.1)) == Config(filter=Filter(rest_rate=0.1)) != Config()
    assert hash(Config()) == hash(Config())


def test_nested_replace_leaves_the_original_alone():
    config = Config()
    changed = config.replace(alignment=config.alignment.replace(heading_deg=90.0))
    assert changed.alignment.heading_deg == 90.0
    assert changed.replace(alignment=config.alignment) == config == Config()


def test_replaced_settings_reach_the_core():
    config = Config()
    assert b'"gyro_range": null' in config.to_json()
    changed = config.replace(sensor=config.sensor.replace(gyro_range=30.0))
    assert b'"gyro_range": 30.0' in changed.to_json()
    assert b'"gyro_range": null' in config.to_json()


def test_replace_checks_the_values_again():
    with pytest.raises(ConfigError, match=r"filter\.rest_rate = -1"):
        Config().replace(filter=Config().filter.replace(rest_rate=-1.0))


@pytest.mark.parametrize("section", [*Config.__struct_fields__, None])
def test_replace_names_an_unknown_setting_and_the_nearest(section):
    target = getattr(Config(), section) if section else Config()
    known = target.__struct_fields__[0]
    with pytest.raises(ConfigError, match=f"'{known}x'.*did you mean '{known}'"):
        target.replace(**{known + "x": 1.0})


@pytest.mark.parametrize(("section", "opening", "field"), FIELDS)
def test_a_misspelt_key_is_named_with_the_file_and_the_nearest_known_one(
    section, opening, field, tmp_path
):
    misspelt = field[0] + field[2:]
    path = written(tmp_path, f"{opening}{misspelt} = 1.0\n")
    with pytest.raises(ConfigError) as error:
        load_config(path)
    for part in (str(path), f"{section}.{misspelt}", f"did you mean '{field}'"):
        assert part in str(error.value)


def test_a_misspelt_section_is_named_with_the_file_and_the_nearest_known_one(tmp_path):
    path = written(tmp_path, "[fliter]\nrest_rate = 0.1\n")
    with pytest.raises(ConfigError) as error:
        load_config(path)
    for part in (str(path), "'fliter'", "did you mean 'filter'"):
        assert part in str(error.value)


@pytest.mark.parametrize(("section", "opening", "field"), FIELDS)
def test_a_value_of_the_wrong_type_is_named(section, opening, field, tmp_path):
    path = written(tmp_path, f"{opening}{field} = 1979-05-27\n")
    with pytest.raises(ConfigError) as error:
        load_config(path)
    assert str(error.value).startswith(f"{path}: {section}.{field}: ")


@pytest.mark.parametrize(
    "text",
    [
        "filter = 3",
        "detector = 'shoe'",
        "[detector]\nkind = 3",
        "[detector]\nkind = ['shoe']",
        "[detector.kind]\nshoe = 1",
        "[filter.rest_rate]\nvalue = 1.0",
        "output.origin = { latitude = 45.0 }",
        "[mechanization]\nkind = ['two-sample']",
        "[calibration]\naccel_matrix = [[1.0, 0.0], [0.0, 1.0]]",
        "[calibration]\ngyro_bias = [0.0, 0.0, 0.0, 0.0]",
        "[filter",
        "[filter]\nrest_rate = 0.1\nrest_rate = 0.2",
    ],
)
def test_a_malformed_file_is_a_config_error_that_names_it(text, tmp_path):
    path = written(tmp_path, text)
    with pytest.raises(ConfigError) as error:
        load_config(path)
    assert str(error.value).startswith(f"{path}: ")


@pytest.mark.parametrize("content", [b"\xff\xfe", b"\x00", b"a = \xc3\x28"])
def test_a_binary_file_is_a_config_error_that_names_it(content, tmp_path):
    path = tmp_path / "shoe.toml"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match=r"shoe\.toml: not a TOML file"):
        load_config(path)


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(ConfigError, match=r"none\.toml: No such file"):
        load_config(tmp_path / "none.toml")
    with pytest.raises(ConfigError, match="directory"):
        load_config(str(tmp_path))


OUT_OF_RANGE = [
    ("sensor", Sensor, {"gyro_noise_density": -1.0}),
    ("sensor", Sensor, {"accel_bias_std": -0.1}),
    ("sensor", Sensor, {"gyro_range": 0.0}),
    ("sensor", Sensor, {"gyro_scale_std": -0.01}),
    ("sensor", Sensor, {"accel_scale_std": 0.2}),
    ("filter", Filter, {"zupt_correlation": 1.1}),
    ("filter", Filter, {"covariance_interval": 0.2}),
    ("sensor", Sensor, {"accel_range": -16.0}),
    ("calibration", Calibration, {"accel_matrix": ((0.0,) * 3,) * 3}),
    (
        "calibration",
        Calibration,
        {"gyro_matrix": ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0))},
    ),
    ("alignment", Alignment, {"duration": 0.0}),
    ("alignment", Alignment, {"rest_gyro_std": -1.0}),
    ("alignment", Alignment, {"tilt_std": -0.01}),
    ("mechanization", Mechanization, {"gravity": -9.8}),
    ("mechanization", Mechanization, {"latitude_deg": 90.5}),
    ("mechanization", Mechanization, {"height": 1e9}),
    ("detector", AdaptiveShoe, {"window": 0.0}),
    ("detector", AdaptiveShoe, {"min_factor": 0.5}),
    ("detector", AdaptiveShoe, {"look_ahead": -0.1}),
    ("detector", AdaptiveShoe, {"max_fraction": 1.1}),
    ("detector", AdaptiveShoe, {"accel_std": 0.0}),
    ("detector", Shoe, {"threshold": -1.0}),
    ("detector", Shoe, {"gyro_std": 0.0}),
    ("detector", MagnitudeVariance, {"magnitude_gate": 0.0}),
    ("detector", MagnitudeVariance, {"variance_gate": -1.0}),
    ("filter", Filter, {"zero_velocity_std": 0.0}),
    ("filter", Filter, {"clipped_noise_factor": -1.0}),
    ("filter", Filter, {"contact_rate": -1.0}),
    ("filter", Filter, {"rest_duration": -0.5}),
    ("health", HealthLimits, {"gap_intervals": 0.5}),
    ("health", HealthLimits, {"degraded_after": -1.0}),
    ("output", Output, {"origin": (91.0, 0.0, 0.0)}),
]


@pytest.mark.parametrize(("section", "kind", "setting"), OUT_OF_RANGE)
def test_a_value_out_of_range_is_named_with_what_was_expected(section, kind, setting):
    with pytest.raises(ConfigError, match="expected") as error:
        Config(**{section: kind(**setting)})
    assert f"{section}.{next(iter(setting))}" in str(error.value)


@pytest.mark.parametrize(("section", "kind", "setting"), OUT_OF_RANGE)
def test_a_file_with_a_value_out_of_range_is_named(section, kind, setting, tmp_path):
    tag = next((f'kind = "{tag}"\n' for tag, choice in DETECTORS.items() if choice is kind), "")
    path = written(tmp_path, f"[{section}]\n{tag}" + tomli_w.dumps(msgspec.to_builtins(setting)))
    with pytest.raises(ConfigError) as error:
        load_config(path)
    assert str(error.value).startswith(f"{path}: {section}.{next(iter(setting))}")


@pytest.mark.parametrize("value", ["nan", "inf", "-inf"])
@pytest.mark.parametrize(("section", "opening", "field"), FIELDS)
def test_no_setting_may_be_other_than_finite(section, opening, field, value, tmp_path):
    """Least of all those that may be absent: a heading of nan is not the same as no heading."""
    path = written(tmp_path, f"{opening}{field} = {value}\n")
    with pytest.raises(ConfigError, match=rf"shoe\.toml: {section}"):
        load_config(path)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_a_value_that_is_not_finite_is_shown(value):
    with pytest.raises(ConfigError, match=rf"filter\.rest_rate.*(?i:{value})"):
        Config(filter=Filter(rest_rate=value))


@pytest.mark.parametrize(
    ("settings", "both"),
    [
        (
            {"alignment": Alignment(heading_deg=1.0, magnetic_field=(1.0, 0.0, 0.0))},
            ("heading_deg", "magnetic_field"),
        ),
        ({"mechanization": Mechanization(earth_rate=True)}, ("earth_rate", "heading_deg")),
        (
            {"health": HealthLimits(degraded_after=20.0, invalid_after=10.0)},
            ("invalid_after", "degraded_after"),
        ),
    ],
)
def test_settings_at_odds_are_both_named(settings, both):
    with pytest.raises(ConfigError) as error:
        Config(**settings)
    assert all(name in str(error.value) for name in both)


@pytest.mark.parametrize(
    "alignment", [Alignment(heading_deg=0.0), Alignment(magnetic_field=(1.0, 0.0, 0.0))]
)
def test_earth_rate_is_allowed_once_north_is_known(alignment):
    assert Config(
        alignment=alignment, mechanization=Mechanization(earth_rate=True)
    ).mechanization.earth_rate


def test_a_misspelt_detector_names_the_known_ones_and_the_nearest(tmp_path):
    path = written(tmp_path, '[detector]\nkind = "adaptive-sho"\n')
    with pytest.raises(ConfigError) as error:
        load_config(path)
    for part in (
        str(path),
        "detector.kind",
        "'adaptive-sho'",
        *DETECTORS,
        "did you mean 'adaptive-shoe'",
    ):
        assert part in str(error.value)


def test_settings_of_another_detector_are_refused(tmp_path):
    with pytest.raises(ConfigError, match=r"detector\.min_factor"):
        load_config(written(tmp_path, '[detector]\nkind = "shoe"\nmin_factor = 2.0\n'))


def test_a_numpy_float_is_a_float():
    assert Config(alignment=Alignment(heading_deg=np.float64(90.0))) == Config(
        alignment=Alignment(heading_deg=90.0)
    )


def test_a_value_that_is_no_setting_is_a_config_error():
    with pytest.raises(ConfigError):
        Config(output=Output(origin=object()))


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_changes_the_sensor_alone_and_survives_a_file(name, tmp_path):
    preset = Config.preset(name)
    assert preset.sensor != Sensor()
    assert preset.replace(sensor=Sensor()) == Config()
    preset.save(tmp_path / "preset.toml")
    assert load_config(tmp_path / "preset.toml") == preset


def test_live_is_the_default_detector_looking_less_far_ahead(tmp_path):
    live = AdaptiveShoe.live()
    assert live == AdaptiveShoe(look_ahead=live.look_ahead, max_fraction=live.max_fraction)
    assert live.look_ahead < AdaptiveShoe().look_ahead
    config = Config.preset("mpu6050").replace(detector=live)
    config.save(tmp_path / "live.toml")
    assert load_config(tmp_path / "live.toml") == config


def test_the_example_of_the_guide_is_live():
    guide = Path(__file__).parents[3] / "docs" / "accuracy.md"
    (example,) = re.findall(
        r"```python run\n(.*?)```", guide.read_text(encoding="utf-8"), re.DOTALL
    )
    names = {}
    exec(example, names)
    assert names["navigator"].config.detector == AdaptiveShoe.live()


def test_an_unknown_preset_names_the_known_ones():
    with pytest.raises(ConfigError) as error:
        Config.preset("mpu9250")
    assert all(name in str(error.value) for name in ("mpu9250", *PRESETS))


positive = st.floats(1e-6, 1e3)
at_least_zero = st.one_of(st.just(0.0), positive)
vectors = st.tuples(*[st.floats(-10.0, 10.0)] * 3)
near_identity = st.tuples(*[st.floats(-0.05, 0.05)] * 9).map(
    lambda e: tuple(tuple(float(i == j) + e[3 * i + j] for j in range(3)) for i in range(3))
)
windows = st.floats(0.01, 0.5)

sensors = st.builds(
    Sensor,
    gyro_noise_density=positive,
    accel_noise_density=positive,
    gyro_bias_std=positive,
    gyro_scale_std=st.floats(0.0, 0.1),
    accel_scale_std=st.floats(0.0, 0.1),
    gyro_range=st.none() | positive,
    accel_range=st.none() | positive,
)
calibrations = st.builds(
    Calibration,
    accel_matrix=near_identity,
    accel_bias=vectors,
    gyro_matrix=near_identity,
    gyro_bias=vectors,
)
alignments = st.builds(
    Alignment,
    duration=st.floats(0.1, 10.0),
    levelling=st.sampled_from(["arctangent", "arcsine"]),
    heading_deg=st.floats(-360.0, 360.0),
    declination_deg=st.floats(-90.0, 90.0),
    forward_axis=st.sampled_from(["x", "y", "z", "-x", "-y", "-z"]),
) | st.builds(Alignment, magnetic_field=vectors.filter(lambda v: max(map(abs, v)) > 0.1))
mechanizations = st.builds(
    Mechanization,
    kind=st.sampled_from(["two-sample", "single-sample", "first-order"]),
    earth_rate=st.booleans(),
    gravity=st.none() | st.floats(9.7, 9.9),
    latitude_deg=st.none() | st.floats(-90.0, 90.0),
    height=st.none() | st.floats(-400.0, 9000.0),
).filter(lambda settings: settings.kind != "first-order" or not settings.earth_rate)
detectors = st.one_of(
    st.builds(
        AdaptiveShoe,
        window=windows,
        look_behind=windows,
        min_factor=st.floats(1.0, 10.0),
        noise_floor=positive,
    ),
    st.builds(Shoe, window=windows, accel_std=positive, gyro_std=positive, threshold=positive),
    st.builds(MagnitudeVariance, window=windows, magnitude_gate=positive, variance_gate=positive),
)
filters = st.builds(
    Filter,
    zero_velocity_std=positive,
    zupt_lever_std=st.floats(0.0, 0.2),
    zupt_correlation=st.floats(0.0, 1.0),
    covariance_interval=st.floats(0.0, 0.1),
    contact_rate=st.floats(0.0, 5.0),
    zero_angular_rate=st.booleans(),
)
limits = st.builds(
    HealthLimits, degraded_after=st.floats(0.1, 5.0), invalid_after=st.floats(5.0, 60.0)
)
outputs = st.builds(
    Output,
    origin=st.none()
    | st.tuples(st.floats(-89.0, 89.0), st.floats(-180.0, 180.0), st.floats(-400.0, 9000.0)),
    frame=st.sampled_from(["enu", "ned"]),
)
configs = st.builds(
    Config,
    sensor=sensors,
    calibration=calibrations,
    alignment=alignments,
    mechanization=mechanizations,
    detector=detectors,
    filter=filters,
    health=limits,
    output=outputs,
)


@given(configs)
@settings(max_examples=50, deadline=None)
def test_any_settings_survive_a_file(config):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "shoe.toml"
        config.save(path)
        assert load_config(path) == config


def test_a_save_that_fails_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "shoe.toml"
    Config().save(path)
    before = path.read_bytes()

    def fail_halfway(settings, file):
        file.write(b"[sensor]\n")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tomli_w, "dump", fail_halfway)
    with pytest.raises(FootnavError, match=r"shoe\.toml.*No space left"):
        Config.preset("mpu6050").save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_save_replaces_the_old_file(tmp_path):
    path = tmp_path / "shoe.toml"
    path.write_text("old " * 10_000)
    Config().save(str(path))
    assert load_config(path) == Config()
    assert list(tmp_path.iterdir()) == [path]


def test_a_save_into_no_folder_names_the_path(tmp_path):
    with pytest.raises(FootnavError, match=r"shoe\.toml"):
        Config().save(tmp_path / "nowhere" / "shoe.toml")


def test_with_heading_from_takes_the_mean_field_of_the_rest():
    t = np.arange(300) / 100
    mag = np.where(t[:, None] <= 1.0, [2e-5, 0.0, -4e-5], [9e-5, 9e-5, 9e-5])
    still = np.tile([0.0, 0.0, 9.81], (300, 1))
    recording = footnav.Recording(t, still, np.zeros((300, 3)), mag)
    config = Config(alignment=Alignment(heading_deg=5.0)).with_heading_from(recording)
    assert config.alignment.heading_deg is None
    np.testing.assert_allclose(config.alignment.magnetic_field, [2e-5, 0.0, -4e-5], rtol=1e-12)


def test_threads_may_ask_for_the_first_preset_at_once():
    """In a separate process without earlier JSON conversions; a failure there ends the process."""
    program = """
import sys, threading, footnav
sys.setswitchinterval(1e-6)
together, presets = threading.Barrier(4), []
def ask():
    together.wait()
    presets.append(footnav.Config.preset("mpu6050"))
threads = [threading.Thread(target=ask) for _ in range(4)]
for thread in threads: thread.start()
for thread in threads: thread.join()
assert len(presets) == 4 and len(set(map(repr, presets))) == 1
"""
    for _ in range(3):
        subprocess.run([sys.executable, "-c", program], check=True)
