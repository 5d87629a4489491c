"""Shared fixtures."""

import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def data_dir() -> Path:
    """Folder of the real recordings, or a skip that says how to provide them."""
    folder = os.environ.get("FOOTNAV_DATA")
    if not folder:
        pytest.skip("FOOTNAV_DATA is unset: it names the folder with the real recordings")
    path = Path(folder)
    assert path.is_dir(), f"FOOTNAV_DATA={folder} is not a folder"
    return path
