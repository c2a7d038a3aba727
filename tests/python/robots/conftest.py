"""The robots under test and the published descriptions that they are compared with."""

from importlib.metadata import distribution
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def robots() -> Path:
    """Our robots' folder."""
    return Path(__file__).parents[3] / "robots"


@pytest.fixture(scope="session")
def published() -> Path:
    """The folder of robots of example-robot-data, which has no module to import."""
    files = distribution("example-robot-data").files or []
    urdf = next(file for file in files if file.parts[-2:] == ("robots", "tiago.urdf"))
    return Path(str(urdf.locate())).resolve().parents[2]
