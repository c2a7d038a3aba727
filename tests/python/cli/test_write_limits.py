"""`leadthrough info --write-limits`: limits to begin with, which say what is assumed."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from cli.command_line import run

import leadthrough as lt

SLIDER = """<robot name="lift"><link name="a"/><link name="b"/><link name="c"/>
<joint name="up" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="0" upper="1" velocity="0.1" effort="100"/></joint>
<joint name="turn" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/>
</joint></robot>"""


@pytest.fixture
def folder(empty_folder):
    """A folder with a URDF without accelerations and jerks, as the working directory."""
    Path("lift.urdf").write_text(SLIDER)
    return empty_folder


def test_the_file_completes_the_urdf_and_says_what_is_assumed(folder):
    run("info", "lift.urdf", "--write-limits", "lift.toml")
    limits = lt.Arm.from_urdf("lift.urdf", limits="lift.toml").limits
    # Full speed after 0.5 s, at most 5 rad/s^2; full acceleration after 0.05 s.
    np.testing.assert_allclose(limits.acceleration, [0.2, 5.0])
    np.testing.assert_allclose(limits.jerk, [4.0, 100.0])
    np.testing.assert_allclose(limits.velocity, [0.1, np.inf])
    text = Path("lift.toml").read_text()
    assert "assumed" in text.split("[sources]")[0].lower()
    sources = tomllib.loads(text)["sources"]
    assert all(sources[name].startswith("assumed: ") for name in ("acceleration", "jerk"))
    assert "0.5 s" in sources["acceleration"]


def test_what_is_known_is_kept(folder):
    given = "[joints]\nup = { acceleration = 0.7 }\nturn = { acceleration = 7.0 }\n"
    Path("given.toml").write_text(given)
    run("info", "lift.urdf", "--limits", "given.toml", "--write-limits", "lift.toml")
    limits = lt.Arm.from_urdf("lift.urdf", limits="lift.toml").limits
    np.testing.assert_allclose(limits.acceleration, [0.7, 7.0])
    np.testing.assert_allclose(limits.jerk, [14.0, 140.0])
    assert tomllib.loads(Path("lift.toml").read_text())["sources"]["acceleration"] == "as given"


def test_a_file_that_is_there_is_not_overwritten(folder):
    Path("lift.toml").write_text("mine")
    result = run("info", "lift.urdf", "--write-limits", "lift.toml", code=2)
    assert "--write-limits: lift.toml is there already" in result.stderr
    assert Path("lift.toml").read_text() == "mine"


def test_limits_are_written_for_one_urdf(folder):
    for files in (["lift.urdf", "lift.urdf"], ["lift.csv"]):
        result = run("info", *files, "--write-limits", "lift.toml", code=2)
        assert "--write-limits: expected one URDF" in result.stderr


def test_the_profile_of_the_robot_names_its_links_and_may_name_the_file_to_write(folder):
    profile = 'robot = "lift.urdf"\ntip = "b"\nlimits = "lift.toml"\n'
    Path("leadthrough.toml").write_text(profile)
    run("info", "lift.urdf", "--write-limits", "lift.toml")
    assert set(tomllib.loads(Path("lift.toml").read_text())["joints"]) == {"up"}
    assert "lift: from a to b" in run("info", "lift.urdf").stdout
    assert "lift: from a to c" in run("--no-profile", "info", "lift.urdf").stdout
