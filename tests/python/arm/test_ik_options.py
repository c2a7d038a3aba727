"""Options of inverse kinematics: free axes, tolerances, weights, and which posture."""

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from motions import configurations, urdf
from scipy.spatial.transform import Rotation

import leadthrough as lt
from leadthrough.arm import IkOptions

PANDA = lt.Arm.load("panda")


def offsets(arm, q, positions, orientations):
    """Of the tool in the target's frame: (m, 3) m and rotations (SciPy's)."""
    reached, turned = arm.forward_kinematics(q)
    frames = Rotation.from_quat(orientations, scalar_first=True)
    tools = Rotation.from_quat(turned, scalar_first=True)
    return frames.inv().apply(reached - positions), frames.inv() * tools


@pytest.fixture
def targets(arm):
    return arm.forward_kinematics(configurations(arm, 100, 1))


def solved(arm, targets, **options):
    """The offsets of solutions, all of which must be found."""
    batch = arm.inverse_kinematics_batch(*targets, options=IkOptions(**options))
    assert batch.success.all()
    return offsets(arm, batch.q, *targets)


def test_the_tool_may_spin_about_its_approach_axis(arm, targets):
    away, turned = solved(arm, targets, free=("rz",))
    assert np.abs(away).max() < 2e-6
    approach = turned.apply([0.0, 0.0, 1.0])
    np.testing.assert_allclose(approach, np.tile([0.0, 0.0, 1.0], (100, 1)), atol=2e-6)
    assert np.ptp(turned.as_rotvec()[:, 2]) > 1.0  # it does


def test_a_spin_that_no_wrist_can_make_does_not_matter(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    for spin in np.linspace(-3.1, 3.1, 7):
        turned = lt.rotations.compose(orientation[None], lt.rotations.exp([[0, 0, spin]]))[0]
        result = arm.inverse_kinematics(
            position, turned, q0=posture, options=IkOptions(free=("rz",))
        )
        assert result.iterations == 0
        np.testing.assert_array_equal(result.q, posture)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_along_a_free_axis_the_tool_may_slide(arm, targets, axis):
    away, turned = solved(arm, targets, free=("xyz"[axis],))
    assert np.abs(np.delete(away, axis, axis=1)).max() < 2e-6
    assert np.abs(away[:, axis]).max() > 0.01
    assert turned.magnitude().max() < 2e-6


def test_a_target_far_along_a_free_axis_is_reached(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    along = lt.rotations.to_matrix(orientation[None])[0][:, 0]
    result = arm.inverse_kinematics(
        position + 50.0 * along, orientation, options=IkOptions(free=("x",))
    )
    assert result.success


def test_of_two_free_rotations_the_third_is_kept(arm, targets):
    _, turned = solved(arm, targets, free=("rx", "ry"))
    x, y, z, w = turned.as_quat().T
    half = np.hypot(z, w) > 1e-3  # elsewhere the twist is undefined
    assert np.abs(np.sin(np.arctan2(z, w)))[half].max() < 1e-6
    assert np.hypot(x, y).max() > 0.1


def test_without_orientation_the_axes_are_the_bases(arm, posture):
    position, _ = arm.forward_kinematics(posture)
    above = position + np.array([0.0, 0.0, 9.0])
    result = arm.inverse_kinematics(above, options=IkOptions(free=("z",)))
    assert result.success
    np.testing.assert_allclose(arm.forward_kinematics(result.q)[0][:2], position[:2], atol=2e-6)


def test_all_rotations_free_is_a_position_alone(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    result = arm.inverse_kinematics(
        position, orientation, options=IkOptions(free=("rx", "ry", "rz"))
    )
    assert result.success
    assert result.orientation_error == 0.0


def test_tolerances_hold_for_each_axis(arm, targets):
    wide = IkOptions(position_tolerance=(1e-3, 1e-2, 1e-3), orientation_tolerance=(1e-2, 1e-2, 0.1))
    narrow = IkOptions(position_tolerance=(1e-6,) * 3, orientation_tolerance=(1e-6,) * 3)
    batch, tight = (
        arm.inverse_kinematics_batch(*targets, options=options) for options in (wide, narrow)
    )
    assert batch.success.all()
    away, turned = offsets(arm, batch.q, *targets)
    assert (np.abs(away) <= [1e-3, 1e-2, 1e-3]).all()
    assert (np.abs(turned.as_rotvec()) <= [1e-2, 1e-2, 0.1]).all()
    assert (batch.iterations <= tight.iterations).all()
    assert batch.iterations.sum() < tight.iterations.sum()


def test_weights_decide_what_gives_way(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    beyond = position * 1.2 + [0.3, 0.3, 0.3]
    place, turn = (
        arm.inverse_kinematics(
            beyond, orientation, q0=posture, options=IkOptions(weights=weights, max_restarts=0)
        )
        for weights in ([10, 10, 10, 1, 1, 1], [1, 1, 1, 10, 10, 10])
    )
    assert not place.success
    assert place.position_error < turn.position_error + 1e-3
    assert place.orientation_error > turn.orientation_error


def test_weights_do_not_move_a_target_that_is_met(arm, targets):
    away, turned = solved(arm, targets, weights=[1, 5, 1, 0.2, 1, 3])
    assert np.linalg.norm(away, axis=1).max() < 1.001e-6
    assert turned.magnitude().max() < 1.01e-6


@settings(max_examples=60, deadline=None)
@given(
    st.sets(st.sampled_from(["x", "y", "z", "rx", "ry", "rz"]), max_size=5), st.integers(0, 10_000)
)
def test_any_axes_of_a_reachable_pose_are_met_inside_the_limits(free, seed):
    q = np.random.default_rng(seed).uniform(PANDA.limits.lower, PANDA.limits.upper)
    result = PANDA.inverse_kinematics(
        *PANDA.forward_kinematics(q), options=IkOptions(free=tuple(free))
    )
    assert result.success
    assert (result.q >= PANDA.limits.lower).all()
    assert (result.q <= PANDA.limits.upper).all()


UR3 = lt.Arm.load("ur3")

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


@pytest.mark.parametrize(
    ("q", "reference", "last"),
    [
        (
            (2.197, -0.042, 1.209, -0.877, -1.103, 2.599, 0.285),
            (-1.008, -0.572, 1.576, -2.036, -1.354, 1.007, -1.071),
            0.30353,
        ),
        (
            (-0.878, 0.169, 1.455, -2.11, 2.311, 0.849, 2.186),
            (-1.709, 1.619, -2.84, -2.271, -0.175, 1.257, 0.981),
            2.30157,
        ),
    ],
)
def test_the_closest_is_found_in_a_narrow_range_beside_a_singularity(q, reference, last):
    """The last joint reaches it within a milliradian, where the first and the third turn fast."""
    pose = PANDA.forward_kinematics(q)
    held = lt.Arm.from_urdf(
        urdf("panda"), base=PANDA.base, tip=PANDA.tip, locked_joints={"panda_joint7": last}
    )
    there = held.inverse_kinematics_all(*pose, options=IkOptions(posture=reference[:6])).q[0]
    nearest = np.linalg.norm(np.append(there, last) - reference)
    result = PANDA.inverse_kinematics(*pose, q0=reference, options=IkOptions(mode="closest"))
    assert np.linalg.norm(result.q - reference) < nearest + 1e-3


def test_the_posture_is_the_start_and_the_start_the_posture(arm, posture):
    pose = arm.forward_kinematics(configurations(arm, 1, 5)[0])
    by_start = arm.inverse_kinematics(*pose, options=IkOptions(mode="closest"), q0=posture)
    by_posture = arm.inverse_kinematics(*pose, options=IkOptions(mode="closest", posture=posture))
    np.testing.assert_array_equal(by_start.q, by_posture.q)
