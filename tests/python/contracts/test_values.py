"""Values stay what they were when checked: copies and pickles are checked again, and read-only.

The table builds every public value that checks its arguments; a walk over the reference finds one
that is missing.
"""

import copy
import dataclasses
import inspect
import pickle

import numpy as np
import pytest
from contracts.public import public_callables
from kinds import KINDS, demonstrations
from motions import arm
from refusals import refused

import leadthrough as lt
from leadthrough import arm as arms, shapes, simulation, trajectories, validation
from leadthrough.planning import ArrivalField, Grid

TIMES = np.array([0.0, 0.4, 1.0])
POINTS = np.array([[0.0, 0.1, 0.2], [0.3, 0.1, 0.0], [0.5, -0.1, 0.1]])
TURNS = lt.rotations.exp([[0.0, 0.1, 0.2], [0.3, 0.1, 0.0], [0.5, -0.1, 0.1]])
CUBE = np.array(np.meshgrid([0.0, 0.1], [0.0, 0.1], [0.0, 0.1])).reshape(3, 8).T
SQUARES = [[0, 1, 2], [1, 2, 3], [4, 5, 6], [5, 6, 7], [0, 1, 4], [1, 4, 5], [2, 3, 6], [3, 6, 7]]
UR3 = arm("ur3")
REST = np.array([0.0, -1.6, 1.9, -1.9, -1.6, 0.0])
WAIT = arms.Wait("left", 0.0, 1.0, REST, ("left_hand", "right_hand"))
JOINTS = lt.JointTrajectory(TIMES, POINTS, 2 * POINTS, 3 * POINTS, ("a", "b", "c"))
CURVE = trajectories.Bezier(POINTS, (0.0, 2.0))
SPHERE = lt.Sphere(0.1, (0.1, 0.2, 0.3))

VALUES = {
    "guard.CommandedState": lambda: lt.guard.CommandedState(*POINTS),
    "trajectories.FilterState": lambda: trajectories.FilterState(*POINTS),
    "Event": lambda: lt.Event(0.2, "closed"),
    "Box": lambda: lt.Box((0.1, 0.2, 0.3), (0.1, 0.2, 0.3), TURNS[1]),
    "Capsule": lambda: lt.Capsule(0.1, 0.2, (0.1, 0.2, 0.3)),
    "Cylinder": lambda: lt.Cylinder(0.1, 0.2, (0.1, 0.2, 0.3)),
    "Demonstration": lambda: lt.Demonstration(JOINTS, "reach"),
    "JointTrajectory": lambda: JOINTS,
    "Mesh": lambda: lt.Mesh(CUBE, SQUARES, (0.1, 0.2, 0.3), TURNS[2]),
    "PointCloud": lambda: lt.PointCloud(POINTS, 0.01),
    "PoseTrajectory": lambda: lt.PoseTrajectory(TIMES, POINTS, TURNS, (), JOINTS),
    "Scene": lambda: lt.Scene([SPHERE]),
    "Sphere": lambda: SPHERE,
    "Trajectory": lambda: lt.Trajectory(TIMES, POINTS, (lt.Event(0.2, "closed"),)),
    "arm.Arm": lambda: UR3,
    "arm.DualDemonstration": lambda: arms.DualDemonstration(
        *[lt.PoseTrajectory(TIMES, POINTS, TURNS)] * 2, JOINTS
    ),
    "arm.Wait": lambda: WAIT,
    "arm.DualArm": lambda: lt.DualArm(UR3, UR3, ((0.0, -0.6, 0.0), TURNS[1])),
    "arm.HeldObject": lambda: arms.HeldObject(
        lt.DualArm(UR3, UR3, ((0.0, -0.6, 0.0), TURNS[1])), ((POINTS[0], TURNS[0]),) * 2
    ),
    "arm.DifferentialIk": lambda: lt.DifferentialIk(UR3, posture=REST),
    "arm.DirectionTask": lambda: arms.DirectionTask((0.0, 0.0, 1.0), (0.0, 0.6, 0.8)),
    "arm.ElbowTask": lambda: arms.ElbowTask("forearm_link", 0.3),
    "arm.FollowOptions": lambda: arms.FollowOptions(posture=REST),
    "arm.IkOptions": lambda: arms.IkOptions(posture=REST),
    "arm.JointLimits": lambda: UR3.limits,
    "arm.ObstacleTask": lambda: arms.ObstacleTask(SPHERE, 0.1),
    "arm.PoseTask": lambda: arms.PoseTask(POINTS[0], TURNS[0]),
    "arm.PositionTask": lambda: arms.PositionTask(POINTS[0]),
    "arm.PostureTask": lambda: arms.PostureTask(REST),
    "arm.TaskStack": lambda: arms.TaskStack(UR3, [arms.PositionTask(POINTS[0])]),
    "io.Recording": lambda: lt.io.Recording(TIMES, POINTS),
    "motion_planning.Query": lambda: lt.Query(start=POINTS[0], goal=(POINTS[1], TURNS[1])),
    "planning.Grid": lambda: Grid((0.0, 0.1), 0.05, (4, 5)),
    "shapes.MovingObstacle": lambda: shapes.MovingObstacle(SPHERE, 0.2),
    "shapes.RandomObstacle": lambda: shapes.RandomObstacle(SPHERE, 0.1),
    "simulation.Push": lambda: simulation.Push(0.1, (1.0, 2.0, 3.0)),
    "timing.TipSpeed": lambda: lt.timing.TipSpeed(0.1, np.gradient),
    "timing.TipTolerance": lambda: lt.timing.TipTolerance(1e-3, 1e-2, TIMES + 1.0, [0, 1, 1]),
    "trajectories.BSpline": lambda: trajectories.BSpline(POINTS, [0, 0, 0, 1, 1, 1], 2),
    "trajectories.Bezier": lambda: CURVE,
    "trajectories.FirstOrderFilter": lambda: trajectories.FirstOrderFilter(2.0),
    "trajectories.JerkFilter": lambda: trajectories.JerkFilter([1.0, 2.0], 3.0, 4.0),
    "trajectories.Lagrange": lambda: trajectories.Lagrange(TIMES, POINTS),
    "trajectories.LineState": lambda: trajectories.StraightFilter(
        trajectories.JerkFilter(1.0, 2.0, 3.0)
    ).step(trajectories.FilterState.at_rest(POINTS[0]), POINTS[1], 0.1),
    "trajectories.Nurbs": lambda: trajectories.Nurbs(POINTS, [1, 2, 1], [0, 0, 0, 1, 1, 1], 2),
    "trajectories.PoseCurve": lambda: trajectories.PoseCurve(
        CURVE, trajectories.Slerp([0.0, 0.5, 2.0], TURNS)
    ),
    "trajectories.RotationBezier": lambda: trajectories.RotationBezier(TURNS),
    "trajectories.RotationSpline": lambda: trajectories.RotationSpline(TIMES, TURNS),
    "trajectories.SecondOrderFilter": lambda: trajectories.SecondOrderFilter(2.0, 3.0),
    "trajectories.Slerp": lambda: trajectories.Slerp(TIMES, TURNS),
    "trajectories.Spline": lambda: trajectories.Spline(TIMES, np.ones((2, 3, 1))),
    "trajectories.Squad": lambda: trajectories.Squad(TIMES, TURNS),
    "trajectories.State": lambda: trajectories.State(POINTS[0], POINTS[1]),
    "trajectories.StraightFilter": lambda: trajectories.StraightFilter(
        trajectories.JerkFilter(1.0, 2.0, 3.0)
    ),
    "trajectories.TimeOptimalFilter": lambda: trajectories.TimeOptimalFilter(1.0, 2.0),
    "validation.SamplingPlan": validation.SamplingPlan,
    "validation.TargetRegion": lambda: validation.TargetRegion(POINTS[0], POINTS[0] + 1.0),
}
ABSTRACT = {"arm.ArmModel", "arm.ArmTask"}  # of which others are made


def values():
    """Public frozen dataclasses that check their arguments, by name."""
    for name, value in public_callables():
        if inspect.isclass(value) and dataclasses.is_dataclass(value):
            checks = not value.__dataclass_params__.init
            if (checks or hasattr(value, "__post_init__")) and name not in ABSTRACT:
                yield name, value


def made(name):
    """A value of a class, from the table or with its defaults."""
    return VALUES[name]() if name in VALUES else dict(values())[name]()


def arrays_in(value, name="", seen=()):
    """All arrays that can be reached through the fields of dataclasses, by their names."""
    if isinstance(value, np.ndarray):
        yield name, value
    elif isinstance(value, tuple | list):
        for i, each in enumerate(value):
            yield from arrays_in(each, f"{name}[{i}]")
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        for each in dataclasses.fields(value):
            if not each.name.startswith("_"):
                yield from arrays_in(getattr(value, each.name), f"{name}.{each.name}")


WITH_GAPS = {"io.Recording"}  # NaN stands for a missing number there
WAYS = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda value: pickle.loads(pickle.dumps(value)),
    "replace": dataclasses.replace,
}
NAMES = sorted({*VALUES, *dict(values())})


def test_every_public_value_is_in_the_table_or_has_defaults():
    for name in dict(values()):
        assert made(name) is not None
    assert set(VALUES) <= set(dict(values()))


@pytest.mark.parametrize("name", NAMES)
def test_copies_and_pickles_are_read_only_and_the_same_to_the_bit(name):
    value = made(name)
    expected = dict(arrays_in(value))
    for way, copied in WAYS.items():
        again = copied(value)
        assert type(again) is type(value)
        given = dict(arrays_in(again))
        assert given.keys() == expected.keys()
        for part, array in given.items():
            assert not array.flags.writeable, f"{name}{part} after {way}"
            exact = way != "replace"  # the constructor normalises quaternions once more
            np.testing.assert_allclose(array, expected[part], rtol=0, atol=0 if exact else 1e-15)


@pytest.mark.parametrize("name", NAMES)
def test_pickles_are_checked_again(name):
    value = made(name)
    for each in dataclasses.fields(value):
        array = getattr(value, each.name)
        if each.init and isinstance(array, np.ndarray) and name not in WITH_GAPS:
            if array.dtype != np.float64:
                continue
            wrong = object.__new__(type(value))
            vars(wrong).update(vars(value))
            vars(wrong)[each.name] = np.full_like(array, np.nan)
            refused("expected", pickle.loads, pickle.dumps(wrong))


@pytest.mark.parametrize("name", KINDS)
def test_skills_are_read_only_after_copies_and_pickles(name):
    of = KINDS[name]
    skill = of.build().fit(demonstrations(of))
    for way in ("deepcopy", "pickle"):
        writeable = [part for part, a in arrays_in(WAYS[way](skill)) if a.flags.writeable]
        assert not writeable, f"after {way}"


@pytest.mark.parametrize("name", KINDS)
def test_copied_states_go_on_to_the_bit(name):
    of = KINDS[name]
    skill = of.build().fit(demonstrations(of))
    if not hasattr(skill, "step") or not hasattr(skill, "begin"):
        return
    state = skill.step(skill.begin(), 0.02)
    expected = skill.step(state, 0.02)
    for way in ("copy", "deepcopy", "pickle"):
        again = skill.step(WAYS[way](state), 0.02)
        np.testing.assert_array_equal(again.position, expected.position)
        np.testing.assert_array_equal(again.velocity, expected.velocity)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_copied_field_of_arrival_times_is_updated_alike(dtype):
    grid = Grid((0.0, 0.0), 0.05, (20, 16))
    speed = np.random.default_rng(1).uniform(0.5, 2.0, grid.shape)
    field = ArrivalField(speed, grid, [0.2, 0.3], dtype=dtype)
    field.update_part((slice(8, 12), slice(4, 9)), 0.1)
    for way in ("copy", "deepcopy", "pickle"):
        again = WAYS[way](field)
        np.testing.assert_array_equal(again.times, field.times)
        again.update_part((slice(2, 4), slice(2, 4)), 3.0)
        assert (again.times != field.times).any()


MASKED = np.ma.masked_array(POINTS, mask=[[0, 0, 0], [0, 1, 0], [0, 0, 0]])


def test_a_mask_is_a_missing_value():
    for call in (
        lambda given: lt.Trajectory(TIMES, given),
        lambda given: lt.Trajectory(TIMES, list(given)),
        lambda given: lt.Trajectory(TIMES, given.astype(np.float32)),
        lambda given: lt.Box(given[1], POINTS[0]),
        lambda given: lt.PointCloud(given, 0.1),
        lambda given: lt.retime(given, lt.arm.JointLimits("abc", *np.ones((5, 3)))),
    ):
        refused("got nan at index", call, MASKED)
    ur3, row = arm("ur3"), np.ma.masked_array(np.full(6, 0.1), mask=[0, 0, 1, 0, 0, 0])
    for call in (ur3.jacobian, ur3.forward_kinematics):  # of one configuration, in the core
        refused("q: expected finite numbers, got nan at index 2", call, row)
    limits = lt.arm.JointLimits("abcdef", *np.ones((5, 6)))
    refused("velocity", dataclasses.replace, limits, velocity=row)
    field = np.ma.masked_array(np.ones((3, 3)), mask=np.eye(3))
    refused("speed: expected numbers, got masked ones", lt.arrival_times, field, [[0, 1]])
    whole = np.ma.masked_array(POINTS, mask=False)
    np.testing.assert_array_equal(lt.Trajectory(TIMES, whole).positions, POINTS)
    recorded = lt.io.Recording(TIMES, MASKED)
    np.testing.assert_array_equal(np.isnan(recorded.positions), MASKED.mask)


def test_a_changed_copy_of_an_obstacle_is_refused():
    box = copy.deepcopy(lt.Box((0.1, 0.2, 0.3), (0.4, 0.0, 0.3)))
    with pytest.raises(ValueError, match="read-only"):
        box.position[0] = np.nan
