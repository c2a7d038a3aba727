"""`leadthrough start`: a robot and recordings lead to a checked motion and its page."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from cli.command_line import RUNNER, run, write_table
from motions import minimum_jerk

import leadthrough as lt
from leadthrough import cli
from leadthrough.arm import robot_files
from leadthrough.cli import questions, reading
from leadthrough.cli.options import ReadOptions
from leadthrough.io.table import Request

NAMES = lt.Arm.load("ur3").joint_names
START = np.array([0.2, -1.4, 1.3, -1.2, -1.5, 0.1])
TIMES = np.arange(0.0, 2.0, 0.02)


@pytest.fixture
def folder(empty_folder):
    """A folder with a URDF that has no limits file, as the working directory."""
    Path("arm.urdf").write_text(robot_files.find_robot("ur3").urdf.read_text())
    return empty_folder


def rows(seed=0):
    """Joints along a reach of 2 s at 50 Hz."""
    way = np.array([0.5, 0.3, -0.2, 0.1, 0.2, -0.3]) + 0.02 * seed
    return START + np.outer(minimum_jerk(TIMES / TIMES[-1]), way)


def written(name, q):
    """A table of times and joints, and its path."""
    return write_table(name, f"time,{','.join(NAMES)}", np.column_stack([TIMES, q]))


def test_one_command_makes_a_checked_motion_of_ones_own_arm_and_recordings(folder):
    for seed in range(2):
        written(f"{seed}.csv", rows(seed))
    told = run("start", "arm.urdf", "0.csv", "1.csv", "--yes").stdout
    profile = tomllib.loads(Path("leadthrough.toml").read_text())
    assert profile == {
        "robot": "arm.urdf",
        "base": "base_link",
        "tip": "tool0",
        "limits": "arm-limits.toml",
    }
    arm = lt.Arm.from_urdf("arm.urdf", tip="tool0", limits="arm-limits.toml")
    motion = lt.read_motion("timed.json")
    assert lt.check_limits(motion, arm.limits).ok
    for index in (0, -1):
        shown = np.mean([rows(0)[index], rows(1)[index]], axis=0)
        assert np.abs(motion.positions[index] - shown).max() < 0.02
    assert Path("motion.html").stat().st_size > 10_000
    for name in ("info", "learn", "plan", "retime", "check", "view"):
        assert f"$ leadthrough {name} " in told
    assert told.count("next:") == 1
    run("plan", "skill.npz", "--move-goal=0.02,0,0.02", "-o", "moved.json")


def test_only_what_the_files_leave_open_is_asked_for(folder):
    np.save("day.npy", np.degrees(rows()))
    answers = ["", "wrist_3_link", "mine.toml", "50", "degrees"]
    words = ["start", "arm.urdf", "day.npy"]
    result = RUNNER.invoke(cli.app, words, input="\n".join(answers))
    assert result.exit_code == 0, result.output
    assert "--rate 50" in result.stdout
    assert "--angles degrees" in result.stdout
    assert tomllib.loads(Path("leadthrough.toml").read_text())["tip"] == "wrist_3_link"
    motion = lt.read_motion("timed.json")
    assert np.abs(motion.positions[[0, -1]] - rows()[[0, -1]]).max() < 5e-3


def test_other_names_of_columns_are_proposed_in_their_order(folder):
    header = "a,b,c,d,e,f"
    path = write_table("day.csv", f"clock,{header}", np.column_stack([TIMES, rows()]))
    arm = lt.Arm.from_urdf("arm.urdf")
    table = reading.first_table(Path(path), Request())
    found = questions.settled(questions.taken, arm, table, ReadOptions())
    assert found == ReadOptions(column=["time=clock", f"joints={header}"])


def test_numbered_joints_and_faults_are_no_obstacle(folder):
    q = rows()
    q[20, 2] = np.nan
    names = " ".join(f"actual_q_{k}" for k in range(6))
    np.savetxt("ur.csv", np.column_stack([TIMES, q]), header=f"timestamp {names}", comments="")
    told = run("start", "arm.urdf", "ur.csv", "--yes").stdout
    assert "--clean" in told
    motion = lt.read_motion("timed.json")
    assert np.abs(motion.positions[[0, -1]] - rows()[[0, -1]]).max() < 5e-3
    assert Path("motion.html").stat().st_size > 10_000


def test_columns_are_not_chosen_for_the_user_where_others_would_be_left_out(folder):
    extra = np.column_stack([TIMES, rows(), rows()[:, :2]])
    write_table("day.csv", "time,a,b,c,d,e,f,g,h", extra)
    told = run("start", "arm.urdf", "day.csv", "--yes", code=2).stderr
    assert "such as --column joints=a,b,c,d,e,f" in told


def test_a_rate_is_never_guessed_and_somebody_has_to_answer(folder):
    np.save("day.npy", rows())
    assert "rate in Hz (--rate)" in run("start", "arm.urdf", "day.npy", "--yes", code=2).stderr
    assert "--yes: nobody answers" in run("start", "arm.urdf", "day.npy", code=2).stderr


def test_a_step_that_fails_ends_the_command_with_its_cure(folder):
    Path("leadthrough.toml").write_text('robot = "arm.urdf"\ntip = "tool0"\n')
    for seed in range(3):
        written(f"{seed}.csv", rows(seed)[:: -1 if seed == 2 else 1])
    result = run("start", "arm.urdf", "0.csv", "1.csv", "2.csv", code=1)
    assert "leave out with --drop 2" in result.stderr
    assert "next: leadthrough learn 0.csv 1.csv 2.csv --out skill.npz --drop 2" in result.stdout
    assert "$ leadthrough plan" not in result.stdout


def test_a_profile_is_kept_and_that_of_another_robot_is_not_overwritten(folder):
    Path("leadthrough.toml").write_text('robot = "other.urdf"\n')
    path = written("day.csv", rows())
    told = run("start", "arm.urdf", path, "--yes", code=2).stderr
    assert "leadthrough.toml: is there already, for another robot" in told
    Path("leadthrough.toml").write_text('robot = "arm.urdf"\n')
    told = run("start", "arm.urdf", path, "--tip", "tool0", code=2).stderr
    assert "--tip: only used with a robot that leadthrough.toml does not describe" in told


TWO_ARMS = """<robot name="two"><link name="root"/>{links}</robot>"""
ARM = """<link name="{0}0"/><link name="{0}1"/><link name="{0}2"/><link name="{0}_tool0"/>
<joint name="{0}_mount" type="fixed"><parent link="root"/><child link="{0}0"/></joint>
<joint name="{0}_a" type="continuous"><parent link="{0}0"/><child link="{0}1"/></joint>
<joint name="{0}_b" type="continuous"><parent link="{0}1"/><child link="{0}2"/></joint>
<joint name="{0}_flange" type="fixed"><parent link="{0}2"/><child link="{0}_tool0"/></joint>"""


def test_the_arm_that_was_recorded_is_proposed():
    document = TWO_ARMS.format(links="".join(ARM.format(side) for side in ("left", "right")))
    recorded = ["time", "right_a", "right_b"]
    assert robot_files.proposed_ends(document, recorded) == ("right0", "right_tool0")
    assert robot_files.proposed_ends(document, ["time"]) == ("root", "left_tool0")


JOINT = """<link name="{1}"/><joint name="{0}" type="{2}"><parent link="{3}"/>
<child link="{1}"/>{4}</joint>"""


def test_the_arm_is_proposed_to_its_only_end_also_behind_a_joint_that_mimics():
    joints = [
        ("j1", "upper", "continuous", "base", ""),
        ("rod", "lower", "continuous", "upper", '<mimic joint="j1" multiplier="-1"/>'),
        ("j2", "wrist", "continuous", "lower", ""),
        ("plate", "flange_plate", "fixed", "wrist", ""),
        ("pin", "needle", "fixed", "flange_plate", ""),
    ]
    links = '<link name="base"/>' + "".join(JOINT.format(*each) for each in joints)
    document = f'<robot name="r">{links}</robot>'
    assert robot_files.proposed_ends(document, ["j1", "j2"]) == ("base", "needle")
    assert robot_files.proposed_ends(document) == ("base", "needle")
