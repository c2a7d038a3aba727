import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput


def errors(arm, q, positions, orientations):
    reached, turned = arm.forward_kinematics(q)
    return (
        np.linalg.norm(reached - positions, axis=-1),
        lt.rotations.distance(np.atleast_2d(turned), np.atleast_2d(orientations)),
    )


def assert_inside(arm, q):
    assert (q >= arm.limits.lower).all()
    assert (q <= arm.limits.upper).all()


@pytest.mark.parametrize("midrange", [0.0, 1.0])
def test_every_reachable_target_is_reached_inside_the_limits(arm, random_configurations, midrange):
    positions, orientations = arm.forward_kinematics(random_configurations(arm, 500, 1))
    batch = arm.inverse_kinematics_batch(
        positions,
        orientations,
        q0=random_configurations(arm, 500, 2),
        options=lt.arm.IkOptions(nullspace_gain=midrange),
    )
    assert batch.success.all()
    assert set(batch.status) == {"converged"}
    assert_inside(arm, batch.q)
    distance, angle = errors(arm, batch.q, positions, orientations)
    assert distance.max() < 1e-5
    assert angle.max() < 1e-5
    np.testing.assert_allclose(distance, batch.position_error, atol=1e-12)
    np.testing.assert_allclose(angle, batch.orientation_error, atol=1e-9)


def test_positions_alone_are_reached(arm, random_configurations):
    positions, _ = arm.forward_kinematics(random_configurations(arm, 100, 3))
    batch = arm.inverse_kinematics_batch(positions)
    assert batch.success.all()
    np.testing.assert_allclose(arm.forward_kinematics(batch.q)[0], positions, atol=2e-6)
    assert (batch.orientation_error == 0).all()


def test_one_target_is_solved_like_a_batch_of_one(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    one = arm.inverse_kinematics(position, orientation)
    batch = arm.inverse_kinematics_batch([position], [orientation])
    np.testing.assert_array_equal(one.q, batch.q[0])
    assert one.success
    assert one.status == "converged"
    assert one.iterations == batch.iterations[0]


def test_threads_and_repetition_do_not_change_a_bit(arm, random_configurations):
    positions, orientations = arm.forward_kinematics(random_configurations(arm, 60, 4))
    first = arm.inverse_kinematics_batch(positions, orientations)
    for threads in (1, 2, 5):
        again = arm.inverse_kinematics_batch(positions, orientations, threads=threads)
        np.testing.assert_array_equal(first.q, again.q)


def test_a_seed_on_the_target_stays(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    result = arm.inverse_kinematics(position, orientation, q0=posture)
    np.testing.assert_allclose(result.q, posture, atol=1e-12)
    assert result.iterations == 0


def test_a_seed_outside_the_limits_is_moved_inside(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    result = arm.inverse_kinematics(position, orientation, q0=np.full(len(posture), 1e3))
    assert result.success
    assert_inside(arm, result.q)


def test_self_motion_leaves_the_tool_and_nears_the_middle(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    plain = arm.inverse_kinematics(position, orientation, q0=posture)
    moved = arm.inverse_kinematics(
        position, orientation, q0=posture, options=lt.arm.IkOptions(nullspace_gain=1.0)
    )
    reached, _ = arm.forward_kinematics(moved.q)
    assert np.linalg.norm(reached - position) < 1e-6
    if len(posture) == 6:
        np.testing.assert_array_equal(plain.q, moved.q)
        return
    middle = 0.5 * (arm.limits.lower + arm.limits.upper)
    assert np.linalg.norm(moved.q - middle) < np.linalg.norm(plain.q - middle) - 0.01


def test_after_self_motion_the_null_space_pulls_no_further(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    q = arm.inverse_kinematics(
        position, orientation, q0=posture, options=lt.arm.IkOptions(nullspace_gain=1.0)
    ).q
    if len(q) == 6:
        return
    pull = 0.5 * (arm.limits.lower + arm.limits.upper) - q
    jacobian = arm.jacobian(q)
    free = pull - np.linalg.pinv(jacobian) @ (jacobian @ pull)
    inside = (q > arm.limits.lower) & (q < arm.limits.upper)
    assert not inside.all() or np.linalg.norm(free) < 0.05


def test_a_target_beyond_the_arm_is_unreachable(arm):
    result = arm.inverse_kinematics([9.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0])
    assert not result.success
    assert result.status == "unreachable"
    assert result.position_error > 5.0
    assert_inside(arm, result.q)


def test_a_target_just_out_of_reach_ends_with_the_closest_found(arm, random_configurations):
    positions, orientations = arm.forward_kinematics(random_configurations(arm, 2000, 5))
    farthest = np.argmax(np.linalg.norm(positions, axis=1))
    # Turned around, the hand would have to reach out and back at once.
    target = 1.05 * positions[farthest]
    back = lt.rotations.compose(orientations[farthest][None], [[0.0, 1.0, 0.0, 0.0]])[0]
    result = arm.inverse_kinematics(target, back)
    assert not result.success
    assert result.status in {"limits", "unreachable", "budget"}
    assert_inside(arm, result.q)
    reached, _ = arm.forward_kinematics(result.q)
    assert np.linalg.norm(reached - target) == pytest.approx(result.position_error)


def test_an_empty_batch_gives_an_empty_answer(arm):
    batch = arm.inverse_kinematics_batch(np.empty((0, 3)), np.empty((0, 4)))
    assert len(batch) == 0
    assert batch.q.shape == (0, len(arm.joint_names))


@pytest.mark.parametrize(
    "arguments",
    [
        {"position": [np.nan, 0, 0]},
        {"position": [0, 0]},
        {"position": "here"},
        {"position": [0, 0, 0], "orientation": [0, 0, 0, 0]},
        {"position": [0, 0, 0], "orientation": [np.inf, 0, 0, 0]},
        {"position": [0, 0, 0], "q0": [1, 2]},
        {"position": [0, 0, 0], "seed": -1},
        {"position": [0, 0, 0], "options": {"free": "rz"}},
    ],
)
def test_bad_arguments_are_refused(arm, arguments):
    with pytest.raises(InvalidInput):
        arm.inverse_kinematics(**arguments)


@pytest.mark.parametrize(
    "option",
    [
        {"position_tolerance": 0.0},
        {"nullspace_gain": 2.0},
        {"max_iterations": 0},
        {"max_restarts": 1.5},
    ],
)
def test_bad_options_are_refused(option):
    with pytest.raises(InvalidInput, match=next(iter(option))):
        lt.arm.IkOptions(**option)


@pytest.mark.parametrize(
    "method", ["inverse_kinematics", "inverse_kinematics_batch", "inverse_kinematics_all"]
)
def test_a_configuration_given_as_seed_is_refused_and_q0_named(arm, method):
    positions = np.zeros((2, 3)) if method.endswith("batch") else np.zeros(3)
    with pytest.raises(InvalidInput, match=r"seed: .* q0"):
        getattr(arm, method)(positions, seed=np.zeros(len(arm.joint_names)))


def test_a_batch_with_ragged_arguments_is_refused(arm):
    with pytest.raises(InvalidInput):
        arm.inverse_kinematics_batch(np.zeros((3, 3)), np.zeros((2, 4)))
    with pytest.raises(InvalidInput):
        arm.inverse_kinematics_batch(np.zeros((3, 3)), threads=0)
    with pytest.raises(InvalidInput):
        arm.inverse_kinematics_batch(np.zeros((3, 3)), q0=np.zeros((2, 6)))


def test_huge_targets_end_with_a_verdict(arm):
    result = arm.inverse_kinematics([1e300, -1e300, 1e300], [1.0, 0.0, 0.0, 0.0])
    assert result.status == "unreachable"
    assert_inside(arm, result.q)
