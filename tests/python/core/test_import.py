"""Importing costs what is used."""

import ast
import pickle
import subprocess
import sys
from pathlib import Path

import pytest

import footnav

pytestmark = pytest.mark.slow

NEEDED = {"msgspec", "numpy"}
TERMINAL = {"cyclopts", "rich"}
OTHERS = {"gpxpy", "matplotlib", "pyarrow", "pymap3d", "scipy", "serial", "smbus2", "yaml"}
POOLS = {"concurrent.futures.process", "concurrent.futures.thread", "multiprocessing"}
STUB = ast.parse(Path(footnav.__file__).with_suffix(".pyi").read_text(encoding="utf-8"))


def loaded_by(program: str, *arguments: str) -> set[str]:
    """Run a program in an interpreter of its own and return the modules that it loaded."""
    script = f"import sys\n{program}\nprint(*sys.modules)"
    command = [sys.executable, "-c", script, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return set(done.stdout.splitlines()[-1].split())


def test_import_of_the_package_loads_no_other_module():
    loaded = loaded_by("import footnav")
    assert not loaded & (NEEDED | TERMINAL | OTHERS | POOLS)
    assert [module for module in loaded if module.startswith("footnav")] == ["footnav"]


@pytest.mark.parametrize(
    "program",
    [
        "import footnav; footnav.read, footnav.track, footnav.Config.preset('mpu6050')",
        "import footnav; footnav.Navigator(rate_hz=100).push(0, 0, 0, 9.8, 0, 0, 0)",
        "import footnav; footnav.track(footnav.simulate([[0, 0], [3, 0]], seed=1)[0])",
    ],
    ids=["read and track", "stream", "simulate"],
)
def test_navigation_loads_numpy_and_msgspec(program):
    assert loaded_by(program) & (NEEDED | TERMINAL | OTHERS | POOLS) == NEEDED


@pytest.mark.parametrize("arguments", [["--help"], ["track", "--help"], ["track", "absent.csv"]])
def test_a_command_loads_no_library_that_it_does_not_use(arguments):
    program = "from footnav.cli import main\ntry: main()\nexcept SystemExit: pass"
    assert loaded_by(program, *arguments) & (NEEDED | TERMINAL | OTHERS) == NEEDED | TERMINAL


def test_the_names_of_the_stub_exist():
    (offered,) = (
        ast.literal_eval(line.value) for line in STUB.body if isinstance(line, ast.Assign)
    )
    assert offered == footnav.__all__
    assert set(offered) <= set(dir(footnav))
    for name in dir(footnav):
        assert getattr(footnav, name) is not None


def test_a_function_is_not_mistaken_for_the_module_of_the_same_name():
    for first in (
        "import footnav.allan",
        "from footnav.allan import AllanDeviation",
        "import footnav.plot",
    ):
        loaded_by(f"import footnav; {first}; footnav.allan.__call__")


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="nearst"):
        _ = footnav.nearst


@pytest.mark.parametrize("kind", [footnav.Config, footnav.Recording, footnav.errors.BusyError])
def test_names_travel_to_other_processes(kind):
    assert pickle.loads(pickle.dumps(kind)) is kind
