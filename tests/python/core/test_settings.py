"""Settings are declared once, in the core: generated files are current, the limits hold."""

import json
import re
from typing import get_args

import pytest

import footnav
import generate_settings
from footnav import Config, _core, sections
from footnav.detectors import Detector
from footnav.errors import ConfigError
from footnav.settings import by_kind, decode

SCHEMA = json.loads(_core.settings_schema())
GENERATED = generate_settings.generated()
DETECTORS = by_kind(get_args(Detector))


def class_of(section):
    """Return the class of a section of the schema."""
    if section["kind"] is not None:
        return DETECTORS[section["kind"]]
    return getattr(sections, generate_settings.class_name(section))


def title(section):
    """Return a name for a section in the names of tests."""
    return section["kind"] or section["name"]


SECTIONS = pytest.mark.parametrize("section", SCHEMA, ids=list(map(title, SCHEMA)))


@pytest.mark.parametrize("path", list(GENERATED), ids=lambda path: path.name)
def test_generated_files_are_up_to_date(path):
    assert path.read_text(encoding="utf-8") == GENERATED[path], "run `make settings`, and commit"


def test_every_section_and_every_detector_is_there():
    declared = [section["name"] for section in SCHEMA]
    assert tuple(dict.fromkeys(declared)) == Config.__struct_fields__
    assert [s["kind"] for s in SCHEMA if s["name"] == "detector"] == list(DETECTORS)


@SECTIONS
def test_every_setting_is_described(section):
    assert section["doc"].endswith(".")
    for setting in section["settings"]:
        assert re.fullmatch(r"[A-Z].*\.", setting["doc"], re.DOTALL), setting["name"]
        assert setting["limits"] or "number" not in str(setting["value"]), setting["name"]


@SECTIONS
def test_defaults_are_those_of_the_core(section):
    kind = {} if section["kind"] is None else {"kind": section["kind"]}
    defaults = {setting["name"]: setting["default"] for setting in section["settings"]}
    assert decode(json.dumps(kind | defaults), class_of(section)) == class_of(section)()


def outside(limits):
    """Return numbers just outside limits, which are given as text."""
    numbers = [float(number) for number in re.findall(r"-?\d[\d.e-]*", limits)]
    if limits.startswith("between"):
        lowest, highest = numbers
        margin = 1e-6 * (highest - lowest)
        return [lowest - margin, highest + margin]
    if limits.startswith("at least"):
        return [numbers[0] - 1e-6]
    return {"a positive number": [0.0, -1.0], "zero or a positive number": [-1e-9]}[limits]


def every_limit():
    """Yield section, name, value and limits for values that are just outside the limits."""
    for section in SCHEMA:
        for setting in section["settings"]:
            if setting["limits"] not in (None, "a finite number"):
                for value in outside(setting["limits"]):
                    name = f"{title(section)}.{setting['name']}={value}"
                    yield pytest.param(section, setting, value, id=name)


@pytest.mark.parametrize(("section", "setting", "value"), list(every_limit()))
def test_a_value_outside_the_limits_is_refused_with_them(section, setting, value):
    key = re.escape(f"{section['name']}.{setting['name']}")
    expected = re.escape(f"expected {setting['limits']}")
    with pytest.raises(ConfigError, match=f"^{key} = .*: {expected}"):
        Config(**{section["name"]: class_of(section)(**{setting["name"]: value})})


@pytest.mark.parametrize("kind", DETECTORS)
def test_every_detector_decides_on_a_walk_with_the_latency_that_it_announces(kind):
    recording, _ = footnav.simulate([[0, 0], [8, 0]], sensor="ideal", seed=1)
    decision = footnav.detect(recording, kind).decision
    assert 0.02 < decision.mean() < 0.98
    config = Config(detector=DETECTORS[kind]())
    navigator = footnav.Navigator(config, rate_hz=recording.rate_hz)
    states = navigator.push_block(recording.t, recording.accel, recording.gyro)
    assert len(states) == len(recording) - navigator.latency
    assert len(states) + len(navigator.flush()) == len(recording)
