"""Which posture: the closest one and all of them, the UR3's against its closed form."""

import numpy as np
import pytest
from motions import configurations

import leadthrough as lt
from leadthrough.arm import IkOptions

UR3 = lt.Arm.load("ur3")
PANDA = lt.Arm.load("panda")

# m, from the URDF: height of the shoulder, upper arm, forearm, and the wrist's three offsets.
D1, A2, A3, D4, D5, D6 = 0.1519, 0.24365, 0.21325, 0.1198 - 0.0925 + 0.08505, 0.08535, 0.0819


def ur_solutions(position, orientation):
    """Every posture (m, 6) of the UR3, by geometry: its axes 2, 3 and 4 are parallel."""
    tool = lt.rotations.to_matrix(orientation[None])[0]
    wrist = position - D6 * tool[:, 2]  # on the last two axes
    found = []
    reach = np.hypot(*wrist[:2])
    if reach < D4:
        return np.empty((0, 6))
    for pan in (
        np.arctan2(wrist[1], wrist[0])
        + np.array([0, -np.pi])
        + np.array([-1, 1]) * np.arcsin(D4 / reach)
    ):
        normal = np.array([-np.sin(pan), np.cos(pan), 0.0])  # of the plane that the arm moves in
        out = np.array([np.cos(pan), np.sin(pan), 0.0])
        bend = np.arccos(np.clip(normal @ tool[:, 2], -1, 1))
        for q5 in (bend, -bend):
            x = (np.cos(q5) * normal - tool[:, 2]) / np.sin(q5)
            frame = np.column_stack([x, normal, np.cross(x, normal)])
            last = (frame @ turn(2, q5)).T @ tool @ turn(0, np.pi / 2)
            ankle = wrist - D5 * frame[:, 2]
            flat = np.array([out @ ankle, ankle[2] - D1])
            cosine = (flat @ flat - A2**2 - A3**2) / (2 * A2 * A3)
            if abs(cosine) > 1:
                continue
            for q3 in (np.arccos(cosine), -np.arccos(cosine)):
                q2 = np.arctan2(*flat) - np.arctan2(A3 * np.sin(q3), A2 + A3 * np.cos(q3))
                q2 -= np.pi / 2
                q4 = np.arctan2(-x[2], out @ x) - np.pi - q2 - q3
                found.append([pan, q2, q3, q4, q5, np.arctan2(last[0, 2], last[0, 0])])
    return np.array(found).reshape(-1, 6)


def turn(axis, angle):
    return lt.rotations.to_matrix(lt.rotations.exp([angle * np.eye(3)[axis]]))[0]


def turns_apart(a, b):
    return np.abs(np.angle(np.exp(1j * (a - b)))).max(axis=-1)


def comfortable(arm, count, seed):
    """Away from singularities, where postures merge."""
    rng = np.random.default_rng(seed)
    found = []
    while len(found) < count:
        q = rng.uniform(-np.pi, np.pi, len(arm.joint_names))
        if np.linalg.cond(arm.jacobian(q)) < 40:
            found.append(q)
    return np.array(found)


def test_the_closed_form_reaches_the_pose():
    for q in comfortable(UR3, 20, seed=0):
        position, orientation = UR3.forward_kinematics(q)
        every = ur_solutions(position, orientation)
        assert turns_apart(every, q).min() < 1e-6
        reached, turned = UR3.forward_kinematics(every)
        np.testing.assert_allclose(reached, np.tile(position, (len(every), 1)), atol=1e-9)
        assert lt.rotations.distance(turned, np.tile(orientation, (len(every), 1))).max() < 1e-7


def test_all_postures_of_a_ur3_are_those_of_its_closed_form():
    complete = 0
    for q in comfortable(UR3, 40, seed=1):
        position, orientation = UR3.forward_kinematics(q)
        expected = ur_solutions(position, orientation)
        found = UR3.inverse_kinematics_all(position, orientation, count=64)
        assert found.success.all()
        for row in found.q:
            assert turns_apart(expected, row).min() < 1e-4
        complete += len(found) == len(expected)
        assert len(found) <= len(expected)
    assert complete >= 39


def test_all_postures_come_by_their_distance_and_are_distinct(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    found = arm.inverse_kinematics_all(
        position, orientation, options=IkOptions(posture=posture), count=5
    )
    distances = np.linalg.norm(found.q - posture, axis=1)
    assert 1 <= len(found) <= 5
    assert (np.diff(distances) >= 0).all()
    assert distances[0] < 1e-4
    for i, row in enumerate(found.q):
        assert (turns_apart(found.q[:i], row) > 0.1).all()
        reached, turned = arm.forward_kinematics(row)
        assert np.linalg.norm(reached - position) < 2e-6
        assert lt.rotations.distance(turned[None], orientation[None])[0] < 2e-6


def test_the_closest_solution_of_a_ur3_is_that_of_its_closed_form():
    for q, reference in np.stack(
        [comfortable(UR3, 40, seed=2), comfortable(UR3, 40, seed=3)], axis=1
    ):
        position, orientation = UR3.forward_kinematics(q)
        every = ur_solutions(position, orientation)
        nearest = reference + np.angle(np.exp(1j * (every - reference)))
        inside = ((nearest >= UR3.limits.lower) & (nearest <= UR3.limits.upper)).all(axis=1)
        best = np.linalg.norm(nearest - reference, axis=1)[inside].min()
        result = UR3.inverse_kinematics(
            position,
            orientation,
            options=IkOptions(
                mode="closest", posture=reference, max_restarts=400, max_iterations=10_000
            ),
        )
        assert result.success
        assert np.linalg.norm(result.q - reference) == pytest.approx(best, abs=1e-4)


def test_the_closest_of_a_redundant_arm_cannot_be_moved_closer():
    """No other solution is closer, and the null space leads no closer but through a limit."""
    rng = np.random.default_rng(4)
    for _ in range(10):
        q, reference = rng.uniform(PANDA.limits.lower, PANDA.limits.upper, (2, 7))
        pose = PANDA.forward_kinematics(q)
        result = PANDA.inverse_kinematics(
            *pose, options=IkOptions(mode="closest", posture=reference)
        )
        assert result.success
        many = PANDA.inverse_kinematics_batch(
            *(np.tile(part, (100, 1)) for part in pose),
            q0=rng.uniform(PANDA.limits.lower, PANDA.limits.upper, (100, 7)),
        )
        others = np.linalg.norm(many.q - reference, axis=1)
        assert np.linalg.norm(result.q - reference) < others.min() + 1e-9
        jacobian = PANDA.jacobian(result.q)
        pull = reference - result.q
        rest = pull - np.linalg.pinv(jacobian) @ (jacobian @ pull)
        room = np.minimum(result.q - PANDA.limits.lower, PANDA.limits.upper - result.q)
        assert room.min() < 1e-3 or np.linalg.norm(rest) < 0.2


def test_the_posture_is_the_start_and_the_start_the_posture(arm, posture):
    pose = arm.forward_kinematics(configurations(arm, 1, 5)[0])
    by_start = arm.inverse_kinematics(*pose, options=IkOptions(mode="closest"), q0=posture)
    by_posture = arm.inverse_kinematics(*pose, options=IkOptions(mode="closest", posture=posture))
    np.testing.assert_array_equal(by_start.q, by_posture.q)
