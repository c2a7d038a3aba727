"""A start or goal that was not shown moves a motion by no more than it is moved itself.

A family joins with a line of MODELS.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from kinds import kind
from models.marching.paths import assert_bounded as assert_bounded_route
from motions import reach

from leadthrough import rotations
from leadthrough.models import FastMarchingSkill
from leadthrough.preprocess import by_arc_length, frechet_distance

# Fréchet distance to the motion between the ends as shown, over the offset.
MOST = 1.5
OFFSETS = (0.01, 0.1, 1.0, 3.0)  # in sizes of the motion, or rad
SAMPLES = 81
# Of a motion where one sample of one demonstration moves by a millimetre, m.
MAX_OF_ONE_SAMPLE = {"GMR": 1e-3, "TaskGMR": 2e-3}

MODELS = {
    "movement primitive": kind("DMP"),
    "movement primitive of joints": kind("DMP", "joints"),
    "movement primitive of poses": kind("DMP", "poses"),
    "probabilistic primitive": kind("ProMP"),
    "probabilistic primitive of joints": kind("ProMP", "joints"),
    "probabilistic primitive of poses": kind("ProMP", "poses"),
    "mixture": kind("GMR", starts=1),
    "mixture of joints": kind("GMR", "joints", starts=1),
    "aligned mean": kind("AlignedMean"),
    "aligned mean of joints": kind("AlignedMean", "joints"),
    "aligned mean of poses": kind("AlignedMean", "poses"),
    "fast marching": kind("FastMarching", "drawings"),
    "fast marching of poses": kind("FastMarching", "poses"),
}

# With the mixtures whose ends test_moved.py moves.
STEADY = MODELS | {
    "mixture of poses": kind("GMR", "poses"),
    "task mixture": kind("TaskGMR", starts=1),
    "task mixture of joints": kind("TaskGMR", "joints", starts=1),
    "task mixture of poses": kind("TaskGMR", "poses"),
}

COUNTS = dict.fromkeys(MODELS, (2, 40)) | {"fast marching of poses": (5,)}  # a slow model


@pytest.fixture(params=[(name, count) for name in MODELS for count in COUNTS[name]], ids=str)
def skill(request):
    name, count = request.param
    return fitted(name, count)


@pytest.fixture(
    params=[(n, k) for n, each in MODELS.items() if each.motion == "poses" for k in COUNTS[n]],
    ids=str,
)
def turning_skill(request):
    name, count = request.param
    return fitted(name, count)


@cache
def fitted(name, count, pace=1.0):
    each = STEADY[name]
    return each.build().fit([reach(each.motion, seed, pace=pace) for seed in range(count)])


def sampled(motion):
    rows = np.linspace(0, len(motion.times) - 1, SAMPLES).round().astype(int)
    return motion.positions[rows], getattr(motion, "orientations", motion.positions)[rows]


def frechet(distances):
    """The discrete Fréchet distance of two curves with distances (n, m) between their samples."""
    reach = np.maximum.accumulate(distances[0])
    for row in distances[1:]:
        before, reach = reach, np.empty_like(row)
        reach[0] = max(before[0], row[0])
        for j in range(1, len(row)):
            reach[j] = max(row[j], min(before[j], before[j - 1], reach[j - 1]))
    return reach[-1]


def assert_bounded(skill, query, offset):
    """That ends moved by an offset move the motion by no more than 1.5 times as much.

    Fast marching plans anew.
    """
    if isinstance(skill, FastMarchingSkill):
        assert_bounded_route(skill, usual_route(skill), skill.plan(**query), offset)
        return
    plain, made = usual(skill), skill.generate(**query, dt=0.02)
    curves = [by_arc_length(each.positions, SAMPLES) for each in (plain, made)]
    assert frechet_distance(*curves) <= MOST * offset


@cache
def usual(skill):
    return skill.generate(dt=0.02)


@cache
def usual_route(skill):
    return skill.plan()


def directions(seed, dimensions=3, count=3):
    found = np.random.default_rng(seed).normal(size=(count, dimensions))
    return found / np.linalg.norm(found, axis=1)[:, None]


def ways_to_move(skill, seed):
    """Directions for the positions; one for fast marching in space, which takes its time."""
    dimensions = usual(skill).positions.shape[1]
    slow = isinstance(skill, FastMarchingSkill) and dimensions == 3
    return directions(seed, dimensions, 1 if slow else 3)


def end(motion, index, moved):
    """The start or the goal, moved."""
    position = motion.positions[index] + moved
    return (position, motion.orientations[index]) if hasattr(motion, "orientations") else position


def beside(kind, *offset):
    return np.array(offset[:2] if kind == "drawings" else offset)


@pytest.mark.parametrize("offset", OFFSETS)
@pytest.mark.parametrize(("name", "index"), [("start", 0), ("goal", -1)])
def test_moved_end_moves_no_more_than_its_offset(skill, name, index, offset):
    plain = usual(skill)
    way = offset * np.linalg.norm(np.ptp(plain.positions, axis=0))
    for direction in ways_to_move(skill, 1):
        assert_bounded(skill, {name: end(plain, index, way * direction)}, way)


def test_both_ends_moved_move_no_more_than_the_larger_offset(skill):
    plain = usual(skill)
    for one, other in zip(ways_to_move(skill, 2), ways_to_move(skill, 3), strict=True):
        query = {"start": end(plain, 0, 0.2 * one), "goal": end(plain, -1, 0.3 * other)}
        assert_bounded(skill, query, 0.3)


@pytest.mark.parametrize("offset", OFFSETS[:3])
def test_ends_moved_together_or_against_each_other_move_no_more(skill, offset):
    """Against each other, ends may come to lie where the other one was: no motion turns around."""
    plain = usual(skill)
    way = offset * np.linalg.norm(np.ptp(plain.positions, axis=0))
    along = plain.positions[-1] - plain.positions[0]
    for move in way * np.vstack([ways_to_move(skill, 5)[:1], along / np.linalg.norm(along)]):
        for sign in (1.0, -1.0):
            query = {"start": end(plain, 0, move), "goal": end(plain, -1, sign * move)}
            assert_bounded(skill, query, way)


@pytest.mark.parametrize("angle", OFFSETS)
@pytest.mark.parametrize(("name", "index"), [("start", 0), ("goal", -1)])
def test_turned_end_turns_no_more_than_its_offset(turning_skill, name, index, angle):
    skill = turning_skill
    plain = skill.generate(dt=0.02)
    for axis in directions(4):
        turn = rotations.exp(angle * axis[None])
        wanted = rotations.compose(turn, plain.orientations[[index]])[0]
        made = skill.generate(**{name: (plain.positions[index], wanted)}, dt=0.02)
        q, p = sampled(plain)[1], sampled(made)[1]
        between = 2.0 * np.arccos(np.clip(np.abs(q @ p.T), 0.0, 1.0))
        assert frechet(between) <= MOST * angle + 1e-6


@pytest.mark.parametrize("name", [name for name, each in STEADY.items() if each.motion == "poses"])
@pytest.mark.parametrize("wobble", [0.0, 1e-9, 1e-7, 1e-5])
def test_turning_the_goal_of_a_tool_that_only_rounding_turned_moves_the_tip_little(name, wobble):
    """As an arm moves it whose inverse kinematics keeps the orientation."""
    rng = np.random.default_rng(0)
    motions = [reach("poses", seed) for seed in range(2)]
    held = [
        replace(each, orientations=rotations.exp(wobble * rng.normal(size=each.positions.shape)))
        for each in motions
    ]
    skill = STEADY[name].build().fit(held)
    own = skill.generate(dt=0.02)
    for angle in (1e-6, 1e-3, 0.3):
        turned = rotations.compose(rotations.exp([[angle, 0.0, 0.0]]), own.orientations[-1:])[0]
        made = skill.generate(goal=(own.positions[-1], turned), dt=0.02)
        # A task's frame turns about the goal, and the motion with it.
        moved = np.linalg.norm(made.positions - own.positions, axis=1).max()
        assert moved <= MOST * angle * np.linalg.norm(np.ptp(own.positions, axis=0)) + 1e-3


@pytest.mark.parametrize("name", STEADY)
@pytest.mark.parametrize("pace", [0.1, 10.0])
def test_time_scale_does_not_matter(name, pace):
    plain, scaled = fitted(name, 3), fitted(name, 3, pace)
    goal = end(plain.generate(), -1, beside(STEADY[name].motion, 0.02, -0.03, 0.01))
    here = plain.generate(goal=goal, duration=2.0, dt=0.02)
    there = scaled.generate(goal=goal, duration=2.0 * pace, dt=0.02 * pace)
    np.testing.assert_allclose(there.positions, here.positions, atol=1e-6)


@pytest.mark.parametrize("name", STEADY)
def test_a_millimetre_in_one_sample_changes_the_motion_by_a_few_at_most(name):
    model, of = STEADY[name].build(), STEADY[name].motion
    motions = [reach(of, seed) for seed in range(3)]
    goal = end(motions[0], -1, beside(of, 0.05, -0.05, 0.02))
    plain = fitted(name, 3).generate(goal=goal, duration=2.0)
    for row in (0, 40, 120):
        moved = motions[0].positions.copy()
        moved[row] += beside(of, 1e-3, 0.0, 0.0)
        changed = [replace(motions[0], positions=moved), *motions[1:]]
        made = model.fit(changed).generate(goal=goal, duration=2.0)
        most = MAX_OF_ONE_SAMPLE.get(STEADY[name].family, 3e-3)
        assert np.linalg.norm(made.positions - plain.positions, axis=1).max() <= most
