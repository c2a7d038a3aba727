"""The example and what is learned from it, in folders in which commands are typed."""

import pytest
from cli.command_line import run


@pytest.fixture
def empty_folder(tmp_path, monkeypatch):
    """The working directory, with nothing in it."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def folder(empty_folder):
    """A folder with the example, as the working directory."""
    run("example", "reach", ".")
    return empty_folder


@pytest.fixture(scope="module")
def learned(tmp_path_factory):
    """A folder with the example and its skill, which the tests of a module share."""
    folder = tmp_path_factory.mktemp("reach")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        run("example", "reach", ".")
        run("learn", "recorded", "-o", "skill.npz")
    return folder
