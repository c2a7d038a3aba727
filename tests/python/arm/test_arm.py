"""Arms: from URDFs and by name, described, with joints locked."""

import contextlib
import pickle
import sys

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from motions import configurations
from refusals import raised, refused
from urdfs import one_joint, two_wheels

import leadthrough as lt
from leadthrough.arm import JointLimits
from leadthrough.errors import InvalidInput, InvalidRobot

LIMIT = '<limit lower="-1" upper="1" velocity="2" effort="3"/>'


def planar(inside=LIMIT, kind="revolute"):
    return (
        '<robot name="planar"><link name="base"/><link name="tool"/>'
        f'<joint name="turn" type="{kind}"><parent link="base"/><child link="tool"/>'
        f'<axis xyz="0 0 1"/>{inside}</joint></robot>'
    )


@pytest.mark.parametrize("name", ["panda", "ur3", "tiago"])
def test_bundled_robots_load_with_all_their_limits(name):
    arm = lt.Arm.load(name)
    for quantity in ("lower", "upper", "velocity", "acceleration", "jerk", "effort"):
        assert getattr(arm.limits, quantity).shape == (len(arm.joint_names),)


def test_a_document_and_its_file_are_the_same_robot(tmp_path):
    path = tmp_path / "planar.urdf"
    path.write_text(planar())
    for source in (planar(), path, str(path)):
        arm = lt.Arm.from_urdf(source)
        assert (arm.base, arm.tip, arm.joint_names) == ("base", "tool", ("turn",))
        np.testing.assert_array_equal(arm.limits.velocity, [2.0])
        assert arm.limits.acceleration is None


def test_limits_come_from_a_file_or_as_they_are(tmp_path):
    path = tmp_path / "limits.toml"
    path.write_text("[joints]\nturn = { upper = 0.5, acceleration = 4 }\n")
    from_file = lt.Arm.from_urdf(planar(), limits=path)
    assert from_file.limits.upper[0] == 0.5
    assert from_file.limits.acceleration[0] == 4
    given = lt.Arm.from_urdf(planar(), limits=JointLimits(("turn",), [-0.2], [0.2], [1]))
    assert given.inverse_kinematics([0, 0, 0], [np.cos(0.4), 0, 0, np.sin(0.4)]).q[0] == 0.2
    with pytest.raises(InvalidInput, match="limits"):
        lt.Arm.from_urdf(planar(), limits=JointLimits(("other",), [-0.2], [0.2], [1]))


def test_several_ends_ask_for_the_tip():
    fork = planar().replace(
        "</robot>",
        '<link name="camera"/><joint name="mount" type="fixed"><parent link="base"/>'
        '<child link="camera"/></joint></robot>',
    )
    refused("'tool'", lt.Arm.from_urdf, fork)
    assert lt.Arm.from_urdf(fork, tip="tool").joint_names == ("turn",)


@pytest.mark.parametrize(
    ("document", "where"),
    [
        ("<robot", "line 1"),
        ("<robot></robot>", "robot"),
        (planar(""), "joint 'turn'"),
        (planar('<limit lower="2" upper="1" velocity="1" effort="1"/>'), "joint 'turn'"),
        (planar('<limit lower="-1" upper="1" effort="1"/>'), "joint 'turn'"),
        (planar('<mimic joint="ghost"/>' + LIMIT), "joint 'turn'"),
        (planar("", "fixed"), "tip"),
        ("<a>" * 10**6, "line 1"),
        ("<robot>" + " " * (17 << 20), "document"),
        (planar().replace("planar", "\ud800"), "path_or_xml"),
    ],
)
def test_a_malformed_or_contradictory_robot_is_refused(document, where):
    assert str(raised((InvalidRobot, InvalidInput), lt.Arm.from_urdf, document)).startswith(where)


def test_a_chain_of_a_hundred_thousand_joints_is_refused():
    links = "".join(f'<link name="{i}"/>' for i in range(100_001))
    joints = "".join(
        f'<joint name="j{i}" type="fixed"><parent link="{i}"/><child link="{i + 1}"/></joint>'
        for i in range(100_000)
    )
    with pytest.raises(InvalidRobot, match="more than"):
        lt.Arm.from_urdf(f'<robot name="long">{links}{joints}</robot>')


def loaded(arm):
    turn = (0.8, 0.0, 0.6, 0.0)
    held = arm.with_tool((0.1, 0.0, 0.2), turn).with_payload(1.0, (0.0, 0.0, 0.1))
    return held.with_attached(lt.Capsule(0.05, 0.1, (0, 0, 0.1), turn), mass=0.5)


@pytest.mark.parametrize(
    "made",
    [
        lambda: lt.Arm.load("ur3"),
        lambda: loaded(lt.Arm.load("ur3")),
        lambda: lt.Arm.load("tiago").lock_joints({"torso_lift_joint": 0.2, "arm_7_joint": 0.3}),
    ],
    ids=["plain", "loaded", "locked"],
)
def test_an_arm_travels_between_processes(made):
    arm = made()
    again = pickle.loads(pickle.dumps(arm))
    q = np.linspace(0.1, 0.6, 6)
    for ask in ("forward_kinematics", "jacobian", "mass_matrix"):
        for ours, theirs in zip(getattr(again, ask)(q), getattr(arm, ask)(q), strict=True):
            np.testing.assert_array_equal(ours, theirs)
    for ours, theirs in zip(again.tool, arm.tool, strict=True):
        np.testing.assert_array_equal(ours, theirs)
    for ours, theirs in zip(again.attached, arm.attached, strict=True):
        np.testing.assert_array_equal(ours.position, theirs.position)
    np.testing.assert_array_equal(again.limits.jerk, arm.limits.jerk)
    assert again.locked_joints == arm.locked_joints


def test_joints_without_bounds_are_solved_nearest_to_the_seed():
    wheel = lt.Arm.from_urdf(planar("", "continuous"))
    target = [np.cos(0.4), 0, 0, np.sin(0.4)]
    assert wheel.limits.upper[0] == np.inf
    for turns in (-3, 0, 5):
        seed = [0.7 + 2 * np.pi * turns]
        result = wheel.inverse_kinematics([0, 0, 0], target, q0=seed)
        np.testing.assert_allclose(result.q, [0.8 + 2 * np.pi * turns], atol=1e-5)


@settings(max_examples=300, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 60), st.sampled_from(["", "<", '"', ">", "-9", "nan"]))
def test_a_damaged_document_is_read_or_refused(at, length, patch):
    document = planar()
    start = at % len(document)
    damaged = document[:start] + patch + document[start + length :]
    with contextlib.suppress(InvalidRobot, InvalidInput):
        arm = lt.Arm.from_urdf(damaged, tip="tool")
        assert np.isfinite(arm.forward_kinematics(np.zeros(len(arm.joint_names)))[0]).all()


def test_methods_of_a_class_of_ones_own_keep_their_names():
    class Mine(lt.Arm):
        def wave(self):
            return self.joint_names

    assert Mine.wave.__qualname__.endswith("Mine.wave")
    assert pickle.loads(pickle.dumps(lt.Arm.follow)) is lt.Arm.follow


def test_names_links_and_files_of_no_robot_are_refused():
    for name in ["nao", "", None, 3, "../panda"]:
        refused("'panda'", lt.Arm.load, name)
    for names in [{"base": "nowhere"}, {"tip": "nowhere"}, {"tip": 3}]:
        refused(next(iter(names)), lt.Arm.from_urdf, planar(), **names)
    for source in ["nowhere.urdf", None, 3, b"<robot/>", "/"]:
        refused("path_or_xml", lt.Arm.from_urdf, source)
    limits = JointLimits(("turn", "twist"), [-1, -1], [1, 1], [1, 1])
    refused("limits", lt.Arm, planar(), "base", "tool", limits)
    for name in ("x.urdf", "robots/x", "x.xacro"):
        refused(r"read a file with Arm\.from_urdf\('", lt.Arm.load, name)


def test_a_robot_of_example_robot_data_is_found_by_its_name():
    pytest.importorskip("importlib.metadata").distribution("example-robot-data")
    arm = lt.Arm.load("xarm7", tip="link7")
    assert arm.joint_names == tuple(f"joint{i}" for i in range(1, 8))
    assert arm.self_distance(np.zeros(7)) > 0.0  # its meshes are found
    assert lt.Arm.load("ur5", tip="tool0").joint_names == lt.Arm.load("ur3").joint_names
    refused("several robots 'anymal'", lt.Arm.load, "anymal")


def test_a_robot_of_robot_descriptions_is_found_by_its_name(tmp_path, monkeypatch):
    package = tmp_path / "robot_descriptions"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "planar.urdf").write_text(planar())
    (package / "planar_description.py").write_text(
        f"URDF_PATH = {str(package / 'planar.urdf')!r}\nPACKAGE_PATH = {str(package)!r}\n"
    )
    (package / "other_mj_description.py").write_text("MJCF_PATH = 'other.xml'\n")
    monkeypatch.syspath_prepend(tmp_path)
    for name in [name for name in sys.modules if name.startswith("robot_descriptions")]:
        monkeypatch.delitem(sys.modules, name)  # the true one, where it is installed
    for name in ("planar", "planar_description"):
        assert lt.Arm.load(name).joint_names == ("turn",)
    refused("has no URDF", lt.Arm.load, "other_mj")


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


@pytest.mark.parametrize("method", ["forward_kinematics", "jacobian", "with_tool", "follow"])
def test_a_missing_argument_is_told_of_the_arm(method):
    with pytest.raises(TypeError, match=rf"^Arm\.{method}\(\) missing 1 required"):
        getattr(lt.Arm.load("ur3"), method)()
