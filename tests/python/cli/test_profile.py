"""`leadthrough.toml`: options that all commands take in a folder."""

from pathlib import Path

import pytest
from cli.command_line import facts, run

PROFILE = Path("leadthrough.toml")


def test_commands_take_the_arm_from_the_profile(folder):
    with_options = ("--robot", "ur3.urdf", "--tip", "tool0", "--limits", "ur3.toml")
    told = facts("check", "recorded/reach1.csv", code=1)  # the recording shakes
    assert told == facts("--no-profile", "check", "recorded/reach1.csv", *with_options, code=1)
    missing = run("--no-profile", "check", "recorded/reach1.csv", code=2)
    assert "Missing option '--robot'" in missing.stderr


def test_an_option_on_the_command_line_wins(folder):
    assert (
        "none.toml" in run("check", "recorded/reach1.csv", "--limits", "none.toml", code=2).stderr
    )
    PROFILE.write_text('robot = "panda"')
    assert facts("check", "recorded/reach1.csv", "--robot", "ur3", code=1)["clear"]


def test_another_robot_leaves_the_profiles_links_and_limits_out(folder):
    assert facts("check", "recorded/reach1.csv", "--robot", "ur3", code=1)["clear"]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('robto = "ur3"', "leadthrough.toml: robto: unknown key; the keys are robot, base"),
        ("robot = 3", "leadthrough.toml: robot: expected a text in quotes, got 3"),
        ('tip = "tool0"', "leadthrough.toml: tip: only used with robot"),
        ("robot = ", "leadthrough.toml: not a TOML document"),
        ('robot = "r2d2"', "leadthrough.toml: robot: expected one of the robots"),
        ('robot = "none.urdf"', "leadthrough.toml: robot: expected a URDF or its path"),
        ('robot = "ur3.urdf"\nlimits = "none.toml"', "leadthrough.toml: limits: "),
        ('robot = "ur3.urdf"\ntip = "nose"', "leadthrough.toml: tip: "),
        ('robot = "ur3.urdf"\nbase = "foot"', "leadthrough.toml: base: "),
        ('robot = "ur3.urdf"\nmesh_folder = "no"', "leadthrough.toml: mesh_folder: expected"),
    ],
)
def test_errors_name_the_file_and_the_key(folder, text, says):
    PROFILE.write_text(text)
    assert f"leadthrough: {says}" in run("check", "recorded/reach1.csv", code=2).stderr


def test_help_and_commands_without_a_robot_need_no_sound_profile(folder):
    PROFILE.write_text("nonsense")
    run("check", "--help")
    run("clean", "recorded/reach1.csv", "-o", "clean.csv")
    run("check", "recorded/reach1.csv", code=2)
