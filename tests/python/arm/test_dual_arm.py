"""Two arms: kinematics, limits, collision and the motion of an object that both hold."""

import pickle
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin
import pytest
from motions import configurations, urdf
from pinocchio_peer import Peer
from refusals import refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import IkFailure
from leadthrough_studies.coal_arm import CoalArm

TURNED = (np.cos(0.2), 0.0, 0.0, np.sin(0.2))
BASE = ((0.1, -0.7, 0.05), TURNED)
DOWN = np.array([0.0, 1.0, 0.0, 0.0])
GRASPS = (((0.0, 0.15, 0.0), DOWN), ((0.0, -0.15, 0.0), DOWN))
FACING = ((0.0, -0.8, 0.0), (1.0, 0.0, 0.0, 0.0))


@pytest.fixture(scope="module")
def dual(panda):
    return lt.DualArm(panda, panda, BASE)


@pytest.fixture(scope="module")
def facing(panda):
    return lt.DualArm(panda, panda, FACING)


def transform(position, orientation):
    return pin.SE3(rotations.to_matrix(np.array([orientation]))[0], np.array(position, float))


def carry(samples=101, rise=0.25):
    """An object is lifted, moved sideways and tilted."""
    u = np.linspace(0.0, 1.0, samples)
    s = u**3 * (10 - 15 * u + 6 * u**2)
    path = np.column_stack([0.45 + 0.08 * np.sin(np.pi * s), -0.4 + 0.1 * s, 0.3 + rise * s])
    return lt.PoseTrajectory(4.0 * u, path, rotations.exp(s[:, None] * [0.15, 0.1, 0.3]))


def relative_errors(dual, q, grasps=GRASPS, base=FACING):
    """Of the tips' relative pose, m and rad, by Pinocchio."""
    wanted = transform(*grasps[0]).actInv(transform(*grasps[1]))
    return errors_from(dual, q, [wanted] * len(q), base)


def errors_from(dual, q, relative, base=FACING):
    """Of the tips' poses in one another's frame, m and rad, by Pinocchio."""
    path = urdf("panda")
    peer = Peer(dual.left, path, {})
    errors = []
    for row, wanted in zip(q, relative, strict=True):
        right = transform(*base) * peer.pose(row[7:])
        error = wanted.actInv(peer.pose(row[:7]).actInv(right))
        errors.append((np.linalg.norm(error.translation), np.linalg.norm(pin.log3(error.rotation))))
    return np.array(errors).max(axis=0)


def rerooted(panda, base):
    """Both arms as one serial chain, from the left tip to the right tip."""
    left, right = (ElementTree.fromstring(panda.document) for _ in range(2))
    robot = ElementTree.Element("robot", name="pair")
    parents = {}
    for side, tree in (("left", left), ("right", right)):
        for link in tree.findall("link"):
            link.set("name", f"{side}_{link.get('name')}")
            robot.append(link)
        for joint in tree.findall("joint"):
            joint.set("name", f"{side}_{joint.get('name')}")
            for end in ("parent", "child"):
                joint.find(end).set("link", f"{side}_{joint.find(end).get('link')}")
            if (mimic := joint.find("mimic")) is not None:
                mimic.set("joint", f"{side}_{mimic.get('joint')}")
            parents[joint.find("child").get("link")] = joint
    reversed_joints, link = [], f"left_{panda.tip}"
    while link in parents:
        reversed_joints.append(parents[link])
        link = parents[link].find("parent").get("link")
    for joint in [j for j in parents.values() if j not in reversed_joints]:
        robot.append(joint)
    for joint in reversed_joints:
        _reverse(robot, joint)
    fixed = ElementTree.SubElement(robot, "joint", name="bases", type="fixed")
    ElementTree.SubElement(fixed, "parent", link=link)
    ElementTree.SubElement(fixed, "child", link=f"right_{panda.base}")
    _origin(fixed, transform(*base))
    return ElementTree.tostring(robot, encoding="unicode")


def _origin(joint, placement):
    rpy = " ".join(map(repr, map(float, pin.rpy.matrixToRpy(placement.rotation))))
    xyz = " ".join(map(repr, map(float, placement.translation)))
    ElementTree.SubElement(joint, "origin", xyz=xyz, rpy=rpy)


def _reverse(robot, joint):
    """From the child: first the rotation backwards, then the fixed transform backwards."""
    name, parent, child = joint.get("name"), joint.find("parent"), joint.find("child")
    origin = joint.find("origin")
    xyz, rpy = (
        np.array([float(x) for x in (origin.get(key) or "0 0 0").split()])
        if origin is not None
        else np.zeros(3)
        for key in ("xyz", "rpy")
    )
    placement = pin.SE3(pin.rpy.rpyToMatrix(rpy), xyz)
    between = f"{name}_origin"
    ElementTree.SubElement(robot, "link", name=between)
    turning = ElementTree.SubElement(robot, "joint", name=name, type=joint.get("type"))
    ElementTree.SubElement(turning, "parent", link=child.get("link"))
    ElementTree.SubElement(turning, "child", link=between)
    if (axis := joint.find("axis")) is not None:
        back = " ".join(str(-float(x)) for x in axis.get("xyz").split())
        ElementTree.SubElement(turning, "axis", xyz=back)
    if (limit := joint.find("limit")) is not None:
        turning.append(limit)
    fixed = ElementTree.SubElement(robot, "joint", name=f"{name}_fixed", type="fixed")
    ElementTree.SubElement(fixed, "parent", link=between)
    ElementTree.SubElement(fixed, "child", link=parent.get("link"))
    _origin(fixed, placement.inverse())


@pytest.fixture(scope="module")
def serial(panda):
    return lt.Arm.from_urdf(
        rerooted(panda, BASE), base=f"left_{panda.tip}", tip=f"right_{panda.tip}"
    )


def in_chain(q):
    """Rows of the pair in the order of the serial chain."""
    return np.hstack([q[:, 6::-1], q[:, 7:]])


def of_pair(dual, count, seed):
    left, right = (
        configurations(dual.left, count, seed),
        configurations(dual.right, count, seed + 1),
    )
    return np.hstack([left, right])


def test_relative_poses_are_those_of_one_serial_chain_from_tip_to_tip(dual, serial):
    q = of_pair(dual, 200, 1)
    ours, theirs = dual.relative_pose(q), serial.forward_kinematics(in_chain(q))
    assert np.abs(ours[0] - theirs[0]).max() < 1e-12
    assert np.abs(rotations.to_matrix(ours[1]) - rotations.to_matrix(theirs[1])).max() < 1e-12


def test_distances_are_those_of_one_serial_chain_from_tip_to_tip(dual, serial):
    """The chain leaves out pairs that 4,000 configurations do not bring together."""
    q, same = of_pair(dual, 60, 3), 0
    known = {frozenset(pair) for pair in serial.collision_pairs.checked}
    for row, chain_row in zip(q, in_chain(q), strict=True):
        ours, theirs = dual.check([row]).closest, serial.check([chain_row]).closest
        assert ours.distance < theirs.distance + 1e-6
        if frozenset(ours.bodies) in known:
            same += 1
            assert ours.distance == pytest.approx(theirs.distance, abs=1e-6)
    assert same > 50


def test_distances_between_the_arms_are_those_of_coal(dual, serial):
    peer, pairs = CoalArm(serial), dual.collision_pairs
    between, apart = (
        [pair for pair in each if {name.partition("_")[0] for name in pair} == {"left", "right"}]
        for each in (pairs.checked, pairs.left_out)
    )
    q = of_pair(dual, 30, 5)
    for chain_row, ours in zip(in_chain(q), dual.distance(q, []), strict=True):
        peer.place(chain_row)
        theirs = min(peer.link_distance(*pair) for pair in between)
        assert ours == pytest.approx(theirs, abs=1e-5) if theirs > 0 else ours < 1e-6
        assert min(peer.link_distance(*pair) for pair in apart) > 0.05
    assert len(between) + len(apart) == len(dual.left.robot.collisions) ** 2 - 1


def test_tests_of_rows_and_edges_say_what_distances_say(dual):
    q = of_pair(dual, 200, 7)
    scene = lt.Scene([lt.Box((0.3, 0.3, 0.3), (0.5, -0.35, 0.4))], 0.02)
    clear = (dual.distance(q, scene) >= 0.02) & (dual.self_distance(q) > -1e-6)
    np.testing.assert_array_equal(dual.is_clear(q, scene), clear)
    assert 20 < clear.sum() < 180
    verdicts = []
    for a, b in zip(q[clear][:20], q[clear][1:21], strict=True):
        rows = [a, 0.7 * a + 0.3 * b]
        motion = lt.JointTrajectory([0.0, 1.0], rows, joint_names=dual.joint_names)
        report = dual.check(motion, scene, tolerance=1e-4)
        verdicts.append(report.ok)
        slack = report.itself.minimum_distance, report.obstacles.minimum_distance - 0.02
        if np.abs(slack).min() > 2e-4:
            assert dual.is_clear(motion, scene) is report.ok
    assert 2 < sum(verdicts) < 18


def test_poses_and_jacobian_are_those_of_each_arm_in_the_frame_of_the_pair(dual, panda):
    q = of_pair(dual, 5, 9)
    positions, orientations = dual.forward_kinematics(q)
    jacobians = dual.jacobian(q)
    for row, p, o, J in zip(q, positions, orientations, jacobians, strict=True):
        right = transform(*BASE) * transform(*panda.forward_kinematics(row[7:]))
        left = transform(*panda.forward_kinematics(row[:7]))
        for placement, k in ((left, 0), (right, 1)):
            assert np.abs(placement.translation - p[k]).max() < 1e-12
            assert np.abs(placement.actInv(transform(p[k], o[k])).rotation - np.eye(3)).max() < 1e-9
        step = 1e-6 * np.arange(1.0, 15.0)
        ahead, behind = (dual.forward_kinematics(row + sign * step) for sign in (0.5, -0.5))
        moved = (ahead[0] - behind[0]).ravel()
        turned = rotations.log(rotations.compose(ahead[1], rotations.inverse(behind[1])))
        found = (J @ step).reshape(2, 2, 3)
        np.testing.assert_allclose(found[:, 0].ravel(), moved, atol=1e-10)
        np.testing.assert_allclose(found[:, 1], turned, atol=1e-10)


def test_inverse_kinematics_reaches_poses_of_the_pair(dual):
    q = of_pair(dual, 1, 11)[0]
    positions, orientations = dual.forward_kinematics(q)
    poses = list(zip(positions, orientations, strict=True))
    left, right = dual.inverse_kinematics(*poses, q0=q + 0.05)
    assert left.success
    assert right.success
    again = dual.forward_kinematics(np.concatenate([left.q, right.q]))
    assert np.abs(again[0] - positions).max() < 1e-5


def test_names_that_both_arms_have_get_their_side_in_front(panda):
    ur3 = lt.Arm.load("ur3")
    assert lt.DualArm(panda, panda, BASE).joint_names[6:8] == (
        "left_panda_joint7",
        "right_panda_joint1",
    )
    mixed = lt.DualArm(panda, ur3, BASE)
    assert mixed.joint_names == panda.joint_names + ur3.joint_names
    assert mixed.limits.jerk[7:].tolist() == ur3.limits.jerk.tolist()


def test_a_pair_is_pickled(dual):
    again = pickle.loads(pickle.dumps(dual))
    q = of_pair(dual, 2, 1)
    np.testing.assert_array_equal(again.distance(q, []), dual.distance(q, []))
    assert repr(again) == repr(dual)
    assert "14 joints left_panda_joint1 ... right_panda_joint7" in " ".join(repr(dual).split())


def test_motions_of_either_arm_have_its_own_names(dual, panda):
    q = of_pair(dual, 4, 1)
    motion = lt.JointTrajectory(np.arange(4.0), q[:, ::-1], joint_names=dual.joint_names[::-1])
    left, right = dual.motions(motion)
    assert left.joint_names == right.joint_names == panda.joint_names
    np.testing.assert_array_equal(np.hstack([left.positions, right.positions]), q)


def test_an_object_is_held_at_samples_and_between_them(facing):
    motion = carry()
    joints = facing.follow(motion, GRASPS, scene=[])
    q = joints.positions
    assert np.all(relative_errors(facing, q) < (1e-5, np.radians(0.001)))
    between = np.vstack([q[:-1] + part * np.diff(q, axis=0) for part in (0.3, 0.5)])
    assert np.all(relative_errors(facing, between) < (1e-4, np.radians(0.02)))
    assert facing.check(joints, []).ok


def test_an_object_is_held_at_one_kilohertz(facing):
    retimed = lt.retime(facing.follow(carry(), GRASPS), facing.limits)
    assert lt.check_limits(retimed, facing.limits).ok
    q = retimed.positions
    rows = np.vstack([q, 0.5 * (q[1:] + q[:-1])])[::7]
    assert np.all(relative_errors(facing, rows) < (1e-5, np.radians(0.001)))


def test_samples_are_added_until_the_tolerance_holds(facing):
    coarse = carry(9)
    for tolerance in ((1e-4, 3.5e-4), (1e-5, 3.5e-5)):
        joints = facing.follow(coarse, GRASPS, tolerance=tolerance)
        middles = 0.5 * (joints.positions[1:] + joints.positions[:-1])
        assert np.all(relative_errors(facing, middles) < tolerance)
        assert len(joints) > len(coarse)
        at = joints.times[-1]
        assert at >= coarse.times[-1]


def test_a_tip_may_move_on_the_object_that_the_other_holds(facing):
    """As one that wipes; between samples too, where both motions are straight."""
    motion = carry(41)
    motion = lt.PoseTrajectory(3.0 * motion.times, motion.positions, motion.orientations)
    u = np.linspace(0.0, 1.0, len(motion))
    angle = 4 * np.pi * u**3 * (10 - 15 * u + 6 * u**2)
    wiping = np.column_stack([0.04 * np.cos(angle), 0.03 * np.sin(angle) - 0.15, 0.002 * angle])
    over = lt.PoseTrajectory(motion.times, wiping, np.tile(DOWN, (41, 1)))
    joints = facing.follow(motion, (GRASPS[0], over), scene=[])
    assert len(joints) > len(motion)
    q = np.vstack([joints.positions, 0.5 * (joints.positions[1:] + joints.positions[:-1])])
    at = np.interp(joints.times, [0.0, joints.duration], motion.times[[0, -1]])
    np.testing.assert_allclose(at, joints.times)  # nothing had to be slowed
    at = np.concatenate([at, 0.5 * (at[1:] + at[:-1])])
    wanted = [transform(*GRASPS[0]).actInv(transform(*over.at(time))) for time in at]
    assert np.all(errors_from(facing, q, wanted) < (1e-4, np.radians(0.02)))
    short = lt.PoseTrajectory(motion.times[:9], wiping[:9], np.tile(DOWN, (9, 1)))
    refused(
        r"grasps\[1\]: expected a motion from 0 to 12 s", facing.follow, motion, (GRASPS[0], short)
    )


def test_both_arms_are_slowed_alike(facing):
    fast = carry()
    fast = lt.PoseTrajectory(0.1 * fast.times, fast.positions, fast.orientations)
    joints = facing.follow(fast, GRASPS)
    assert joints.times[-1] > 1.5 * fast.times[-1]
    assert np.abs(joints.velocities).max(axis=0) == pytest.approx(
        np.minimum(np.abs(joints.velocities).max(axis=0), facing.limits.velocity), rel=1e-6
    )


def test_other_postures_are_paired_where_the_first_ones_touch(panda):
    """Forearms meet when the bases are 0.4 m apart."""
    near = lt.DualArm(panda, panda, ((0.0, -0.4, 0.0), (1.0, 0.0, 0.0, 0.0)))
    motion = carry()
    path = motion.positions + np.array([-0.1, 0.15, -0.1])
    motion = lt.PoseTrajectory(motion.times, path, motion.orientations)
    across = rotations.compose([[np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)]], [DOWN])[0]
    grasps = (((0.0, 0.12, 0.0), across), ((0.0, -0.12, 0.0), across))
    assert not near.check(near.follow(motion, grasps), []).ok
    assert near.check(near.follow(motion, grasps, scene=[]), []).ok


def scene_of_a_known_motion(dual, rng):
    """A carry, the grasps, and five boxes of which a motion in random postures keeps clear."""
    gap = -dual.base[0][1]
    while True:
        low, high = [0.3, -gap / 2 - 0.15, 0.15], [0.6, -gap / 2 + 0.15, 0.55]
        ends = rng.uniform(low, high, (2, 3))
        s = carry().positions[:, 2, None] * 4.0 - 1.2  # from 0 to 1
        turns = rotations.exp(s * rng.uniform(-0.3, 0.3, 3))
        motion = lt.PoseTrajectory(carry().times, ends[0] + s * (ends[1] - ends[0]), turns)
        width, spin, tilt = rng.uniform([0.1, 0.0, 0.0], [0.2, 2 * np.pi, 0.6])
        grasps = tuple(((0.0, side * width, 0.0), hand(-side * tilt, spin)) for side in (1.0, -1.0))
        posture = rng.uniform(dual.limits.lower, dual.limits.upper)
        options = lt.arm.FollowOptions(posture=posture)
        try:
            known = dual.follow(motion, grasps, q0=posture, options=options)
        except IkFailure:
            continue
        if dual.is_clear(known, lt.Scene(margin=0.01)):
            return motion, grasps, boxes_beside(dual, known, rng)


def hand(tilt, spin):
    return rotations.compose(
        rotations.compose(rotations.exp([[tilt, 0.0, 0.0]]), [DOWN]),
        rotations.exp([[0.0, 0.0, spin]]),
    )[0]


def boxes_beside(dual, known, rng):
    """Five boxes at most 5 cm or so beside a motion, and at least 1 cm."""
    boxes, gap = [], -dual.base[0][1]
    while len(boxes) < 5:
        center = rng.uniform([-0.4, -gap - 0.5, 0.05], [0.9, 0.5, 1.0])
        size, turn = rng.uniform(0.1, 0.5, 3), rotations.exp([rng.normal(size=3)])[0]
        wide = lt.Scene([lt.Box(size + 0.1, center, turn)], 0.01)
        box = lt.Box(size, center, turn)
        near = not dual.is_clear(known.positions[::4], wide).all()
        if near and dual.is_clear(known, lt.Scene([box], 0.01)):
            boxes.append(box)
    return boxes


@pytest.mark.parametrize(("gap", "seed"), [(0.4, 32), (0.4, 58), (0.6, 48), (0.8, 0)])
def test_scenes_with_a_known_motion_are_solved_and_coal_finds_them_clear(panda, gap, seed):
    """In all but the last, no postures near to the first ones are clear."""
    base = ((0.0, -gap, 0.0), (1.0, 0.0, 0.0, 0.0))
    pair = lt.DualArm(panda, panda, base)
    motion, grasps, boxes = scene_of_a_known_motion(pair, np.random.default_rng(seed))
    q = pair.follow(motion, grasps, scene=boxes).positions
    peer = CoalArm(
        lt.Arm.from_urdf(rerooted(panda, base), base=f"left_{panda.tip}", tip=f"right_{panda.tip}")
    )
    between = [names for names in pair.collision_pairs.checked if names[0][:5] != names[1][:5]]
    moving = {name for names in between for name in names if not name.endswith("link0")}
    for row in (q[:-1] + 0.4 * np.diff(q, axis=0))[::6]:
        peer.place(in_chain(row[None])[0])
        left_base = transform(*panda.forward_kinematics(row[:7])).inverse()
        for geometry, pose in map(peer.solid, boxes):
            assert peer.distance_to(moving, geometry, left_base * pose) > 0.005
        assert min(peer.link_distance(*names) for names in between) > 0.005


def test_refusals_name_arm_sample_and_bodies(facing, panda):
    away = carry()
    path = away.positions + np.array([0.0, -0.6, 0.0])
    away = lt.PoseTrajectory(away.times, path, away.orientations)
    with pytest.raises(IkFailure, match=r"^left arm: sample \d+"):
        facing.follow(away, GRASPS)
    box = lt.Box((0.4, 0.1, 0.2), (0.45, -0.35, 0.4))
    blocked = r"^(left|right) arm: sample \d+ at .* s: blocked, .*obstacle 0"
    with pytest.raises(IkFailure, match=blocked) as raising:
        facing.follow(carry(), GRASPS, scene=[box])
    assert raising.value.status == "blocked"
    at_once = tuple(((0.0, 0.2 * y, 0.0), orientation) for (_, y, _), orientation in GRASPS)
    between = r"^both arms: sample \d+ at .* s: blocked, left_panda_\w+ and right_panda_\w+ come"
    with pytest.raises(IkFailure, match=between):
        facing.follow(carry(), at_once, scene=[])


def test_bad_arguments_are_named(facing, panda):
    ur3 = lt.Arm.load("ur3")
    refused("base: expected the pose of the right base", lt.DualArm, panda, ur3)
    refused("right: expected no joint in common", lt.DualArm, panda, panda)
    refused("base: expected", lt.DualArm, panda, panda, (0.0, 0.0, 0.0))
    refused("arm: expected an Arm", lt.DualArm, panda, None, BASE)
    refused("grasps: expected", facing.follow, carry(), GRASPS[:1])
    refused("tolerance in m", facing.follow, carry(), GRASPS, tolerance=(0.0, 1.0))
    refused("motion: expected a PoseTrajectory", facing.follow, None, GRASPS)
    free = lt.arm.FollowOptions(free=["rz"])
    refused("free: expected none", facing.follow, carry(), GRASPS, options=free)


def test_a_held_object_is_checked_but_not_against_the_hands_that_hold_it(facing):
    """A tray of 0.24 m between the fingers; a crate up to the forearms does not fit."""
    motion = carry()
    tray = lt.Box((0.2, 0.24, 0.02), (0.0, 0.0, 0.0))
    crate = lt.Box((0.6, 0.24, 0.5), (0.0, 0.0, 0.3))
    held = facing.with_object(tray, GRASPS)
    assert held.check(held.follow(motion, GRASPS, scene=[]), []).ok
    with pytest.raises(IkFailure, match="attached"):
        facing.with_object(crate, GRASPS).follow(motion, GRASPS, scene=[])
    names = held.collision_pairs
    assert names.left_out["left_attached", "right_panda_hand"] == "adjacent"


def test_two_arms_of_one_robot_share_its_other_links():
    """Two arms of one joint each on a common body, with a hand that hangs from either."""
    document = two_armed()
    left, right = (
        lt.Arm.from_urdf(document, base="body", tip=f"{side}_hand") for side in ("left", "right")
    )
    dual = lt.DualArm(left, right)
    assert dual.joint_names == ("left_shoulder", "right_shoulder")
    # Hands at (-1, 1.2) and (1, 1.2) when both arms point forwards.
    assert dual.distance([0.0, 0.0], []) == pytest.approx(2.0 - 0.2, abs=1e-7)
    inwards = np.array([np.pi / 4, -np.pi / 4])  # about z: the right hand goes left
    gap = 2.0 * (1.0 - 1.2 * np.sin(np.pi / 4)) - 0.2
    assert dual.distance(-inwards, []) == pytest.approx(gap, abs=1e-7)
    assert ("left_hand", "right_hand") in dual.collision_pairs.checked
    assert dual.self_distance([0.0, 0.0]) == left.self_distance([0.0])


def two_armed():
    ball = (
        '<collision><origin xyz="0 1.2 0"/><geometry><sphere radius="0.1"/></geometry></collision>'
    )
    limit = '<limit lower="-3" upper="3" velocity="2" effort="3"/>'
    arms = "".join(
        f'<link name="{side}_hand">{ball.format(1.2)}</link>'
        f'<joint name="{side}_shoulder" type="revolute">'
        f'<parent link="body"/><child link="{side}_hand"/><origin xyz="{x} 0 0"/>'
        f'<axis xyz="0 0 1"/>{limit}</joint>'
        for side, x in (("left", -1), ("right", 1))
    )
    post = (
        '<collision><origin xyz="0 0.9 0"/><geometry><sphere radius="0.1"/></geometry></collision>'
    )
    return f'<robot name="two"><link name="body">{post}</link>{arms}</robot>'
