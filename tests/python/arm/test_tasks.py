"""Each task moves what it is about: against derivatives by differences and Pinocchio."""

import numpy as np
import pinocchio as pin
import pytest

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
)
from leadthrough.errors import InvalidInput

PANDA = lt.Arm.load("panda")
HOME = np.array([0.1, -0.5, 0.1, -2.0, 0.1, 1.6, 0.7])
ELBOW = "panda_link4"
POSITION, ORIENTATION = (0.4, 0.0, 0.4), (0.0, 1.0, 0.0, 0.0)


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


@pytest.mark.parametrize("scheme", ["siciliano-slotine", "reverse"])
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


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: PoseTask((1, 2), ORIENTATION), "position"),
        (lambda: PoseTask(POSITION, (0, 0, 0, 0)), "orientation"),
        (lambda: PoseTask(POSITION, ORIENTATION, twist=(0, 0, 0)), "twist"),
        (lambda: PoseTask(POSITION, ORIENTATION, gain=-1.0), "gain"),
        (lambda: PositionTask((np.nan, 0, 0)), "position"),
        (lambda: PositionTask((1e30, 0, 0)), "position"),
        (lambda: PositionTask(POSITION, gain=1e30), "gain"),
        (lambda: ObstacleTask(lt.Sphere(1e30, POSITION), 0.1), "shape"),
        (lambda: PositionTask(POSITION, damping_ratio=0.0), "damping_ratio"),
        (lambda: DirectionTask((0, 0, 0), (0, 0, 1)), "axis"),
        (lambda: DirectionTask((0, 0, 1), (0, 0, 1), within=4.0), "within"),
        (lambda: PostureTask([[1.0]]), "q"),
        (lambda: JointLimitTask(margin=0.0), "margin"),
        (lambda: ElbowTask(ELBOW, np.inf), "height"),
        (lambda: ObstacleTask("ball", 0.1), "shape"),
        (lambda: ObstacleTask(lt.Sphere(0.1, POSITION), -0.1), "distance"),
    ],
)
def test_tasks_that_make_no_sense_are_refused(make, name):
    with pytest.raises(InvalidInput, match=name):
        make()


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
