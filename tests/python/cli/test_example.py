"""`leadthrough example`: files on which all commands can be tried."""

from pathlib import Path

import numpy as np
from cli.command_line import facts, run

import leadthrough as lt


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
