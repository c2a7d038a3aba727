"""The one door for demonstrations: the same answers, in the same words, from every model."""

import numpy as np
import pytest
from kinds import kind

import leadthrough as lt
from leadthrough.errors import FitError, InvalidInput

T = np.linspace(0.0, 1.0, 60)
LINE = np.column_stack([T, 0.3 * np.sin(3.0 * T), T**2])
POINTS = lt.Trajectory(T, LINE)
POSES = lt.PoseTrajectory(T, LINE, lt.rotations.exp(np.outer(T, [0.4, 0.0, 0.2])))
JOINTS = lt.JointTrajectory(T, LINE, joint_names=("a", "b", "c"))

LEARNERS = (
    kind("DMP"),
    kind("DMP", "poses"),
    kind("RhythmicDMP"),
    kind("RhythmicDMP", "poses"),
    kind("ProMP"),
    kind("GMR"),
    kind("TaskGMR"),
    kind("FastMarching", "poses"),
)


@pytest.fixture(params=LEARNERS, ids=str)
def case(request):
    return request.param.build(), POSES if request.param.motion == "poses" else POINTS


def test_a_motion_stands_for_a_demonstration_of_it(case):
    model, motion = case
    alone = model.fit([motion]).generate()
    shown = model.fit([lt.Demonstration(motion)]).generate()
    assert type(alone) is type(shown)
    assert alone.positions.tobytes() == shown.positions.tobytes()


def test_motions_and_demonstrations_may_be_mixed():
    later = lt.Trajectory(T, 1.1 * LINE)
    mixed = lt.ProMP().fit([POINTS, lt.Demonstration(later)]).generate()
    assert (
        mixed.positions.tobytes() == lt.ProMP().fit([POINTS, later]).generate().positions.tobytes()
    )


@pytest.mark.parametrize("wrap", [lambda motion: motion, lt.Demonstration], ids=["motion", "shown"])
def test_a_single_one_is_to_be_put_in_a_list(case, wrap):
    model, motion = case
    with pytest.raises(InvalidInput, match="put a single one in a list"):
        model.fit(wrap(motion))


def test_something_else_is_refused_with_what_came_and_where(case):
    model, motion = case
    with pytest.raises(InvalidInput, match=r"demonstrations\[1\].* got int"):
        model.fit([motion, 3])
    with pytest.raises(InvalidInput, match=r"demonstrations\[0\].* got NoneType"):
        model.fit([None])


def test_different_types_are_refused(case):
    model, motion = case
    with pytest.raises(InvalidInput, match="expected"):
        model.fit([motion, POSES if motion is POINTS else POINTS])


def test_different_numbers_of_columns_are_refused(case):
    model, motion = case
    if motion is POINTS:
        with pytest.raises(InvalidInput, match="same number of columns in all, got 2 and 3"):
            model.fit([motion, lt.Trajectory(T, LINE[:, :2])])


@pytest.mark.parametrize("family", ["DMP", "ProMP", "GMR", "TaskGMR", "RhythmicDMP"])
def test_different_joints_are_refused(family):
    model = kind(family, "joints").build()
    renamed = lt.JointTrajectory(T, LINE, joint_names=("a", "b", "d"))
    with pytest.raises(InvalidInput, match="same joint names"):
        model.fit([JOINTS, renamed])


def test_a_type_that_the_model_does_not_learn_is_refused_by_name():
    with pytest.raises(InvalidInput, match="Trajectory or PoseTrajectory, got JointTrajectory"):
        lt.FastMarching().fit([JOINTS])


def test_none_is_too_few_but_for_a_planner(case):
    model, _ = case
    if isinstance(model, lt.FastMarching):
        model.fit([])
    else:
        with pytest.raises(FitError, match="at least 1, got none"):
            model.fit([])


def test_numbers_that_overflow_are_refused(case):
    model, motion = case
    large = type(motion)(T, 1e101 * LINE, *([motion.orientations] if motion is POSES else []))
    with pytest.raises(FitError, match="use another unit"):
        model.fit([large])
