"""What every model promises of every type of motion. A new one joins with one line in MODELS."""

from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import FitError, InvalidInput
from leadthrough.models import CLFDM, FSMDM, LPVDS, SEDS, UMIC, ModifiedDS, TaskGMR

T = np.linspace(0.0, 1.0, 150)
U = 10 * T**3 - 15 * T**4 + 6 * T**5
SHIFTS = (-0.02, 0.0, 0.02)
OPENED = lt.Event(1.4, "opened")


def point_arch(shift, scale=1.0):
    points = np.column_stack([0.3 * U, 0.1 * np.sin(np.pi * U) + shift * (1 - U)])
    return lt.Trajectory(1.5 * T, scale * points)


def joint_arch(shift, scale=1.0):
    bow = 0.1 * np.sin(np.pi * U) + shift * (1 - U)
    joints = np.column_stack([0.3 * U, bow, -0.2 * U])
    return lt.JointTrajectory(1.5 * T, scale * joints, joint_names=("a", "b", "c"))


def pose_arch(shift, scale=1.0):
    """Turns by 290 degrees about an axis that leans with the shift."""
    bow = 0.1 * np.sin(np.pi * U) + shift * (1 - U)
    points = np.column_stack([0.3 * U, bow, 0.1 * U])
    turned = rotations.exp(np.outer(5.0 * U, [shift, 0.6, 0.8]))
    return lt.PoseTrajectory(1.5 * T, scale * points, turned)


def point_round(shift, scale=1.0):
    angle = 2 * np.pi * np.append(T[:-1], 1.0)
    points = np.column_stack([0.1 * np.cos(angle), (0.1 + shift) * np.sin(angle)])
    return lt.Trajectory(1.5 * T, scale * points)


def pose_round(shift, scale=1.0):
    flat = point_round(shift, scale)
    points = np.column_stack([flat.positions, np.zeros(len(T))])
    tilt = np.outer(0.5 * np.sin(2 * np.pi * T), [1.0, 0.0, 0.0])
    return lt.PoseTrajectory(flat.times, points, rotations.exp(tilt))


def turned(*vector):
    return rotations.exp([vector])[0]


@dataclass(frozen=True)
class Space:
    """One type of motion: how it is shown, a start and a goal to ask for, one that is wrong.

    ends: whether the goal is where the motion ends; a rhythm's is its centre. slowly: how to ask
    for twice the time.
    """

    shown: Any
    start: Any
    goal: Any
    wrong: Any
    ends: bool = True
    slowly: Any = field(default_factory=lambda: {"duration": 3.0})


POINTS = Space(point_arch, (0.02, 0.03), (0.33, -0.02), (0.0,))
JOINTS = Space(joint_arch, (0.02, 0.03, 0.0), (0.33, -0.02, -0.1), (0.0, 0.0))
POSES = Space(
    pose_arch,
    ((0.02, 0.03, 0.0), turned(0.2, 0.1, 0.0)),
    ((0.33, -0.02, 0.1), turned(0.0, 3.2, 4.1)),
    ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0, 1.0)),
)
ROUNDS = Space(point_round, (0.15, 0.0), (0.05, 0.01), (0.0,), ends=False, slowly={"period": 3.0})
POSE_ROUNDS = Space(
    pose_round,
    ((0.15, 0.0, 0.0), turned(0.2, 0.1, 0.0)),
    ((0.05, 0.01, 0.0), turned(0.0, 0.0, 1.0)),
    ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0, 1.0)),
    ends=False,
    slowly={"period": 3.0},
)

MODELS = {
    "movement primitive": (lt.DMP(), POINTS),
    "movement primitive of joints": (lt.DMP(), JOINTS),
    "movement primitive, by its force": (lt.DMP(regression="ridge"), POINTS),
    "movement primitive of poses": (lt.PoseDMP(), POSES),
    "movement primitive, rhythmic": (lt.RhythmicDMP(), ROUNDS),
    "movement primitive of poses, rhythmic": (lt.RhythmicPoseDMP(), POSE_ROUNDS),
    "fast marching": (lt.FastMarching(), POINTS),
    "fast marching of poses": (lt.FastMarching(), POSES),
    "fast marching, one map": (lt.FastMarching(method="map"), POINTS),
    "fast marching, by start": (lt.FastMarching(method="start"), POINTS),
    "ProMP": (lt.ProMP(), POINTS),
    "ProMP of joints": (lt.ProMP(), JOINTS),
    "ProMP of poses": (lt.ProMP(), POSES),
    "ProMP, B-splines": (lt.ProMP(basis="bspline"), POINTS),
    "ProMP, by EM": (lt.ProMP(estimator="em"), POINTS),
    "ProMP of poses, by EM": (lt.ProMP(estimator="em"), POSES),
    "GMR": (lt.GMR(), POINTS),
    "GMR of joints": (lt.GMR(), JOINTS),
    "GMR of poses": (lt.GMR(), POSES),
    "GMR, task-parameterised": (TaskGMR(components=4), POINTS),
    "GMR of joints, task-parameterised": (TaskGMR(components=4), JOINTS),
    "GMR of poses, task-parameterised": (TaskGMR(components=4), POSES),
    "SEDS": (SEDS(components=3), POINTS),
    "SEDS of joints, least squares": (SEDS(components=3, objective="mse"), JOINTS),
    "LPV-DS of joints": (LPVDS(components=4), JOINTS),
    "CLF-DM": (CLFDM(components=4, quadratics=1), POINTS),
    "FSM-DM": (FSMDM(units=10), POINTS),
    "UMIC": (UMIC(kernels=12), POINTS),
    "modified system": (ModifiedDS(units=40, energy_units=5), POINTS),
}


def demonstrations(space, scale=1.0):
    return [lt.Demonstration(space.shown(shift, scale)) for shift in SHIFTS]


def rows(motion):
    """(n, columns) of all that the motion says."""
    if isinstance(motion, lt.PoseTrajectory):
        return np.hstack([motion.positions, motion.orientations])
    return motion.positions


def assert_at(motion, index, wanted):
    """That the motion has a pose, or a point, at one of its samples."""
    position = wanted[0] if isinstance(motion, lt.PoseTrajectory) else wanted
    np.testing.assert_allclose(motion.positions[index], position, atol=1e-8)
    if isinstance(motion, lt.PoseTrajectory):
        gap = rotations.distance(motion.orientations[[index]], wanted[1][None])
        np.testing.assert_allclose(gap, 0.0, atol=1e-7)


@pytest.fixture(params=MODELS, ids=str)
def case(request):
    return MODELS[request.param]


@pytest.fixture
def model(case):
    return case[0]


@pytest.fixture
def space(case):
    return case[1]


@pytest.fixture
def shown(space):
    return demonstrations(space)


@pytest.fixture
def skill(model, space):
    return fitted(model, space.shown)[0]


@cache
def fitted(model, motion):
    """The skill that a model learns, which tests share, as it is frozen, and what it was shown."""
    seen = [lt.Demonstration(motion(shift)) for shift in SHIFTS]
    return model.fit(seen), seen


def test_fit_leaves_model_and_demonstrations_alone_and_returns_a_frozen_skill(model, space, shown):
    skill, seen = fitted(model, space.shown)
    assert skill is not model
    for demonstration, untouched in zip(seen, shown, strict=True):
        np.testing.assert_array_equal(rows(demonstration.motion), rows(untouched.motion))
    with pytest.raises(AttributeError):
        skill.model = ()


def test_generated_motion_is_of_the_type_shown_and_like_it(skill, shown):
    motion, middle = skill.generate(), shown[1].motion
    assert type(motion) is type(middle)
    gaps = np.linalg.norm(middle.positions[:, None] - motion.positions[None], axis=2)
    assert gaps.min(axis=1).max() < 0.03
    assert motion.duration == pytest.approx(1.5, rel=0.1)
    if isinstance(motion, lt.JointTrajectory):
        assert motion.joint_names == middle.joint_names
    if isinstance(motion, lt.PoseTrajectory):
        there = rotations.interpolate(
            middle.times / middle.duration, middle.orientations, motion.times / motion.duration
        )
        assert rotations.distance(motion.orientations, there).max() < 0.3


def test_generated_arrays_are_finite_contiguous_and_read_only(skill):
    motion = skill.generate()
    assert (np.diff(motion.times) > 0.0).all()
    for array in (value for value in vars(motion).values() if isinstance(value, np.ndarray)):
        assert np.isfinite(array).all()
        assert array.flags.c_contiguous
        assert not array.flags.writeable
    if isinstance(motion, lt.PoseTrajectory):
        np.testing.assert_allclose(np.linalg.norm(motion.orientations, axis=1), 1.0, atol=1e-14)
        assert (np.einsum("ij,ij->i", motion.orientations[1:], motion.orientations[:-1]) > 0).all()


def test_new_start_goal_and_duration_are_met(skill, space):
    assert {"start", "goal", "duration"} <= skill.supports
    motion = skill.generate(start=space.start, goal=space.goal, duration=4.0, dt=0.02)
    assert_at(motion, 0, space.start)
    if space.ends:
        assert_at(motion, -1, space.goal)
    assert motion.times[0] == 0.0
    assert motion.duration == pytest.approx(4.0)
    assert np.diff(motion.times).max() <= 0.02 + 1e-12


def test_same_query_gives_the_same_bits(model, skill, space, shown):
    again = model.fit(shown).generate(start=space.start)
    assert rows(again).tobytes() == rows(skill.generate(start=space.start)).tobytes()


def test_saved_skill_comes_back_with_the_same_bits(skill, tmp_path):
    path = tmp_path / "skill.npz"
    skill.save(path)
    loaded = lt.load_skill(path)
    assert type(loaded) is type(skill)
    assert rows(loaded.generate()).tobytes() == rows(skill.generate()).tobytes()
    assert [file.name for file in tmp_path.iterdir()] == ["skill.npz"]


def test_events_come_where_they_were_shown_to_and_are_saved(model, space, shown, tmp_path):
    with_events = [
        lt.Demonstration(replace(each.motion, events=(lt.Event(0.6 + late, "shut"), OPENED)))
        for each, late in zip(shown, (0.0, 0.1, 0.2), strict=True)
    ]
    skill = model.fit(with_events)
    made = skill.generate(goal=space.goal, **space.slowly)
    assert [event.name for event in made.events] == ["shut", "opened"]
    assert made.events[0].time == pytest.approx(1.4, abs=0.06)  # the mean, in twice the time
    assert made.events[1].time == pytest.approx(2.8, abs=0.06)
    skill.save(tmp_path / "skill.npz")
    assert lt.load_skill(tmp_path / "skill.npz").generate().events == skill.generate().events


def test_one_demonstration_is_enough(model, shown):
    motion = model.fit(shown[:1]).generate()
    np.testing.assert_allclose(motion.positions[-1], shown[0].motion.positions[-1], atol=1e-5)


def test_scale_of_the_data_does_not_matter(model, space):
    metres = model.fit(demonstrations(space)).generate()
    millimetres = model.fit(demonstrations(space, scale=1000.0)).generate()
    np.testing.assert_allclose(millimetres.positions, 1000 * metres.positions, atol=1e-2)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("start", lambda space: with_nan(space.start)),
        ("goal", lambda space: space.wrong),
        ("duration", lambda _: -1.0),
        ("dt", lambda _: 0.0),
        ("start", lambda _: "here"),
    ],
    ids=["start not a number", "wrong goal", "negative duration", "no step", "text"],
)
def test_bad_query_is_refused_by_name(skill, space, name, value):
    with pytest.raises(InvalidInput, match=name):
        skill.generate(**{name: value(space)})


def with_nan(wanted):
    """A point, or a pose, one of whose coordinates is not a number."""
    if isinstance(wanted[0], tuple):
        return with_nan(wanted[0]), wanted[1]
    return (np.nan, *wanted[1:])


def test_bad_demonstrations_are_refused(model, shown):
    motion = shown[0].motion
    for times in ([0.0, 1.0], [0.0]):  # one that does not move, one of a single sample
        held = [motion.positions[[0] * len(times)]]
        if isinstance(motion, lt.PoseTrajectory):
            held.append(motion.orientations[[0] * len(times)])
        with pytest.raises(FitError):
            model.fit([lt.Demonstration(type(motion)(times, *held))])
    for bad in ([None], shown[0], 3):
        with pytest.raises(InvalidInput):
            model.fit(bad)
