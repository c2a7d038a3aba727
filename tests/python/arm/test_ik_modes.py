"""Single poses: the posture in the null space, limits in the way, budgets and bad input."""

import threading
import time
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import leadthrough as lt
from leadthrough.arm.damped_least_squares import (
    damped_inverse_kinematics,
)
from leadthrough.errors import InvalidInput

UR3 = lt.Arm.load("ur3")
PANDA = lt.Arm.load("panda")


@pytest.mark.parametrize("tolerance", [1e-6, 1e-3])
@pytest.mark.parametrize("goal", ["middle", "posture"])
def test_self_motion_does_not_move_the_tool(random_configurations, goal, tolerance):
    """However coarse the tolerance, the tool is where it would be without; 8 joints of the
    TIAGo and 7 of the Panda."""
    for arm in (PANDA, lt.Arm.load("tiago")):
        starts = random_configurations(arm, 100, 6)
        positions, orientations = arm.forward_kinematics(starts)
        task = {"nullspace_gain": 1.0} if goal == "middle" else {"posture": starts[::-1][0]}
        moved = arm.inverse_kinematics_batch(
            positions,
            orientations,
            q0=starts,
            options=lt.arm.IkOptions(position_tolerance=tolerance, **task),
        )
        assert np.abs(moved.q - starts).max() > 0.1
        reached, turned = arm.forward_kinematics(moved.q)
        assert np.linalg.norm(reached - positions, axis=1).max() < 1e-6
        assert lt.rotations.distance(turned, orientations).max() < 1e-6


def test_a_posture_draws_the_elbow(random_configurations):
    q = np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.1, 0.8])
    pose = PANDA.forward_kinematics(q)
    for side in (-0.9, 0.9):
        drawn = q + side * np.array([1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0])
        result = PANDA.inverse_kinematics(*pose, q0=q, options=lt.arm.IkOptions(posture=drawn))
        assert result.success
        assert np.linalg.norm(result.q - drawn) < np.linalg.norm(q - drawn) - 0.1
        assert np.sign(result.q[0]) == np.sign(side)


def test_an_arm_without_a_null_space_stays(posture):
    q = np.array([0, -1.2, 1.4, -1.7, -1.5, 0.3])
    pose = UR3.forward_kinematics(q)
    result = UR3.inverse_kinematics(*pose, q0=q, options=lt.arm.IkOptions(posture=np.zeros(6)))
    np.testing.assert_allclose(result.q, q, atol=1e-12)


def test_limits_that_bar_the_way_are_named():
    """A wrist turned farther than the Panda's last joint allows, the others kept by theirs."""
    q = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
    lower, upper = q - 1e-3, q + 1e-3
    upper[6] = 1.5
    limits = lt.arm.JointLimits(PANDA.joint_names, lower, upper, PANDA.limits.velocity)
    held = lt.Arm.from_urdf(PANDA.document, base=PANDA.base, tip=PANDA.tip, limits=limits)
    wanted = q.copy()
    wanted[6] = 2.0
    pose = PANDA.forward_kinematics(wanted)
    result = held.inverse_kinematics(*pose)
    assert result.status == "limits"
    assert PANDA.joint_names[6] in result.limiting_joints
    batch = held.inverse_kinematics_batch(*(part[None] for part in pose))
    named = np.array(PANDA.joint_names)[batch.limiting_joints[0]]
    assert tuple(named) == result.limiting_joints


def test_iterations_are_a_budget(arm, posture):
    far, orientation = arm.forward_kinematics(posture + 0.5)
    result = arm.inverse_kinematics(
        far, orientation, q0=posture, options=lt.arm.IkOptions(max_iterations=1)
    )
    assert result.status in {"budget", "converged"}
    assert result.iterations < 1 + 800  # the descent to the closest configuration is bounded


@pytest.mark.parametrize("options", [{"mode": "closest"}, {"free": ("rz",)}, "damped"])
def test_threads_do_not_change_a_bit_in_any_mode(arm, random_configurations, options):
    targets = arm.forward_kinematics(random_configurations(arm, 20, 7))
    if options == "damped":
        solve = partial(damped_inverse_kinematics, arm, *targets, max_iterations=300)
    else:
        chosen = lt.arm.IkOptions(max_iterations=300, **options)
        solve = partial(arm.inverse_kinematics_batch, *targets, options=chosen)
    one, many = solve(), solve(threads=3)
    np.testing.assert_array_equal(one.q, many.q)
    np.testing.assert_array_equal(one.iterations, many.iterations)


def test_a_cpu_budget_ends_the_search(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    began = time.thread_time()
    arm.inverse_kinematics(
        position,
        orientation,
        options=lt.arm.IkOptions(
            mode="closest", max_cpu_seconds=0.02, max_iterations=10**9, max_restarts=10**9
        ),
    )
    assert 0.01 < time.thread_time() - began < 0.5


def test_other_threads_go_on_while_one_solves():
    """A thread that counts makes progress during one long call."""
    position, orientation = UR3.forward_kinematics(np.array([0, -1.2, 1.4, -1.7, -1.5, 0.3]))
    done = threading.Event()
    counted = []

    def count():
        ticks = 0
        while not done.is_set():
            ticks += 1
        counted.append(ticks)

    thread = threading.Thread(target=count)
    thread.start()
    UR3.inverse_kinematics_all(
        position,
        orientation,
        options=lt.arm.IkOptions(max_iterations=10**9, max_restarts=10**9, max_cpu_seconds=0.3),
    )
    done.set()
    thread.join()
    assert counted[0] > 1000


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=7, max_size=7))
def test_any_numbers_give_a_verdict_or_an_error(numbers):
    position, orientation = numbers[:3], numbers[3:]
    for mode in ("fastest", "closest"):
        try:
            result = UR3.inverse_kinematics(
                position,
                orientation,
                options=lt.arm.IkOptions(mode=mode, max_iterations=200, free=("rz",)),
            )
        except InvalidInput:
            continue
        assert np.isfinite(result.q).all()
        assert (result.q >= UR3.limits.lower).all()
        assert (result.q <= UR3.limits.upper).all()


@pytest.mark.parametrize("axes", [{}, {"free": ("rz",)}, {"position_tolerance": [1e-3] * 3}])
@pytest.mark.parametrize("size", [1e3, 1e150, 1e300])
def test_huge_targets_end_with_a_verdict_in_every_mode(arm, axes, size):
    target = ([size, -size, size], [1.0, 0.0, 0.0, 0.0])
    for result in (
        arm.inverse_kinematics(*target, options=lt.arm.IkOptions(**axes)),
        arm.inverse_kinematics(*target, options=lt.arm.IkOptions(mode="closest", **axes)),
        damped_inverse_kinematics(arm, *([part] for part in target), max_iterations=20),
    ):
        assert result.status == "unreachable"
        assert np.isfinite(result.q).all()
    assert len(arm.inverse_kinematics_all(*target, options=lt.arm.IkOptions(**axes))) == 0


@pytest.mark.parametrize(
    "options",
    [
        {"mode": "best"},
        {"mode": "closest", "posture": [0.0]},
        {"posture": np.full(6, np.nan)},
        {"posture": np.zeros(6), "nullspace_gain": 0.5},
        {"max_cpu_seconds": 0.0},
        {"max_cpu_seconds": np.nan},
    ],
)
def test_bad_options_are_refused_by_name(options):
    with pytest.raises(InvalidInput, match="|".join(options)):
        UR3.inverse_kinematics([0.3, 0.0, 0.3], [0, 1, 0, 0], options=lt.arm.IkOptions(**options))


@pytest.mark.parametrize(
    "method",
    [
        "inverse_kinematics",
        "inverse_kinematics_batch",
        "inverse_kinematics_all",
        "follow",
        "check",
        "path_report",
    ],
)
def test_a_wrong_keyword_names_the_method_and_the_argument(method):
    with pytest.raises(TypeError, match=rf"\b{method}\(\).*'speed'"):
        getattr(UR3, method)([[0.3, 0.0, 0.3]], speed=1.0)


def test_options_seen_before_are_checked_as_if_they_were_new():
    UR3.inverse_kinematics([0.3, 0.0, 0.3], options=lt.arm.IkOptions(max_restarts=100))
    for equal in (100.0, np.float64(100.0), True):
        with pytest.raises(InvalidInput, match="max_restarts"):
            UR3.inverse_kinematics([0.3, 0.0, 0.3], options=lt.arm.IkOptions(max_restarts=equal))
