"""Fixtures for all tests."""

import functools
import os
from pathlib import Path

import hypothesis
import pytest
import typer.testing
from motions import arm

hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None)
hypothesis.settings.load_profile("repeatable")

# The tests run hundreds of command lines in one process: its commands are put together once.
typer.testing._get_command = functools.cache(typer.testing._get_command)


@pytest.fixture(scope="session")
def panda():
    return arm("panda")


@pytest.fixture(scope="session")
def recordings() -> Path:
    """The folder of real robot recordings; the test is skipped where there is none."""
    beside_the_project = Path(__file__).parents[3] / "shared" / "data"
    folder = Path(os.environ.get("LEADTHROUGH_DATA", beside_the_project))
    if not folder.is_dir():
        pytest.skip(f"no recordings at {folder}; LEADTHROUGH_DATA may name their folder")
    return folder
