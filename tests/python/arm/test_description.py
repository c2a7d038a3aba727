import numpy as np
import pytest
from motions import configurations
from urdfs import one_joint, two_wheels

import leadthrough as lt


def line_of(text, word):
    (line,) = (line for line in text.splitlines() if word in line.split())
    return line


@pytest.mark.parametrize("name", ["panda", "ur3", "tiago"])
def test_every_joint_stands_in_a_line_with_its_limits(name):
    arm = lt.Arm.load(name)
    text = arm.describe()
    assert text.startswith(f"{name}: from {arm.base} to {arm.tip}, {len(arm.joint_names)} joints")
    for i, joint in enumerate(arm.joint_names):
        line = line_of(text, joint)
        for quantity in ("velocity", "acceleration", "jerk", "effort"):
            value = getattr(arm.limits, quantity)[i]
            assert f"{value:.{4 if value < 1000 else 0}{'g' if value < 1000 else 'f'}}" in line
    assert "none" not in text.split("collision shapes per link: ")[1]
    assert "\x1b" not in text
    assert max(map(len, text.splitlines())) <= 130


def test_positions_are_also_given_in_degrees_where_they_are_angles():
    text = lt.Arm.load("tiago").describe()
    assert "(157.5)" in line_of(text, "arm_1_joint")
    assert "(" not in line_of(text, "torso_lift_joint")


def test_unknown_and_missing_limits_are_called_so():
    text = lt.Arm.from_urdf(one_joint()).describe()
    line = line_of(text, "j")
    assert '"j" = { velocity = ?, acceleration = ?, jerk = ? }' in text
    assert line.split().count("none") == 4
    assert line.split().count("unknown") == 2


def test_locked_joints_and_loads_are_listed():
    arm = (
        lt.Arm.load("tiago")
        .lock_joints({"torso_lift_joint": 0.125})
        .with_tool((0.0, 0.0, 0.25))
        .with_attached(lt.Box((0.1, 0.1, 0.1), (0.0, 0.0, 0.5)), mass=0.75)
        .with_payload(0.5)
    )
    text = arm.describe()
    assert "locked at 0.125" in line_of(text, "torso_lift_joint")
    assert "tip at (0, 0, 0.25) m" in text
    assert "load: 1.25 kg" in text
    assert "holds: Box at (0, 0, 0.75) m" in text


def test_a_joint_that_mimics_shows_how():
    text = lt.Arm.from_urdf(two_wheels('multiplier="-2" offset="0.1"')).describe()
    assert "= -2 one +0.1" in text


def test_the_reach_is_a_bound():
    arm = lt.Arm.load("ur3")
    reach = float(arm.describe().split("reach at most ")[1].split()[0])
    positions, _ = arm.forward_kinematics(configurations(arm, 200, 1))
    assert np.linalg.norm(positions - [0, 0, 0.1519], axis=1).max() <= reach
