import pickle

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import leadthrough as lt
from leadthrough.arm import JointState
from leadthrough.errors import InvalidInput

HOME = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])


def assert_step_inside_limits(arm, before, after, dt):
    limits = arm.limits
    assert (after.q >= limits.lower).all()
    assert (after.q <= limits.upper).all()
    assert (np.abs(after.qd) <= limits.velocity * (1 + 1e-12)).all()
    if limits.acceleration is not None:
        change = np.abs(after.qd - before.qd)
        assert (change <= limits.acceleration * dt * (1 + 1e-9)).all()
    np.testing.assert_allclose(after.q, before.q + dt * after.qd, atol=1e-12)


def run(arm, ik, state, poses):
    """The last state; every step is checked against the limits."""
    for position, orientation in poses:
        following = ik.step(state, position, orientation)
        assert_step_inside_limits(arm, state, following, ik.dt)
        state = following
    return state


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["panda", "ur3", "tiago"]))
def test_limits_hold_whatever_the_target_does(seed, name):
    arm, rng = lt.Arm.load(name), np.random.default_rng(seed)
    ik = lt.DifferentialIk(arm, dt=4e-3)
    lower, upper = np.maximum(arm.limits.lower, -3), np.minimum(arm.limits.upper, 3)
    poses = []
    for _ in range(5):  # the target jumps
        pose = arm.forward_kinematics(rng.uniform(lower, upper))
        poses += [pose if rng.random() < 0.8 else (5.0 * pose[0], pose[1])] * 80
    run(arm, ik, ik.start(rng.uniform(lower, upper)), poses)


def test_the_twist_of_a_moving_target_leaves_no_lag(panda):
    ik = lt.DifferentialIk(panda)
    position, orientation = panda.forward_kinematics(HOME)
    state = ik.start(HOME)
    for k in range(3000):
        angle = 1.5e-3 * k
        offset = 0.1 * np.array([np.sin(angle), 1 - np.cos(angle), 0.0])
        velocity = 0.15 * np.array([np.cos(angle), np.sin(angle), 0.0])
        state = ik.step(state, position + offset, orientation, twist=[*velocity, 0, 0, 0])
    assert state.position_error < 2e-5


def test_the_posture_does_not_move_the_tool(panda):
    posture = HOME + np.array([0.5, 0.3, -0.5, 0.2, 0.5, 0.0, 0.0])
    ik = lt.DifferentialIk(panda, posture=posture, nullspace_gain=2.0)
    position, orientation = panda.forward_kinematics(HOME)
    state, furthest = ik.start(HOME), 0.0
    for _ in range(3000):
        state = ik.step(state, position, orientation)
        furthest = max(furthest, np.linalg.norm(panda.forward_kinematics(state.q)[0] - position))
    assert np.abs(state.q - HOME).max() > 0.2
    assert furthest < 1e-6


def test_a_stretched_arm_comes_back_without_a_jump(panda):
    ik = lt.DifferentialIk(panda, dt=2e-3)
    position, orientation = panda.forward_kinematics(HOME)
    reach = np.concatenate([np.linspace(0, 0.9, 1000), np.linspace(0.9, 0, 1000), np.zeros(1500)])
    poses = [(position + np.array([far, 0.0, 0.0]), orientation) for far in reach]
    end = run(panda, ik, ik.start(HOME), poses)
    assert end.position_error < 1e-2
    assert np.isfinite(end.q).all()


def test_positions_alone_leave_the_orientation_free(panda):
    ik = lt.DifferentialIk(panda)
    target = panda.forward_kinematics(HOME)[0] + [0.05, 0.1, 0.05]
    state = ik.start(HOME)
    for _ in range(2000):
        state = ik.step(state, target)
    assert np.linalg.norm(panda.forward_kinematics(state.q)[0] - target) < 1e-6
    assert state.orientation_error == 0.0


def test_a_joint_outside_its_limits_does_not_move_further_out(panda):
    ik = lt.DifferentialIk(panda)
    q = HOME.copy()
    q[3] = panda.limits.upper[3] + 0.1
    state = ik.start(q)
    target = panda.forward_kinematics(HOME)
    for _ in range(2000):
        following = ik.step(state, *target)
        assert following.q[3] <= max(state.q[3], panda.limits.upper[3])
        state = following
    assert state.q[3] < q[3]


def test_a_state_and_a_solver_are_left_as_they_were(panda):
    ik = lt.DifferentialIk(panda)
    state = ik.start(HOME)
    position, orientation = panda.forward_kinematics(HOME + 0.1)
    first = ik.step(state, position, orientation)
    second = pickle.loads(pickle.dumps(ik)).step(state, list(position), list(orientation))
    np.testing.assert_array_equal(first.q, second.q)
    np.testing.assert_array_equal(state.q, HOME)


@pytest.mark.parametrize(
    ("options", "arguments", "name"),
    [
        ({}, {"position": (0.1, 0.2)}, "position"),
        ({}, {"position": (np.nan, 0.0, 0.0)}, "position"),
        ({}, {"position": np.array([np.inf, 0.0, 0.0])}, "position"),
        ({}, {"position": np.array([1e30, 0.0, 0.0])}, "position"),
        ({}, {"orientation": np.zeros(4)}, "orientation"),
        ({}, {"orientation": (1.0, 0.0, 0.0)}, "orientation"),
        ({}, {"twist": np.zeros(3)}, "twist"),
        ({}, {"state": HOME}, "state"),
        ({}, {"state": JointState(HOME * np.nan, HOME)}, "state.q"),
        ({}, {"state": JointState(HOME, HOME[:3])}, "state.qd"),
        ({}, {"start": HOME[:3]}, "q"),
        ({"dt": 0.0}, {}, "dt"),
        ({"gain": np.nan}, {}, "gain"),
        ({"posture": HOME[:2]}, {}, "posture"),
        ({"nullspace_gain": -1.0}, {}, "nullspace_gain"),
    ],
)
def test_solvers_starts_and_steps_that_make_no_sense_are_refused(panda, options, arguments, name):
    whole = {"start": HOME, "position": (0.4, 0.0, 0.4), **arguments}
    with pytest.raises(InvalidInput, match=name):
        ik = lt.DifferentialIk(panda, **options)
        state = ik.start(whole.pop("start"))
        ik.step(whole.pop("state", state), whole.pop("position"), **whole)
