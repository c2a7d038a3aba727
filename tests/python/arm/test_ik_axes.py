"""Free axes, tolerances and weights of single poses, all in the target's frame."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from motions import configurations
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
