"""Ways of an arm between two configurations, without a path of the tip: OMPL's RRT-Connect.

How long a search takes depends on luck more than on the problem, so it is broken off and begun
again with other random numbers, later each time (Luby, Sinclair and Zuckerman 1993). The way found
is checked without a gap between its configurations. If it touches, the next search looks at its
edges more closely; if none was found, less so. A number of steps bounds all searches, not the
time, and the random numbers have a seed, so the answer is the same each time.

Source: Kuffner and LaValle 2000; Sucan, Moll and Kavraki 2012 (OMPL).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.arm import Arm, check_arm
from leadthrough.arm.tip_path import CollisionTest
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.shapes import SceneLike, as_scene

# Between the configurations of an edge that are looked at, over the extent of the joints' space:
# finer where the way found is not clear between them.
_RESOLUTIONS = (0.01, 0.003, 0.001, 0.0003)
# Steps of the first two searches; the next two have twice as many, and so on.
_FIRST_STEPS = 500
# Of a joint that turns without end, rad.
_TURNS = 2.0 * np.pi


def connect_configurations(
    arm: Arm,
    start: ArrayLike,
    goals: ArrayLike,
    scene: SceneLike = (),
    *,
    seed: int = 0,
    steps: int = 200_000,
) -> Float64Array | None:
    """Configurations (m, joints) on a piecewise straight path from the start to one of the goals.

    The way has been shortened, and is clear all along. Needs the extra `ompl`.

    Args:
        start: configuration (joints,).
        goals: configurations (k, joints), or (joints,) for one.
        scene: to keep clear of by its margins.
        seed: of the random number generator, >= 0.
        steps: how often the trees of all searches may grow, >= 1.

    Returns:
        The way; None if none was found.

    Raises:
        MissingDependency: if OMPL is not installed.
    """
    check_arm(arm)
    joints = len(arm.joint_names)
    around = CollisionTest(arm._collision, as_scene(scene))
    begin = check.array(start, "start", shape=(joints,))
    ends = np.atleast_2d(check.array_of_rank(goals, "goals", shapes=((joints,), ("k", joints))))
    for name, q in (("start", begin[None]), ("goals", ends)):
        if np.any(q < arm.limits.lower) or np.any(q > arm.limits.upper):
            raise InvalidInput(f"{name}: expected joints inside the arm's limits, got {q.tolist()}")
    first = check.integer(seed, "seed", at_least=0) + 1  # OMPL keeps 0 for a seed of its own
    most = check.integer(steps, "steps", at_least=1)
    limits = arm.limits.lower, arm.limits.upper
    closeness = 0
    for count, few in enumerate(_broken_off(most)):
        found = _ways(
            around,
            limits,
            begin,
            ends,
            resolution=_RESOLUTIONS[closeness],
            seed=first + count,
            steps=few,
        )
        if way := [each for each in found if around.clear_along(each)]:
            return way[0]
        closeness += 1 if found else -1
        closeness = min(max(closeness, 0), len(_RESOLUTIONS) - 1)
    return None


def _broken_off(steps: int) -> Iterator[int]:
    """After how many steps each search is broken off; all together take the number given."""
    few = _FIRST_STEPS
    for count in itertools.count(1):
        yield min(few, steps)
        steps -= few
        if steps <= 0:
            return
        few *= 2 - count % 2


def _ways(
    around: CollisionTest,
    limits: tuple[Float64Array, Float64Array],
    start: Float64Array,
    goals: Float64Array,
    *,
    resolution: float,
    seed: int,
    steps: int,
) -> list[Float64Array]:
    """A way that is clear at this resolution, shortened first, then as found; none without one."""
    base, geometric, util = (
        check.package(f"ompl.{name}", extra="ompl") for name in ("base", "geometric", "util")
    )
    with _quiet(util):
        util.RNG.setSeed(seed)
        space = _space(base, limits, np.vstack([start[None], goals]), around)
        space.setStateValidityCheckingResolution(resolution)
        space.setup()
        problem = base.ProblemDefinition(space)
        problem.addStartState(_state(space, start))
        ends = base.GoalStates(space)
        for goal in goals:
            ends.addState(_state(space, goal))
        problem.setGoal(ends)
        planner = geometric.RRTConnect(space)
        planner.setProblemDefinition(problem)
        planner.setup()
        left = iter(range(steps))
        planner.solve(base.PlannerTerminationCondition(lambda: next(left, None) is None))
        if not problem.hasExactSolution():
            return []
        path = problem.getSolutionPath()
        found = _rows(path, len(start))
        geometric.PathSimplifier(space).simplifyMax(path)
        shortened = _rows(path, len(start))
    return [shortened, found]


def _space(
    base: Any,
    limits: tuple[Float64Array, Float64Array],
    ends: Float64Array,
    around: CollisionTest,
) -> Any:  # of OMPL, which declares no types
    """The joints' space, with what is clear in it."""
    lower = np.maximum(limits[0], ends.min(axis=0) - _TURNS)
    upper = np.minimum(limits[1], ends.max(axis=0) + _TURNS)
    joints = len(lower)
    space, bounds = base.RealVectorStateSpace(joints), base.RealVectorBounds(joints)
    for i in range(joints):
        bounds.setLow(i, float(lower[i]))
        bounds.setHigh(i, float(upper[i]))
    space.setBounds(bounds)
    information = base.SpaceInformation(space)
    information.setStateValidityChecker(
        lambda state: all(around.clear_rows(_values(state, joints)[None]))
    )
    return information


def _state(space: Any, q: Float64Array) -> Any:
    state = space.allocState()
    for i, value in enumerate(q):
        state[i] = float(value)
    return state


def _rows(path: Any, joints: int) -> Float64Array:
    return np.array([_values(state, joints) for state in path.getStates()])


def _values(state: Any, joints: int) -> Float64Array:
    return np.array([state[i] for i in range(joints)])


@contextmanager
def _quiet(util: Any) -> Iterator[None]:
    """OMPL prints what it does, and that seeds had been given before."""
    level = util.getLogLevel()
    util.setLogLevel(util.LOG_NONE)
    try:
        yield
    finally:
        util.setLogLevel(level)
