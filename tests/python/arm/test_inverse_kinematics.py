"""Single poses and batches: reached or not, the null space, budgets and bad input."""

import threading
from functools import partial

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from motions import configurations
from refusals import refused

import leadthrough as lt
from leadthrough.arm import IkOptions
from leadthrough.errors import InvalidInput
from leadthrough_studies.damped_least_squares import damped_inverse_kinematics


def errors(arm, q, positions, orientations):
    reached, turned = arm.forward_kinematics(q)
    return (
        np.linalg.norm(reached - positions, axis=-1),
        lt.rotations.distance(np.atleast_2d(turned), np.atleast_2d(orientations)),
    )


def assert_inside(arm, q):
    assert (q >= arm.limits.lower).all()
    assert (q <= arm.limits.upper).all()


@pytest.mark.parametrize("gain", [0.0, 1.0])
def test_every_reachable_target_is_reached_inside_the_limits(arm, gain):
    positions, orientations = arm.forward_kinematics(configurations(arm, 500, 1))
    batch = arm.inverse_kinematics_batch(
        positions,
        orientations,
        q0=configurations(arm, 500, 2),
        options=IkOptions(nullspace_gain=gain),
    )
    assert batch.success.all()
    assert set(batch.status) == {"converged"}
    assert_inside(arm, batch.q)
    distance, angle = errors(arm, batch.q, positions, orientations)
    assert distance.max() < 1e-5
    assert angle.max() < 1e-5
    np.testing.assert_allclose(distance, batch.position_error, atol=1e-12)
    np.testing.assert_allclose(angle, batch.orientation_error, atol=1e-9)


def test_one_target_is_solved_like_a_batch_of_one(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    one = arm.inverse_kinematics(position, orientation)
    batch = arm.inverse_kinematics_batch([position], [orientation])
    np.testing.assert_array_equal(one.q, batch.q[0])
    assert one.success
    assert one.status == "converged"
    assert one.iterations == batch.iterations[0]


def test_a_pose_has_one_answer_wherever_it_stands_in_a_batch(arm, posture):
    rng = np.random.default_rng(0)
    low, high = np.maximum(arm.limits.lower, -2.0), np.minimum(arm.limits.upper, 2.0)
    targets = arm.forward_kinematics(rng.uniform(low, high, (60, len(posture))))
    batch = arm.inverse_kinematics_batch(*targets).q
    backwards = arm.inverse_kinematics_batch(*(each[::-1] for each in targets)).q[::-1]
    alone = [arm.inverse_kinematics(*target).q for target in zip(*targets, strict=True)]
    np.testing.assert_allclose(batch, alone, atol=1e-9)
    np.testing.assert_allclose(batch, backwards, atol=1e-9)


def test_a_start_on_the_target_stays(arm, posture):
    position, orientation = arm.forward_kinematics(posture)
    result = arm.inverse_kinematics(position, orientation, q0=posture)
    np.testing.assert_allclose(result.q, posture, atol=1e-12)
    assert result.iterations == 0


def test_self_motion_leaves_the_tool_and_nears_the_middle_as_far_as_it_can(arm, posture):
    pose = arm.forward_kinematics(posture)
    plain = arm.inverse_kinematics(*pose, q0=posture).q
    q = arm.inverse_kinematics(*pose, q0=posture, options=IkOptions(nullspace_gain=1.0)).q
    reached, _ = arm.forward_kinematics(q)
    assert np.linalg.norm(reached - pose[0]) < 1e-6
    if len(posture) == 6:
        np.testing.assert_array_equal(plain, q)
        return
    middle = 0.5 * (arm.limits.lower + arm.limits.upper)
    assert np.linalg.norm(q - middle) < np.linalg.norm(plain - middle) - 0.01
    pull = middle - q
    jacobian = arm.jacobian(q)
    free = pull - np.linalg.pinv(jacobian) @ (jacobian @ pull)
    inside = (q > arm.limits.lower) & (q < arm.limits.upper)
    assert not inside.all() or np.linalg.norm(free) < 0.05


def test_a_target_just_out_of_reach_ends_with_the_closest_found(arm):
    positions, orientations = arm.forward_kinematics(configurations(arm, 2000, 5))
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


SOLVERS = ("inverse_kinematics", "inverse_kinematics_batch", "inverse_kinematics_all")
HERE = [0.3, 0.0, 0.3]
ROWS = np.zeros((3, 3))


def test_bad_arguments_and_options_are_refused(arm):
    for method, arguments, message in [
        ("inverse_kinematics", {"position": [np.nan, 0, 0]}, "position"),
        ("inverse_kinematics", {"position": [0, 0]}, "position"),
        ("inverse_kinematics", {"position": "here"}, "position"),
        ("inverse_kinematics", {"orientation": [0, 0, 0, 0]}, "orientation"),
        ("inverse_kinematics", {"orientation": [np.inf, 0, 0, 0]}, "orientation"),
        ("inverse_kinematics", {"q0": [1, 2]}, "q0"),
        ("inverse_kinematics", {"seed": -1}, "seed"),
        ("inverse_kinematics", {"options": {"free": "rz"}}, "options"),
        ("inverse_kinematics", {"options": IkOptions(mode="closest", posture=[0.0])}, "posture"),
        ("inverse_kinematics", {"options": IkOptions(free=("x", "y", "z"))}, "free"),
        (
            "inverse_kinematics_batch",
            {"positions": ROWS, "orientations": np.zeros((2, 4))},
            "orientation",
        ),
        ("inverse_kinematics_batch", {"positions": ROWS, "threads": 0}, "threads"),
        ("inverse_kinematics_batch", {"positions": ROWS, "q0": np.zeros((2, 6))}, "q0"),
        ("inverse_kinematics_all", {"count": 0}, "count"),
        ("inverse_kinematics_all", {"count": 65}, "count"),
        ("inverse_kinematics_all", {"separation": 0.0}, "separation"),
        *((method, {"seed": [0.0, 0.0]}, r"seed: .* q0") for method in SOLVERS),
    ]:
        target = {"positions": ROWS} if method.endswith("batch") else {"position": HERE}
        refused(message, getattr(arm, method), **target | arguments)
    for option in [
        {"position_tolerance": 0.0},
        {"position_tolerance": [1e-3, 1e-3]},
        {"position_tolerance": [1e-3, -1e-3, 1e-3]},
        {"orientation_tolerance": [np.inf, 1, 1]},
        {"orientation_tolerance": np.nan},
        {"free": "rz"},
        {"free": ("roll",)},
        {"free": 3},
        {"free": ("x", "y", "z", "rx", "ry", "rz")},
        {"weights": [1, 1, 1]},
        {"weights": [1, 1, 1, 0, 1, 1]},
        {"weights": [1, 1, np.nan, 1, 1, 1]},
        {"mode": "best"},
        {"posture": np.full(6, np.nan)},
        {"posture": np.zeros(6), "nullspace_gain": 0.5},
        {"nullspace_gain": 2.0},
        {"max_iterations": 0},
        {"max_restarts": 1.5},
        {"max_restarts": 100.0},
        {"max_restarts": True},
        {"max_cpu_seconds": 0.0},
        {"max_cpu_seconds": np.nan},
    ]:
        refused("|".join(option), IkOptions, **option)


UR3 = lt.Arm.load("ur3")
PANDA = lt.Arm.load("panda")


@pytest.mark.parametrize("tolerance", [1e-6, 1e-3])
@pytest.mark.parametrize("goal", ["middle", "posture"])
def test_self_motion_does_not_move_the_tool(goal, tolerance):
    """However coarse the tolerance, the tool is where it would be without; 8 joints of the
    TIAGo and 7 of the Panda."""
    for arm in (PANDA, lt.Arm.load("tiago")):
        starts = configurations(arm, 100, 6)
        positions, orientations = arm.forward_kinematics(starts)
        task = {"nullspace_gain": 1.0} if goal == "middle" else {"posture": starts[::-1][0]}
        moved = arm.inverse_kinematics_batch(
            positions,
            orientations,
            q0=starts,
            options=IkOptions(position_tolerance=tolerance, **task),
        )
        assert np.abs(moved.q - starts).max() > 0.1
        reached, turned = arm.forward_kinematics(moved.q)
        assert np.linalg.norm(reached - positions, axis=1).max() < 1e-6
        assert lt.rotations.distance(turned, orientations).max() < 1e-6


def test_a_posture_draws_the_elbow():
    q = np.array([0.0, 0.3, 0.0, -1.8, 0.0, 2.1, 0.8])
    pose = PANDA.forward_kinematics(q)
    for side in (-0.9, 0.9):
        drawn = q + side * np.array([1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0])
        result = PANDA.inverse_kinematics(*pose, q0=q, options=IkOptions(posture=drawn))
        assert result.success
        assert np.linalg.norm(result.q - drawn) < np.linalg.norm(q - drawn) - 0.1
        assert np.sign(result.q[0]) == np.sign(side)


def test_an_arm_without_a_null_space_stays(posture):
    q = np.array([0, -1.2, 1.4, -1.7, -1.5, 0.3])
    pose = UR3.forward_kinematics(q)
    result = UR3.inverse_kinematics(*pose, q0=q, options=IkOptions(posture=np.zeros(6)))
    np.testing.assert_allclose(result.q, q, atol=1e-12)


def test_limiting_joints_are_named():
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
        far, orientation, q0=posture, options=IkOptions(max_iterations=1)
    )
    assert result.status in {"budget", "converged"}
    assert result.iterations < 1 + 800  # the descent to the closest configuration is bounded


@pytest.mark.parametrize("options", [{}, {"mode": "closest"}, {"free": ("rz",)}, "damped"])
def test_threads_and_repetition_do_not_change_a_bit(arm, options):
    targets = arm.forward_kinematics(configurations(arm, 40, 7))
    if options == "damped":
        solve = partial(damped_inverse_kinematics, arm, *targets, max_iterations=300)
    else:
        chosen = IkOptions(max_iterations=300, **options)
        solve = partial(arm.inverse_kinematics_batch, *targets, options=chosen)
    first = solve()
    for threads in (1, 2, 5):
        again = solve(threads=threads)
        np.testing.assert_array_equal(first.q, again.q)
        np.testing.assert_array_equal(first.iterations, again.iterations)


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
        options=IkOptions(max_iterations=10**9, max_restarts=10**9, max_cpu_seconds=0.3),
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
                options=IkOptions(mode=mode, max_iterations=200, free=("rz",)),
            )
        except InvalidInput:
            continue
        assert_inside(UR3, result.q)


@pytest.mark.parametrize("axes", [{}, {"free": ("rz",)}, {"position_tolerance": [1e-3] * 3}])
@pytest.mark.parametrize("size", [9.0, 1e3, 1e150, 1e300])
def test_targets_beyond_the_arm_end_with_a_verdict_in_every_mode(arm, axes, size):
    target = ([size, -size, size], [1.0, 0.0, 0.0, 0.0])
    for result in (
        arm.inverse_kinematics(*target, options=IkOptions(**axes)),
        arm.inverse_kinematics(*target, options=IkOptions(mode="closest", **axes)),
        damped_inverse_kinematics(arm, *([part] for part in target), max_iterations=20),
    ):
        assert result.status == "unreachable"
        assert not result.success
        assert result.position_error > 0.5 * size
        assert_inside(arm, result.q)
    found = arm.inverse_kinematics_all(*target, options=IkOptions(**axes))
    assert len(found) == 0
    assert found.q.shape == (0, len(arm.joint_names))


@pytest.mark.parametrize("method", [*SOLVERS, "follow", "check", "path_report"])
def test_a_wrong_keyword_names_the_method_and_the_argument(method):
    with pytest.raises(TypeError, match=rf"\b{method}\(\).*'speed'"):
        getattr(UR3, method)([[0.3, 0.0, 0.3]], speed=1.0)
