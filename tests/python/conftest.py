"""Shared fixtures."""

import os
import signal
from functools import partial
from pathlib import Path

import pytest

from command_line import Run, run_in_process


@pytest.fixture(scope="session", autouse=True)
def _interrupts_are_enabled() -> None:
    """Enable Ctrl-C in background jobs of a script, whose shell ignores it."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """Folder of the real recordings, or a skip with instructions."""
    folder = os.environ.get("FOOTNAV_DATA")
    if not folder:
        pytest.skip("FOOTNAV_DATA is unset: it names the folder with the real recordings")
    path = Path(folder)
    assert path.is_dir(), f"FOOTNAV_DATA={folder} is not a folder"
    return path


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run commands in an empty folder."""
    monkeypatch.chdir(tmp_path)
    return partial(run_in_process, capsys)
