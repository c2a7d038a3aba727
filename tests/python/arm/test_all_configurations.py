"""All configurations for a pose: the closed form against the search, and against known answers."""

import re

import foreign_arms
import numpy as np
import pytest

import leadthrough as lt
from leadthrough.arm import IkOptions

TIPS = {
    "ur3": ("example-robot-data", "ur3_robot.urdf"),
    "ur5": ("example-robot-data", "ur5_robot.urdf"),
    "kr16": ("rtb-data", "kr16_2.urdf"),
    "puma": ("rtb-data", "puma560_robot.urdf"),
}
UR3 = lt.Arm.load("ur3")
PANDA = lt.Arm.load("panda")
TURN = 2.0 * np.pi


def load(name):
    try:
        path = foreign_arms.urdf_in_package(*TIPS[name])
    except Exception:  # neither package is a dependency
        pytest.skip(f"{name} is not installed")
    tip = None if name == "puma" else "tool0"
    return lt.Arm.from_urdf(path, tip=tip)


def configurations(arm, count, seed):
    lower, upper = (np.clip(each, -TURN, TURN) for each in (arm.limits.lower, arm.limits.upper))
    return np.random.default_rng(seed).uniform(lower, upper, (count, len(lower)))


def away(rows, q):
    """Largest difference (m,) of a joint, whole turns left out."""
    return np.abs(np.remainder(rows - q + np.pi, TURN) - np.pi).max(axis=1, initial=0.0)


def assert_found_again(arm, q, reference):
    position, orientation = arm.forward_kinematics(q)
    found = arm.inverse_kinematics_all(position, orientation, options=IkOptions(posture=reference))
    assert found.complete
    assert away(found.q, q).min() < 1e-4
    tips, turned = arm.forward_kinematics(found.q)
    np.testing.assert_allclose(tips, np.tile(position, (len(found), 1)), atol=1e-6)
    assert lt.rotations.distance(turned, np.tile(orientation, (len(found), 1))).max() < 1e-6
    assert (found.q >= arm.limits.lower).all() and (found.q <= arm.limits.upper).all()
    distances = np.linalg.norm(found.q - reference, axis=1)
    assert (np.diff(distances) >= 0.0).all()
    for shift in (-TURN, TURN):
        moved = found.q + shift
        inside = (moved >= arm.limits.lower) & (moved <= arm.limits.upper)
        nearer = np.abs(moved - reference) < np.abs(found.q - reference) - 1e-9
        assert not (inside & nearer).any()
    for i, row in enumerate(found.q):
        assert (away(found.q[:i], row) > 1e-6).all()


@pytest.mark.parametrize("name", TIPS)
def test_every_configuration_is_found_again_with_its_nearest_turns(name):
    arm = load(name)
    for q, reference in zip(configurations(arm, 100, 1), configurations(arm, 100, 2), strict=True):
        assert_found_again(arm, q, reference)


@pytest.mark.parametrize("offset", [1e-2, 1e-3])
def test_beside_a_singular_wrist_nothing_is_lost(offset):
    for q, reference in zip(configurations(UR3, 50, 3), configurations(UR3, 50, 4), strict=True):
        q[4] = offset
        assert_found_again(UR3, q, reference)


def within_half_turns():
    limit = re.compile('(lower|upper)="(-?)[0-9.]+"')
    document = limit.sub(r'\1="\g<2>3.14159265"', UR3.document)
    return lt.Arm.from_urdf(document, base=UR3.base, tip=UR3.tip)


@pytest.mark.parametrize("joint", [2, 4])
@pytest.mark.parametrize("arm", [UR3, within_half_turns()], ids=["turns", "half turns"])
def test_however_near_a_singularity_no_configuration_is_lost_and_the_nearest_is_found(arm, joint):
    rng = np.random.default_rng(8)
    lower, upper = np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)
    for q, reference in rng.uniform(lower, upper, (1500, 2, 6)):
        offset = 10.0 ** rng.uniform(-8.0, -2.0)
        q[joint] = rng.choice([offset, -offset, np.pi - offset, offset - np.pi])
        if (q < lower).any() or (q > upper).any():
            continue
        pose = arm.forward_kinematics(q)
        assert away(arm.inverse_kinematics_all(*pose, q0=q).q, q).min() < 1e-3
        nearest = arm.inverse_kinematics_all(*pose, q0=reference).q[0]
        assert np.linalg.norm(nearest - reference) < np.linalg.norm(q - reference) + 1e-4


def test_the_closed_form_finds_all_that_the_search_finds():
    by_search = IkOptions(weights=[1, 1, 1, 1, 1, 1.001])  # weights leave the closed form out
    for name in ("ur3", "kr16"):
        arm = load(name)
        for q in configurations(arm, 5, 5):
            pose = arm.forward_kinematics(q)
            expected = arm.inverse_kinematics_all(*pose, options=by_search, count=64)
            assert not expected.complete
            found = arm.inverse_kinematics_all(*pose)
            for row in expected.q:
                assert away(found.q, row).min() < 1e-3


def test_a_straight_wrist_has_the_nearest_of_its_configurations_and_all_isolated_ones():
    q = np.array([0.4, -1.1, 1.3, 0.5, 0.0, 0.7])
    pose = UR3.forward_kinematics(q)
    found = UR3.inverse_kinematics_all(*pose, options=IkOptions(posture=q))
    assert found.complete
    assert np.linalg.norm(found.q[0] - q) < 1e-4
    # The other shoulder's wrist is bent: these two elbows and two wrists are isolated.
    bent = found.q[np.abs(np.sin(found.q[:, 4])) > 1e-3]
    by_search = UR3.inverse_kinematics_all(
        *pose, count=64, options=IkOptions(weights=[1, 1, 1, 1, 1, 1.001], posture=q)
    ).q
    isolated = by_search[np.abs(np.sin(by_search[:, 4])) > 1e-2]
    for row in isolated:
        assert away(bent, row).min() < 1e-3


def test_a_reversed_axis_changes_signs_only():
    lower, upper = UR3.limits.lower, UR3.limits.upper
    assert np.allclose(lower[:5], -upper[:5])
    parts = re.split(r'(<axis xyz="0 1 0"\s*/>)', UR3.document)
    parts[3] = '<axis xyz="0 -1 0"/>'
    reversed_arm = lt.Arm.from_urdf("".join(parts), base=UR3.base, tip=UR3.tip)
    for q in configurations(UR3, 20, 6):
        assert_found_again(reversed_arm, q, np.zeros(6))


def test_the_reason_for_no_configuration_is_exact():
    home = np.array([0.3, -1.2, 1.4, -0.8, 1.1, 0.2])
    position, orientation = UR3.forward_kinematics(home)
    beyond = UR3.inverse_kinematics_all(3.0 * position, orientation)
    assert beyond.complete and beyond.reason == "unreachable" and len(beyond) == 0
    assert UR3.inverse_kinematics(3.0 * position, orientation).status == "unreachable"


def test_beyond_the_limits_is_told_from_unreachable():
    arm = load("kr16")
    rng = np.random.default_rng(7)
    seen = set()
    for _ in range(60):
        orientation = rng.normal(size=4)
        orientation /= np.linalg.norm(orientation)
        position = rng.uniform([-1.8, -1.8, -0.5], [1.8, 1.8, 2.2])
        found = arm.inverse_kinematics_all(position, orientation)
        assert found.complete
        if len(found):
            assert found.reason == "converged"
            continue
        seen.add(found.reason)
        single = arm.inverse_kinematics(position, orientation)
        assert single.status == found.reason
        assert (single.status == "limits") == bool(single.limiting_joints)
    assert seen == {"limits", "unreachable"}


def test_the_closest_of_six_joints_is_the_first_of_all():
    for q, posture in zip(configurations(UR3, 30, 8), configurations(UR3, 30, 9), strict=True):
        pose = UR3.forward_kinematics(q)
        options = IkOptions(mode="closest", posture=posture)
        every = UR3.inverse_kinematics_all(*pose, options=options)
        closest = UR3.inverse_kinematics(*pose, options=options)
        np.testing.assert_array_equal(closest.q, every.q[0])


def calibrated(document):
    """The robot with its joints moved by up to half a millimetre and a milliradian."""
    rng = np.random.default_rng(10)

    def disturbed(match):
        values = [float(text) for text in match[2].split()]
        scale = 5e-4 if match[1] == "xyz" else 1e-3
        return f'{match[1]}="{" ".join(repr(v + rng.uniform(-scale, scale)) for v in values)}"'

    joints = re.compile(r"<joint name.*?</joint>", re.S)
    return joints.sub(
        lambda joint: re.sub(
            r"<origin[^>]*>",
            lambda origin: re.sub(r'(xyz|rpy)="([^"]*)"', disturbed, origin[0]),
            joint[0],
        ),
        document,
    )


def test_a_calibrated_arm_loses_nothing():
    arm = lt.Arm.from_urdf(calibrated(UR3.document), base=UR3.base, tip=UR3.tip)
    complete = 0
    for q in configurations(arm, 60, 11):
        pose = arm.forward_kinematics(q)
        found = arm.inverse_kinematics_all(*pose, count=64)
        assert away(found.q, q).min() < 1.1e-4
        complete += found.complete
    assert complete > 30


def test_a_calibrated_arm_of_two_spheres_is_swept_like_an_ideal_one():
    """As a Kinova Gen3, whose URDF is rounded."""
    links = "".join(f'<link name="l{k}"/>' for k in range(8))
    joints = "".join(
        f'<joint name="j{k}" type="revolute"><parent link="l{k}"/><child link="l{k + 1}"/>'
        f'<origin xyz="0 0 {height}" rpy="0 0 0"/><axis xyz="{axis}"/>'
        '<limit lower="-2.6" upper="2.6" velocity="1" effort="1"/></joint>'
        for k, (height, axis) in enumerate(
            zip((0.3, 0, 0, 0.4, 0, 0.4, 0), ("0 0 1", "0 1 0") * 3 + ("0 0 1",), strict=True)
        )
    )
    ideal = f'<robot name="spheres">{links}{joints}</robot>'
    for document in (ideal, calibrated(ideal)):
        arm = lt.Arm.from_urdf(document)
        for q, reference in zip(
            configurations(arm, 30, 12), configurations(arm, 30, 13), strict=True
        ):
            pose = arm.forward_kinematics(q)
            closest = IkOptions(mode="closest", posture=reference)
            result = arm.inverse_kinematics(*pose, options=closest)
            assert result.success
            assert np.linalg.norm(result.q - reference) < np.linalg.norm(q - reference) + 1e-6


def test_seven_joints_are_swept_at_the_stated_resolution():
    q = np.array([0.3, -0.5, 0.2, -2.0, 0.1, 1.7, 0.5])
    found = PANDA.inverse_kinematics_all(*PANDA.forward_kinematics(q), options=IkOptions(posture=q))
    assert not found.complete
    last = PANDA.limits.upper[6] - PANDA.limits.lower[6]
    assert found.resolution == pytest.approx(last / 192)
    assert np.linalg.norm(found.q[0] - q) < 1e-3


def test_other_arms_are_searched():
    tiago = lt.Arm.load("tiago")
    middle = 0.5 * (tiago.limits.lower + tiago.limits.upper)
    found = tiago.inverse_kinematics_all(*tiago.forward_kinematics(middle))
    assert len(found) and not found.complete and found.resolution is None
