"""Obstacles that people met with their own arm and recordings, and the messages about them."""

import re
from pathlib import Path

import numpy as np
import pytest
from cli.command_line import facts, run, write_table
from so101 import TIP, URDF, motions, save
from urdfs import CUBE

import leadthrough as lt

MESHED = URDF.replace(
    '<sphere radius="0.03"/>', '<mesh filename="package://so_arm/meshes/arm/part.obj"/>'
)
PROFILE = f'robot = "arm.urdf"\ntip = "{TIP}"\nlimits = "arm.toml"\n'


@pytest.fixture
def folder(empty_folder):
    """An arm whose meshes lie elsewhere, and recordings whose columns are q1 to q5."""
    Path("arm.urdf").write_text(MESHED)
    Path("recordings").mkdir()
    for number, (q, _) in enumerate(motions()):
        rows = np.column_stack([0.03 * np.arange(len(q)), q])
        header = ",".join(["t", *(f"q{j + 1}" for j in range(5))])
        write_table(f"recordings/rec{number}.csv", header, rows)
    run("info", "arm.urdf", "--tip", TIP, "--write-limits", "arm.toml")
    return empty_folder


def said(result):
    return " ".join(result.output.split())


def test_the_links_that_may_be_the_tip_are_listed(folder):
    told = said(run("info", "arm.urdf", "--tip", TIP))
    assert "each of which may be the tip: base_link, shoulder_link, upper_arm_link" in told
    assert f"gripper_link, {TIP} reach" in told


def test_an_arm_with_its_gripper_is_told_to_name_the_link_before(folder):
    words = ("--robot", "arm.urdf", "--tip", "jaw_link", "-o", "a.npz")
    told = said(run("learn", "recordings", *words, code=2))
    assert "rec0: has 5 joints, and the arm from base_link to jaw_link has 6" in told
    assert "give the last link before it as --tip" in told


def test_missing_meshes_are_told_at_once_and_found_in_their_folder(folder):
    Path("leadthrough.toml").write_text(PROFILE)
    told = said(run("info", "arm.urdf"))
    assert "! 3 of 3 collision meshes are not where the URDF says, such as package://so_arm" in told
    wrong = said(run("check", "recordings/rec0.csv", code=2))
    assert "name its folder in --mesh-folder" in wrong
    Path("elsewhere/arm").mkdir(parents=True)  # without the folders before it
    Path("elsewhere/arm/part.obj").write_text(CUBE.replace("1", "0.05"))
    assert "collision meshes" not in said(run("info", "arm.urdf", "--mesh-folder", "elsewhere"))
    assert "clear" in facts("check", "recordings/rec0.csv", "--mesh-folder", "elsewhere", code=1)
    Path("leadthrough.toml").write_text(PROFILE + 'mesh_folder = "elsewhere"\n')
    assert "clear" in facts("check", "recordings/rec0.csv", code=1)


def test_a_skill_of_joints_says_why_an_offset_of_the_tool_does_not_fit(folder):
    run("learn", "recordings", "-o", "a.npz")
    told = said(run("plan", "a.npz", "--move-goal", "0.05,0,0.05", "-o", "a.csv", code=2))
    assert "--move-goal: expected 5 numbers, one for each joint" in told
    assert "with --robot, `leadthrough learn` learns poses of the tool" in told


def test_a_path_with_tremor_is_told_what_makes_it_faster(folder):
    words = ("retime", "recordings/rec0.csv", "--robot", "arm.urdf", "--tip", TIP)
    limited = (*words, "--limits", "arm.toml", "-o", "timed.json")
    exact = (*limited, "--path-tolerance", "1e-5")
    told = said(run(*exact))
    assert re.search(r"note: for \d+% of the time no limit binds", told)
    assert "a larger --path-tolerance, up to 1e-2, rounds them" in told
    smooth = run(*limited, "--path-tolerance", "1e-2")
    assert "note" not in smooth.output
    fastest = facts(*limited, "--path-tolerance", "1e-2")["duration"]
    default = facts(*limited)
    assert fastest < default["duration"] < facts(*exact)["duration"]
    assert default["smoothed"] == pytest.approx(5e-4, rel=0.2)  # as of so101.motions
    assert "smoothed" not in facts(*exact)


def test_a_motion_that_stands_still_is_its_one_sample(folder):
    header, first = Path("recordings/rec0.csv").read_text().splitlines()[:2]
    rows = "".join(f"{0.1 * i:.1f},{first.partition(',')[2]}\n" for i in range(20))
    Path("still.csv").write_text(f"{header}\n{rows}")
    arm = ("--robot", "arm.urdf", "--tip", TIP, "--limits", "arm.toml")
    found = facts("retime", "still.csv", *arm, "-o", "timed.csv")
    assert (found["samples"], found["duration"], found["limited_by"]) == (1, 0.0, [])


def test_a_data_set_in_an_unknown_unit_can_be_seen_once_the_unit_is_given(folder):
    episodes = [np.column_stack([np.degrees(q), opening]) for q, opening in motions()]
    save(Path("set"), episodes)
    told = run("info", "set", code=1)
    assert "set --angles degrees or --angles percent" in said(told)
    assert "next:" not in told.output  # the next command needs the unit, too
    words = ("view", "recordings/rec0.csv", "--robot", "arm.urdf", "--tip", TIP)
    shown = (*words, "--demonstrations", "set", "--html", "seen.html")
    assert "--angles" in run(*shown, code=2).stderr
    run(*shown, "--angles", "degrees")
    assert Path("seen.html").stat().st_size > 10_000


def test_the_example_is_an_arm_its_limits_a_profile_and_three_recordings(empty_folder):
    told = facts("example", "reach", "first")
    assert {str(path.relative_to("first")) for path in Path("first").rglob("*.*")} == {
        "leadthrough.toml",
        "ur3.urdf",
        "ur3.toml",
        *(f"recorded/reach{number}.csv" for number in (1, 2, 3)),
    }
    assert sorted(told["files"]) == sorted(
        str(path.relative_to("first")) for path in Path("first").rglob("*.*")
    )
    arm = lt.Arm.from_urdf("first/ur3.urdf", tip="tool0", limits="first/ur3.toml")
    shown = [lt.read_motion(path) for path in sorted(Path("first/recorded").iterdir())]
    for motion in shown:
        assert motion.joint_names == arm.joint_names
        assert lt.check_limits(motion, arm.limits).position.ratio < 1.0
        assert (motion.positions[0] == motion.positions[5]).all()  # the arm stands still at first
        assert (motion.positions[-1] == motion.positions[-5]).all()
    assert 0.002 < np.abs(shown[0].positions[0] - shown[1].positions[0]).max() < 0.1


def test_the_recordings_follow_from_the_seed(empty_folder):
    for name, seed in (("a", 0), ("b", 0), ("c", 1)):
        run("example", "reach", name, "--seed", seed)
    first, again, other = (Path(name, "recorded/reach1.csv").read_text() for name in "abc")
    assert first == again != other


def test_nothing_that_is_there_is_overwritten(empty_folder):
    run("example", "reach", ".")
    Path("ur3.toml").write_text("mine")
    assert "ur3.urdf is there already" in run("example", "reach", ".", code=2).stderr
    assert Path("ur3.toml").read_text() == "mine"


def test_an_unknown_example_is_told_the_known_ones(empty_folder):
    assert "'reach'" in run("example", "reech", "first", code=2).stderr
