"""Scenes: surfaces in layers and links that move."""

import json
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused
from show.conftest import places_at

import leadthrough as lt
from leadthrough.show.arm_scene import arm_scene, distribution_of, readouts

STICKS = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
<joint name="one" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="two" type="fixed"><parent link="b"/><child link="c"/><origin xyz="0.5 0 0"/></joint>
</robot>"""


def middle_of(arm):
    return 0.5 * (arm.limits.lower + arm.limits.upper)


def swing(arm, duration=2.0, count=50):
    times = np.linspace(0.0, duration, count)
    q = middle_of(arm) + np.outer(0.3 * np.sin(times), np.ones(len(arm.joint_names)))
    return lt.JointTrajectory(times, q, joint_names=arm.joint_names)


def test_tip_of_the_scene_goes_where_the_arm_goes(panda):
    joints = swing(panda)
    made = arm_scene(panda, joints)
    for time in (0.0, 0.7, 1.234, 2.0):
        q = [np.interp(time, joints.times, column) for column in joints.positions.T]
        position, _ = panda.forward_kinematics(np.array(q))
        found = places_at(made, time)
        assert np.allclose(found[made.links.index(panda.tip)], position, atol=1e-4)


def test_each_kind_of_thing_has_its_layer(panda, shown):
    skill = lt.ProMP().fit(shown)
    made = arm_scene(
        panda,
        swing(panda),
        demonstrations=shown,
        skill=skill,
        obstacles=[lt.Sphere(0.1, (1, 0, 0)), lt.Box((1, 1, 1), (2, 0, 0))],
        goal=(0.4, 0.0, 0.4),
    )
    layers = [item.layer for item in made.items]
    counts = {layer: layers.count(layer) for layer in dict.fromkeys(layers)}
    assert counts.pop("arm") == 16  # nine links, seven of them in two colours
    assert counts == {
        "demonstrations": 5, "path": 1, "start": 1, "uncertainty": 1, "obstacles": 2, "goal": 1,
    }  # fmt: skip


@pytest.mark.parametrize("name", ["panda", "ur3"])
def test_arm_without_a_motion_stands_in_the_middle_of_its_ranges(name):
    """The last joint of the UR3 turns without an end, and stands at zero."""
    arm = lt.Arm.load(name)
    made = arm_scene(arm, None)
    wanted, _ = arm.forward_kinematics(middle_of(arm) if name == "panda" else np.zeros(6))
    assert np.allclose(made.positions[0, made.links.index(arm.tip)], wanted)
    assert not [item for item in made.items if item.layer == "path"]


def test_arm_without_geometry_is_drawn_as_rods():
    arm = lt.Arm.from_urdf(STICKS)
    made = arm_scene(arm, None)
    reach = max(item.mesh.vertices[:, 0].max() for item in made.items)
    assert reach == pytest.approx(0.5, abs=0.05)


def test_long_motion_is_shown_in_no_more_pictures_than_one_can_see(panda):
    made = arm_scene(panda, swing(panda, 100.0, 100_000))
    assert len(made.times) <= 1200
    assert made.times[-1] == 100.0


def test_held_object_is_drawn_at_the_tip(panda):
    arm = panda.with_attached(lt.Box((0.1, 0.1, 0.1), (0, 0, 0.05)))
    names = [item.name for item in arm_scene(arm, None).items]
    assert "attached 0" in names


def test_spread_of_joints_is_brought_to_the_tip(panda):
    rng = np.random.default_rng(3)
    base = swing(panda)
    shown = [
        lt.Demonstration(
            lt.JointTrajectory(base.times, base.positions + rng.normal(0, 0.05, 7), None, None,
                               panda.joint_names)
        )
        for _ in range(20)
    ]  # fmt: skip
    mean, covariance = distribution_of(panda, lt.ProMP().fit(shown))
    tips = np.array([panda.forward_kinematics(each.motion.positions[0])[0] for each in shown])
    assert np.allclose(mean[0], tips.mean(axis=0), atol=0.01)
    spread, wanted = np.sqrt(np.diag(covariance[0])), tips.std(axis=0)
    assert np.allclose(spread, wanted, rtol=0.35)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"joints": 3}, "joints: expected a JointTrajectory"),
        ({"joints": lt.JointTrajectory([0, 1], np.zeros((2, 3)))}, "joints: expected 7 joints"),
        ({"goal": (1, 2)}, "goal: expected shape"),
        ({"path": np.full((3, 3), np.nan)}, "path: expected finite"),
        ({"demonstrations": [1]}, r"demonstrations\[0\]: expected a Demonstration"),
        ({"obstacles": ["box"]}, "obstacles: expected Box"),
    ],
)
def test_wrong_arguments_are_named(panda, arguments, said):
    refused(said, arm_scene, panda, **{"joints": None, **arguments})


def test_figures_along_a_motion_are_those_of_the_arm_at_its_frames(panda):
    box = lt.Box((0.1, 0.1, 0.3), (0.6, 0.2, 0.15))
    joints = swing(panda, count=400)
    made = arm_scene(panda, joints, obstacles=[box])
    told = readouts(panda, joints, lt.Scene([box]))
    assert len(told["times"]) == len(made.times)
    q = np.array(told["positions"]).T
    near, own = told["pairs"]
    np.testing.assert_allclose(near["distance"], panda.distance(q, [box]), atol=1e-3)
    np.testing.assert_allclose(own["distance"], panda.self_distance(q), atol=1e-3)
    for pair in told["pairs"]:
        points = np.array(pair["points"])
        lengths = np.linalg.norm(points[:, 3:] - points[:, :3], axis=1)
        np.testing.assert_allclose(lengths, np.abs(pair["distance"]), atol=2e-3)
    assert all("obstacle 0" in names for names in near["bodies"])
    expected = 0.3 * np.cos(told["times"])
    np.testing.assert_allclose(
        np.array(told["velocities"])[:, 2:-2], [expected[2:-2]] * 7, atol=2e-3
    )
    most = (np.abs(expected)[:, None] / panda.limits.velocity).max(axis=1)
    np.testing.assert_allclose(told["share"][2:-2], most[2:-2], atol=2e-3)


def test_an_arm_without_geometry_has_figures_but_no_pairs():
    arm = lt.Arm.from_urdf(STICKS)
    told = readouts(arm, swing(arm), lt.Scene())
    assert told["pairs"] == []
    assert told["limits"] == [[-1.0], [1.0], [1.0]]
    assert readouts(arm, None, lt.Scene()) is None


def test_figures_of_a_joint_whose_velocity_limit_is_zero_are_numbers(panda):
    velocity = panda.limits.velocity * [1, 1, 1, 1, 1, 1, 0]
    held = lt.Arm.load("panda", limits=replace(panda.limits, velocity=velocity))
    motion = swing(panda)
    still = motion.positions * [1, 1, 1, 1, 1, 1, 0]
    for q in (motion.positions, still):
        told = readouts(held, replace(motion, positions=q), lt.Scene())
        json.dumps(told, allow_nan=False)


def test_errors_of_the_tip_are_distances_from_the_wanted_path():
    """A tip on an arc of 0.5 m, beside a straight path 0.6 m away that ends half-way."""
    arm = lt.Arm.from_urdf(STICKS)
    joints = swing(arm)
    found = readouts(arm, joints, lt.Scene(), np.array([(0.6, -1.0, 0.0), (0.6, 0.0, 0.0)]))
    tip = 0.5 * np.exp(1j * joints.positions[:, 0])
    off = np.where(tip.imag < 0.0, 0.6 - tip.real, np.abs(tip - 0.6))
    np.testing.assert_allclose(found["error"], off, atol=1e-6)
    assert readouts(arm, joints, lt.Scene())["error"] is None
