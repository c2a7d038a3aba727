"""Two arms along the poses of an object that both hold, against roboplan's Cartesian planner.

The peer starts from our first configuration, in its defaults. The error is how far the hands are
from where they belong to each other, at the middles between samples too, by the peer's kinematics.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree

import numpy as np
import roboplan.cartesian_planning as peer_planning
import roboplan.core as peer_core
from frame import Benchmark

import leadthrough as lt
from leadthrough import rotations

APART = 0.8  # m, between the bases
DOWN = np.array([0.0, 1.0, 0.0, 0.0])
GRASPS = (((0.0, 0.15, 0.0), DOWN), ((0.0, -0.15, 0.0), DOWN))
SIDES = ("left", "right")
HELD = 1e-4  # m


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """The row of two Pandas that lift and turn an object."""
    panda, samples = lt.Arm.load("panda"), 31 if quick else 101
    pair = lt.DualArm(panda, panda, ((0.0, -APART, 0.0), (1.0, 0.0, 0.0, 0.0)))
    motion = _lift(samples)
    names = [f"{side}_{name}" for side in SIDES for name in panda.joint_names]
    scene = peer_core.Scene("pair", peer_core.loadUrdfSceneDescriptionFromXml(_side_by_side(panda)))
    scene.addGroup("arms", names)
    tips = [f"{side}_{panda.tip}" for side in SIDES]
    poses = [
        [np.asfortranarray(_matrix(*pose) @ _matrix(*grasp)) for pose in _poses(motion)]
        for grasp in GRASPS
    ]
    path = peer_core.CartesianPath(["world"] * 2, tips, poses)
    planner = peer_planning.CartesianPathPlanner(
        scene,
        peer_planning.CartesianPlannerOptions(
            group_name="arms", speed_mode=peer_planning.CartesianSpeedMode.TimeOptimal
        ),
    )
    start = peer_core.JointConfiguration(names, pair.follow(motion, GRASPS).positions[0].copy())

    def apart(q: Any) -> float:
        rows = np.vstack([q, 0.5 * (q[1:] + q[:-1])])
        right = [_seen(scene, tips, row)[:3, 3] for row in rows]
        wanted = (np.linalg.inv(_matrix(*GRASPS[0])) @ _matrix(*GRASPS[1]))[:3, 3]
        return float(np.linalg.norm(np.array(right) - wanted, axis=1).max())

    def ours() -> Any:
        return pair.follow(motion, GRASPS).positions

    def peer() -> Any:
        return np.array(planner.plan(path, start).positions)

    off = f"the peer's hands {1e3 * apart(peer()):.0f} mm off"
    yield Benchmark(
        f"two arms along {samples} poses of an object; {off}",
        ours=ours,
        peer=peer,
        peer_name="roboplan",
        error=lambda q, _: apart(q),
        tolerance=HELD,
    )


def _lift(samples: int) -> lt.PoseTrajectory:
    s = lt.trajectories.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, samples))
    path = np.column_stack([0.45 + 0.08 * np.sin(np.pi * s), -0.4 + 0.1 * s, 0.3 + 0.25 * s])
    turns = rotations.exp(s[:, None] * [0.15, 0.1, 0.3])
    return lt.PoseTrajectory(np.linspace(0.0, 4.0, samples), path, turns)


def _poses(motion: lt.PoseTrajectory) -> Any:
    return zip(motion.positions, motion.orientations, strict=True)


def _matrix(position: Any, orientation: Any) -> Any:
    result = np.eye(4)
    result[:3, :3] = rotations.to_matrix(np.array([orientation]))[0]
    result[:3, 3] = position
    return result


def _seen(scene: Any, tips: list[str], q: Any) -> Any:
    """The pose of the right tip in the frame of the left one."""
    whole = scene.toFullJointPositions("arms", np.ascontiguousarray(q))
    left, right = (scene.forwardKinematics(whole, tip) for tip in tips)
    return np.linalg.inv(left) @ right


def _side_by_side(arm: lt.Arm) -> str:
    """Both arms in one URDF, without shapes."""
    robot = ElementTree.Element("robot", name="pair")
    ElementTree.SubElement(robot, "link", name="world")
    for side, y in zip(SIDES, (0.0, -APART), strict=True):
        tree = ElementTree.fromstring(arm.document)
        for link in tree.findall("link"):
            robot.append(ElementTree.Element("link", name=f"{side}_{link.get('name')}"))
        for joint in tree.findall("joint"):
            joint.set("name", f"{side}_{joint.get('name')}")
            for end in (*joint.findall("parent"), *joint.findall("child")):
                end.set("link", f"{side}_{end.get('link')}")
            for mimic in joint.findall("mimic"):
                mimic.set("joint", f"{side}_{mimic.get('joint')}")
            robot.append(joint)
        mount = ElementTree.SubElement(robot, "joint", name=f"{side}_mount", type="fixed")
        ElementTree.SubElement(mount, "parent", link="world")
        ElementTree.SubElement(mount, "child", link=f"{side}_{arm.base}")
        ElementTree.SubElement(mount, "origin", xyz=f"0 {y} 0")
    return ElementTree.tostring(robot, encoding="unicode")
