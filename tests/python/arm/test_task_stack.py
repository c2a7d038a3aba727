"""Tasks, each of which moves what it is about, and closed loops of stacks of them."""

import dataclasses
import pickle

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings, strategies as st
from refusals import refused
from scipy.optimize import lsq_linear

import leadthrough as lt
from leadthrough.arm import (
    DirectionTask,
    ElbowTask,
    JointLimitTask,
    ObstacleTask,
    PoseTask,
    PositionTask,
    PostureTask,
    TaskStack,
    resolve,
)

PANDA = lt.Arm.load("panda")
SCHEMES = ("siciliano-slotine", "reverse")
HOME = np.array([0.1, -0.5, 0.1, -2.0, 0.1, 1.6, 0.7])
ELBOW = "panda_link4"
POSITION, ORIENTATION = (0.4, 0.0, 0.4), (0.0, 1.0, 0.0, 0.0)


def random_tasks(arm, rng):
    """Tasks in a random order, some of them in conflict and some out of reach."""
    lower, upper = arm.limits.lower, arm.limits.upper
    position, orientation = arm.forward_kinematics(rng.uniform(lower, upper))
    tasks = [
        JointLimitTask(margin=0.2),
        PoseTask(position, orientation),
        PositionTask(rng.normal(size=3)),
        ObstacleTask(lt.Sphere(0.1, position + 0.1 * rng.normal(size=3)), 0.05, link=ELBOW),
        DirectionTask(rng.normal(size=3), rng.normal(size=3), within=rng.choice([0.0, 0.5])),
        ElbowTask(ELBOW, rng.normal()),
        PostureTask(rng.uniform(lower, upper)),
    ]
    order = rng.permutation(len(tasks))[: int(rng.integers(2, 8))]
    return [tasks[i] for i in order]


def assert_inside_limits(arm, q, qd, dt):
    limits = arm.limits
    assert (q >= limits.lower).all()
    assert (q <= limits.upper).all()
    assert (np.abs(qd) <= limits.velocity * (1 + 1e-12)).all()
    assert (np.abs(np.diff(qd, axis=0)) <= limits.acceleration * dt * (1 + 1e-6)).all()


@settings(max_examples=25)
@given(st.integers(0, 2**32 - 1), st.sampled_from(SCHEMES), st.sampled_from([1e-3, 8e-3]))
def test_closed_loops_never_leave_the_limits(seed, scheme, dt):
    arm, rng = lt.Arm.load("panda"), np.random.default_rng(seed)
    stack = TaskStack(arm, random_tasks(arm, rng), scheme=scheme)
    start = rng.uniform(arm.limits.lower, arm.limits.upper)
    run = stack.run(start, duration=200 * dt, dt=dt)
    assert_inside_limits(arm, run.trajectory.positions, run.trajectory.velocities, dt)


@settings(max_examples=15)
@given(st.integers(0, 2**32 - 1), st.sampled_from(SCHEMES))
def test_closed_loops_of_accelerations_never_leave_the_limits(seed, scheme):
    arm, rng, dt = lt.Arm.load("panda"), np.random.default_rng(seed), 2e-3
    stack = TaskStack(arm, random_tasks(arm, rng), scheme=scheme)
    q, qd = rng.uniform(arm.limits.lower, arm.limits.upper), np.zeros(7)
    rows = [(q, qd)]
    for _ in range(200):
        qd = qd + dt * stack.solve_acceleration(q, qd, dt=dt).motion
        q = q + dt * qd
        rows.append((q, qd))
    q, qd = (np.array(part) for part in zip(*rows, strict=True))
    rounding = 1e-12
    inside = np.clip(q, arm.limits.lower - rounding, arm.limits.upper + rounding)
    np.testing.assert_array_equal(q, inside)
    assert_inside_limits(arm, np.clip(q, arm.limits.lower, arm.limits.upper), qd, dt)


def past_a_ball(position):
    ball = lt.Sphere(0.08, position + np.array([-0.22, 0.03, 0.0]))
    goal = position + np.array([-0.26, 0.1, -0.1])
    return [
        ObstacleTask(ball, 0.02, margin=0.1),
        PositionTask(goal, gain=2.0),
        PostureTask(HOME, gain=1.0),
    ]


def into_a_limit(_position):
    beyond = HOME + np.array([0, 0, 0, -1.3, 0, 0, 0])
    return [JointLimitTask(margin=0.4), PostureTask(beyond, gain=1.0)]


@pytest.mark.parametrize("tasks", [past_a_ball, into_a_limit])
@pytest.mark.parametrize("scheme", SCHEMES)
def test_velocities_are_continuous_where_tasks_and_limits_begin_to_act(panda, scheme, tasks):
    """Steps of the velocity shrink in proportion to dt: there is no jump, however small dt is."""
    arm = dataclasses.replace(panda, limits=dataclasses.replace(panda.limits, acceleration=None))
    stack = TaskStack(arm, tasks(arm.forward_kinematics(HOME)[0]), scheme=scheme)
    largest = []
    for dt in (4e-3, 2e-3, 1e-3):
        run = stack.run(HOME, duration=2.0, dt=dt)
        assert run.activation[0, 0] == 0.0
        assert run.activation[:, 0].max() > 0.9
        largest.append(np.abs(np.diff(run.trajectory.velocities[1:], axis=0)).max())
    assert largest[1] < 0.65 * largest[0]
    assert largest[2] < 0.65 * largest[1]


@pytest.mark.parametrize("scheme", SCHEMES)
def test_obstacle_and_limits_are_kept_and_the_goal_reached(panda, scheme):
    position, _ = panda.forward_kinematics(HOME)
    ball = lt.Sphere(0.08, position + np.array([0.0, 0.15, 0.02]))
    goal = position + np.array([0.0, 0.3, 0.0])
    tasks = [ObstacleTask(ball, 0.02), PositionTask(goal), PostureTask(HOME)]
    run = TaskStack(panda, tasks, scheme=scheme).run(HOME, duration=4.0, dt=4e-3)
    way, _ = panda.forward_kinematics(run.trajectory.positions)
    assert ball.distance(way).min() > 0.02 - 1e-6
    assert np.linalg.norm(way[-1] - goal) < 1e-5
    assert run.limited[:, 1].any()


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_null_space_does_not_move_the_tool(panda, scheme):
    position, orientation = panda.forward_kinematics(HOME)
    tasks = [
        PoseTask(position, orientation),
        PostureTask(HOME + np.array([0.5, 0.3, -0.5, 0.2, 0.5, 0, 0])),
    ]
    run = TaskStack(panda, tasks, scheme=scheme).run(HOME, duration=3.0, dt=1e-3)
    way, _ = panda.forward_kinematics(run.trajectory.positions)
    assert np.abs(run.trajectory.positions[-1] - HOME).max() > 0.1
    assert np.linalg.norm(way - position, axis=1).max() < 1e-6


def test_an_arm_that_is_told_to_stretch_too_far_stays_calm(panda):
    straight = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
    position, orientation = panda.forward_kinematics(straight)

    def tasks(time):
        far = 0.9 * min(time, 2.0) / 2.0
        return [PoseTask(position + np.array([far, 0.0, 0.0]), orientation), PostureTask(straight)]

    run = TaskStack(panda, tasks(0.0)).run(straight, duration=4.0, dt=2e-3, tasks=tasks)
    changes = np.diff(run.trajectory.velocities, axis=0) / (2e-3 * panda.limits.acceleration)
    swings = (changes[1:] * changes[:-1] < 0) & (np.abs(np.diff(changes, axis=0)) > 0.2)
    assert swings.sum() < 60
    assert np.abs(run.trajectory.velocities[-1]).max() < 1e-2


@pytest.mark.parametrize("name", ["ur3", "tiago"])
def test_other_arms_take_stacks_as_well(name):
    arm = lt.Arm.load(name)
    q = np.clip(0.3 * np.ones(len(arm.joint_names)), arm.limits.lower, arm.limits.upper)
    position, orientation = arm.forward_kinematics(q)
    tasks = [JointLimitTask(), PoseTask(position + np.array([-0.02, 0.01, 0.02]), orientation)]
    run = TaskStack(arm, tasks).run(q, duration=3.0, dt=4e-3)
    assert run.error[-1, 1] < 1e-4


def test_a_stack_survives_pickling_and_is_deterministic(panda):
    stack = TaskStack(panda, [PostureTask(HOME + 0.1)], scheme="reverse")
    again = pickle.loads(pickle.dumps(stack))
    np.testing.assert_array_equal(again.solve(HOME).motion, stack.solve(HOME).motion)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_the_largest_numbers_give_motions_inside_the_limits(panda, scheme):
    huge = 1e6
    for task in (
        PoseTask((huge, 0, 0), ORIENTATION, twist=[-huge] * 6, gain=huge, damping_ratio=huge),
        PostureTask(np.full(7, -huge), gain=huge),
        ElbowTask(ELBOW, huge),
        ObstacleTask(lt.Sphere(0.1, POSITION), huge, margin=huge, gain=huge),
        PositionTask(POSITION, point=(huge, 0, 0)),
        JointLimitTask(margin=huge, gain=huge),
    ):
        stack = TaskStack(panda, [task, PostureTask(HOME)], scheme=scheme)
        assert (np.abs(stack.solve(HOME).motion) <= panda.limits.velocity).all()
        at_rest = np.zeros(7)
        assert (
            np.abs(stack.solve_acceleration(HOME, at_rest).motion) <= panda.limits.acceleration
        ).all()
        assert np.isfinite(stack.solve(np.full(7, huge)).motion).all()


def test_reverse_agrees_with_flacco_and_de_lucas_formula_on_independent_tasks():
    rng = np.random.default_rng(2)
    for _ in range(100):
        jacobians = [rng.normal(size=(2, 9)) for _ in range(3)]
        wanted = [rng.normal(size=2) for _ in range(3)]
        motion = np.zeros(9)
        for k in (2, 1, 0):
            # The columns of the augmented pseudo-inverse that leave the lower tasks in peace.
            free = np.linalg.pinv(np.vstack(jacobians[k:]))[:, :2]
            correction = np.linalg.pinv(jacobians[k] @ free) @ (wanted[k] - jacobians[k] @ motion)
            motion = motion + free @ correction
        found = resolve(jacobians, wanted, scheme="reverse")
        for jacobian in jacobians:
            np.testing.assert_allclose(jacobian @ found, jacobian @ motion, atol=1e-8)


def test_bounded_stacks_are_lexicographic_least_squares():
    rng = np.random.default_rng(3)
    for _ in range(100):
        upper = rng.uniform(0.2, 1.0, 7)
        inside = rng.uniform(-0.8, 0.8, 7) * upper
        first = rng.normal(size=(3, 7))
        second = rng.normal(size=(2, 7))
        aims = first @ inside, 0.7 * second @ inside + 0.3 * rng.normal(size=2)
        motion = resolve([first, second], aims, lower=-upper, upper=upper)
        np.testing.assert_allclose(first @ motion, aims[0], atol=1e-5)  # it fits the box
        # The second task's least squares with the first as an all but exact equation.
        weight = 1e4
        truth = lsq_linear(
            np.vstack([weight * first, second]),
            np.concatenate([weight * aims[0], aims[1]]),
            bounds=(-upper, upper),
            method="bvls",
        ).x
        ours, best = (np.linalg.norm(second @ x - aims[1]) for x in (motion, truth))
        assert ours <= 1.05 * best + 1e-5  # infeasible aims are slightly damped


def test_tasks_stacks_and_priorities_that_make_no_sense_are_refused(panda):
    for call, name in [
        (lambda _: PoseTask((1, 2), ORIENTATION), "position"),
        (lambda _: PoseTask(POSITION, (0, 0, 0, 0)), "orientation"),
        (lambda _: PoseTask(POSITION, ORIENTATION, twist=(0, 0, 0)), "twist"),
        (lambda _: PoseTask(POSITION, ORIENTATION, gain=-1.0), "gain"),
        (lambda _: PositionTask((np.nan, 0, 0)), "position"),
        (lambda _: PositionTask((1e30, 0, 0)), "position"),
        (lambda _: PositionTask(POSITION, gain=1e30), "gain"),
        (lambda _: ObstacleTask(lt.Sphere(1e30, POSITION), 0.1), "shape"),
        (lambda _: PositionTask(POSITION, damping_ratio=0.0), "damping_ratio"),
        (lambda _: DirectionTask((0, 0, 0), (0, 0, 1)), "axis"),
        (lambda _: DirectionTask((0, 0, 1), (0, 0, 1), within=4.0), "within"),
        (lambda _: PostureTask([[1.0]]), "q"),
        (lambda _: JointLimitTask(margin=0.0), "margin"),
        (lambda _: ElbowTask(ELBOW, np.inf), "height"),
        (lambda _: ObstacleTask("ball", 0.1), "shape"),
        (lambda _: ObstacleTask(lt.Sphere(0.1, POSITION), -0.1), "distance"),
        (lambda arm: TaskStack(arm, []), "tasks"),
        (lambda arm: TaskStack(arm, [PositionTask(POSITION)] * 13), "tasks"),
        (lambda arm: TaskStack(arm, ["pose"]), "tasks"),
        (lambda arm: TaskStack(arm, [JointLimitTask(), JointLimitTask()]), "tasks"),
        (lambda arm: TaskStack(arm, [PostureTask([0.0, 1.0])]), "tasks"),
        (lambda arm: TaskStack(arm, [JointLimitTask()], scheme="best"), "scheme"),
        (lambda arm: TaskStack(arm, [ElbowTask("no_link", 0.5)]), "link"),
        (lambda arm: TaskStack(arm, [ElbowTask("panda_link0", 0.5)]), "link"),
        (lambda arm: TaskStack(arm, [JointLimitTask()]).solve([0.0]), "q"),
        (lambda arm: TaskStack(arm, [JointLimitTask()]).solve(HOME, dt=0.0), "dt"),
        (lambda arm: TaskStack(arm, [JointLimitTask()]).solve_acceleration(HOME, HOME[:2]), "qd"),
        (lambda arm: TaskStack(arm, [JointLimitTask()]).run(HOME, duration=-1.0), "duration"),
        (lambda arm: TaskStack(arm, [JointLimitTask()]).run(HOME, duration=1e9), "dt"),
        (lambda arm: TaskStack(arm, [JointLimitTask()]).solve(HOME + 1e30), "q"),
        (lambda arm: TaskStack(arm, [JointLimitTask()]).solve(HOME, dt=1e-9), "dt"),
    ]:
        refused(name, call, panda)
    for call, name in [
        (lambda: resolve([], []), "jacobians"),
        (lambda: resolve([np.ones((1, 17))], [[1.0]]), "jacobians"),
        (lambda: resolve([np.ones((1, 3)), np.ones((1, 4))], [[1.0], [1.0]]), "jacobians"),
        (lambda: resolve([np.ones((1, 3))], [[1.0, 2.0]]), "wanted"),
        (lambda: resolve([np.ones((1, 3))], [[1.0]], lower=[1.0] * 3, upper=[0.0] * 3), "lower"),
    ]:
        refused(name, call)


def numerical_derivative(function, q, qd, step=1e-6):
    return (function(q + step * qd) - function(q - step * qd)) / (2 * step)


def elbow_of(q):
    upper = lt.Arm.from_urdf(PANDA.document, base=PANDA.base, tip=ELBOW)
    return upper.forward_kinematics(q[: len(upper.joint_names)])[0]


def single(task):
    return TaskStack(PANDA, [task]).solve(HOME).motion


def test_every_task_moves_what_it_is_about():
    position, orientation = PANDA.forward_kinematics(HOME)
    rotation = pin.Quaternion(*orientation).matrix()

    elbow = elbow_of(HOME)
    qd = single(ElbowTask(ELBOW, elbow[2] - 0.02))
    rate = numerical_derivative(lambda q: elbow_of(q)[2], HOME, qd)
    assert rate == pytest.approx(-0.1, abs=1e-6)

    point = np.array([0.05, 0.0, 0.1])
    target = position + rotation @ point + [0.0, 0.01, 0.0]
    qd = single(PositionTask(target, point=point, velocity=(0.02, 0.0, 0.0)))

    def place(q):
        p, (w, x, y, z) = PANDA.forward_kinematics(q)
        return p + pin.Quaternion(w, x, y, z).matrix() @ point

    np.testing.assert_allclose(numerical_derivative(place, HOME, qd), [0.02, 0.05, 0], atol=1e-6)

    def axis(q):
        _, (w, x, y, z) = PANDA.forward_kinematics(q)
        return pin.Quaternion(w, x, y, z).matrix()[:, 2]

    goal = axis(HOME) + np.array([0.1, 0.0, 0.0])
    goal /= np.linalg.norm(goal)
    qd = single(DirectionTask((0, 0, 1), goal))
    angle = lambda q: np.arccos(axis(q) @ goal)  # noqa: E731
    assert numerical_derivative(angle, HOME, qd) == pytest.approx(-5.0 * angle(HOME), rel=1e-5)


@pytest.mark.parametrize("shape", [lt.Sphere, lt.Capsule, lt.Box, lt.Cylinder])
def test_obstacle_tasks_push_away_at_the_rate_of_their_gain(shape):
    position, _ = PANDA.forward_kinematics(HOME)
    centre = position + np.array([0.12, 0.03, -0.05])
    made = {
        lt.Sphere: lambda: lt.Sphere(0.1, centre),
        lt.Capsule: lambda: lt.Capsule(0.1, 0.2, centre, (0.8, 0.6, 0, 0)),
        lt.Cylinder: lambda: lt.Cylinder(0.1, 0.15, centre, (0.8, 0.6, 0, 0)),
        lt.Box: lambda: lt.Box((0.15, 0.3, 0.2), centre, (0.8, 0, 0.6, 0)),
    }[shape]()
    distance = lambda q: made.distance([PANDA.forward_kinematics(q)[0]])[0]  # noqa: E731
    wanted = distance(HOME) + 0.02
    stack = TaskStack(PANDA, [ObstacleTask(made, wanted), PostureTask(HOME)])
    solution = stack.solve(HOME)
    assert solution.report.error[0] == pytest.approx(0.02)
    rate = numerical_derivative(distance, HOME, solution.motion)
    assert rate == pytest.approx(5.0 * 0.02, abs=1e-5)


def test_accelerations_take_the_bias_into_account():
    position, orientation = PANDA.forward_kinematics(HOME)
    qd = np.array([0.3, -0.2, 0.4, 0.5, -0.3, 0.2, 0.1])
    task = PoseTask(
        position + np.array([0.02, 0.0, 0.01]), orientation, gain=2.0, damping_ratio=0.7
    )
    qdd = TaskStack(PANDA, [task]).solve_acceleration(HOME, qd).motion
    model = pin.buildModelFromXML(PANDA.document)
    data = model.createData()
    full = np.concatenate([HOME, np.zeros(model.nq - 7)])
    full_qd = np.concatenate([qd, np.zeros(model.nv - 7)])
    full_qdd = np.concatenate([qdd, np.zeros(model.nv - 7)])
    pin.forwardKinematics(model, data, full, full_qd, full_qdd)
    pin.updateFramePlacements(model, data)
    tip = model.getFrameId(PANDA.tip)
    frame = pin.LOCAL_WORLD_ALIGNED
    velocity = pin.getFrameVelocity(model, data, tip, frame)
    acceleration = pin.getFrameClassicalAcceleration(model, data, tip, frame)
    error = np.array([0.02, 0.0, 0.01, 0, 0, 0])
    wanted = 4.0 * error - 2.0 * 0.7 * 2.0 * velocity.vector
    np.testing.assert_allclose(acceleration.vector, wanted, atol=1e-9)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_tasks_that_fit_together_are_all_met(scheme):
    position, _ = PANDA.forward_kinematics(HOME)
    stack = TaskStack(
        PANDA,
        [
            PositionTask(position + np.array([0.01, 0.02, -0.01])),
            ElbowTask(ELBOW, elbow_of(HOME)[1] + 0.01, direction=(0, 2, 0)),
            PostureTask(HOME),
        ],
        scheme=scheme,
    )
    solution = stack.solve(HOME)
    assert solution.report.residual[:2] == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(
        PANDA.jacobian(HOME)[:3] @ solution.motion, 5.0 * np.array([0.01, 0.02, -0.01]), atol=1e-9
    )


LINKS = "".join(f'<link name="{name}"/>' for name in "abcd")


def hinge(name, parent, child, inside=""):
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0.3 0 0.1"/><axis xyz="0 1 0.2"/>{inside}'
        '<limit lower="-2" upper="2" velocity="9" effort="1"/></joint>'
    )


def test_links_behind_joints_that_mimic_or_are_held_are_moved_as_they_move():
    mimic = '<mimic joint="one" multiplier="-2" offset="0.1"/>'
    joints = [hinge("one", "a", "b"), hinge("two", "b", "c", mimic), hinge("three", "c", "d")]
    whole = lt.Arm.from_urdf(f'<robot name="folding">{LINKS}{"".join(joints)}</robot>')
    held = whole.lock_joints({"three": 0.3})
    for arm, link in ((whole, "c"), (whole, None), (held, "d")):
        q = np.full(len(arm.joint_names), 0.7)
        upper = (
            arm
            if link is None
            else lt.Arm.from_urdf(arm.document, tip=link, locked_joints=arm.locked_joints)
        )
        used = slice(len(upper.joint_names))
        height = lambda q, upper=upper, used=used: upper.forward_kinematics(q[used])[0][2]  # noqa: E731
        task = ElbowTask(link or "d", height(q) + 0.01)
        qd = TaskStack(arm, [task]).solve(q).motion
        assert numerical_derivative(height, q, qd) == pytest.approx(0.05, abs=1e-6)
