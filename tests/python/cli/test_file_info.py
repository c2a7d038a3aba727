import json
from pathlib import Path

import numpy as np
import pytest
from cli.command_line import facts, run
from motions import minimum_jerk, with_derivatives

import leadthrough as lt
from leadthrough.cli.file_info import describe
from leadthrough.errors import InvalidInput
from leadthrough.io import rosbag
from leadthrough.io.table import Request

TIMES = np.arange(51) / 50.0
JOINTS = with_derivatives(
    lt.JointTrajectory(
        TIMES,
        np.outer(minimum_jerk(TIMES), [1.0, -0.5]),
        joint_names=("a_joint", "b_joint"),
    )
)
UR3 = Path(lt.__file__).parents[2] / "robots" / "ur3" / "ur3.urdf"


def test_every_format_of_a_motion_is_told(tmp_path):
    for suffix in ("csv", "npz", "json", "yaml", "mcap"):
        path = tmp_path / f"arm.{suffix}"
        lt.write_motion(JOINTS, path)
        found = describe(path)
        (motion,) = found.recordings
        assert found.kind == "recordings"
        assert (motion.joints, motion.samples) == (("a_joint", "b_joint"), 51)
        assert f"{path}: {found.format}, recordings" in str(found)
        json.dumps(found.as_dict(), allow_nan=False)


def test_a_bag_tells_all_its_topics(tmp_path):
    poses = lt.PoseTrajectory(TIMES, np.zeros((51, 3)), [(1, 0, 0, 0)] * 51, (lt.Event(0, "go"),))
    rosbag.write_poses(poses, tmp_path / "bag", topic="/tool")
    found = describe(tmp_path / "bag")
    assert found.facts["topics"] == [
        "/events (std_msgs/msg/String)",
        "/tool (geometry_msgs/msg/PoseStamped)",
    ]
    assert [each.name for each in found.recordings] == ["/tool"]


def test_what_is_missing_to_read_a_file_is_said(tmp_path):
    path = tmp_path / "recording.csv"
    path.write_text("x,y,joint_1\n1,2,3\n4,5,6\n")
    found = describe(path)
    assert found.facts["columns"] == ["x", "y", "joint_1"]
    assert "the file has both poses and joints" in found.problem
    assert f"! {found.problem}" in str(found)
    found = describe(path, request=Request(columns={"joints": ("joint_1",)}))
    assert "rate: the file has no time column" in found.problem
    found = describe(path, request=Request(columns={"joints": ("joint_1",)}, rate=10.0))
    assert (found.problem, found.recordings[0].joints) == (None, ("joint_1",))


def test_a_skill_tells_its_model(tmp_path):
    skill = lt.DMP(weights=12).fit([lt.Demonstration(JOINTS)])
    skill.save(tmp_path / "skill.npz")
    found = describe(tmp_path / "skill.npz")
    assert (found.kind, found.facts["model"], found.facts["weights"]) == ("skill", "dmp", 12)
    json.dumps(found.as_dict(), allow_nan=False)


def test_a_robot_tells_its_joints():
    found = describe(UR3)
    assert found.kind == "robot"
    assert found.facts["joints"] == list(lt.Arm.load("ur3").joint_names)
    assert "wrist_3_joint continuous" in str(found)


@pytest.mark.parametrize("path", [None, "missing.csv", "missing.urdf", "."])
def test_what_is_no_file_is_refused(path):
    with pytest.raises(InvalidInput):
        describe(path)


def test_the_command_prints_text_or_json(tmp_path):
    path = tmp_path / "arm.csv"
    lt.write_motion(JOINTS, path)
    said = run("info", path, UR3).output
    assert "arm: joints, 51 samples, 1 s at 50 Hz" in said
    assert "from base_link to tool0" in said
    (found,) = facts("info", path)
    assert found["recordings"][0]["joints"] == ["a_joint", "b_joint"]
    run("info", "missing.csv", code=2)
