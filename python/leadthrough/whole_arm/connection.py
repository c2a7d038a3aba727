"""Ways of an arm between two configurations, without a path of the tip: OMPL's RRT-Connect.

A number of steps bounds the search, not the time, and the random numbers have a seed, so the answer
is the same each time. Every edge is checked without a gap between its ends.

Source: Kuffner and LaValle 2000; Sucan, Moll and Kavraki 2012 (OMPL).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from leadthrough import optional
from leadthrough.arm.clearing import Surroundings
from leadthrough.check import Float64Array

# Length of an edge of the trees at the most, rad or m over all joints.
_RANGE = 1.0
# Of a joint that turns without end, rad.
_TURNS = 2.0 * np.pi


def connect(
    around: Surroundings,
    limits: tuple[Float64Array, Float64Array],
    start: Float64Array,
    goals: Float64Array,
    *,
    seed: int = 0,
    steps: int = 5000,
) -> Float64Array | None:
    """Configurations (m, joints) on straight ways from the start to one of the goals.

    The way has been shortened, and its corners have been cut.

    Args:
        around: what the arm keeps clear of, all along.
        limits: of the joints, lower and upper, (joints,) each.
        start: configuration (joints,), inside the limits.
        goals: configurations (k, joints), likewise.
        seed: of the random numbers, >= 0.
        steps: how often the trees may grow.

    Returns:
        The way, or None if none was found.

    Raises:
        MissingDependency: if OMPL is not installed.
    """
    base, geometric, util = (
        optional.load(f"ompl.{name}", extra="ompl") for name in ("base", "geometric", "util")
    )
    with _quiet(util):
        util.RNG.setSeed(seed + 1)  # OMPL keeps 0 for a seed of its own
        space = _space(base, limits, np.vstack([start[None], goals]), around)
        problem = base.ProblemDefinition(space)
        problem.addStartState(_state(space, start))
        ends = base.GoalStates(space)
        for goal in goals:
            ends.addState(_state(space, goal))
        problem.setGoal(ends)
        planner = geometric.RRTConnect(space)
        planner.setRange(_RANGE)
        planner.setProblemDefinition(problem)
        planner.setup()
        planner.solve(base.PlannerTerminationCondition(_after(steps)))
        if not problem.hasExactSolution():
            return None
        way = problem.getSolutionPath()
        geometric.PathSimplifier(space).simplifyMax(way)
        return np.array([_values(state, len(start)) for state in way.getStates()])


def _space(
    base: Any,
    limits: tuple[Float64Array, Float64Array],
    ends: Float64Array,
    around: Surroundings,
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
        lambda state: around.clear_along(_values(state, joints)[None])
    )

    class Edges(base.MotionValidator):  # type: ignore[misc]
        def checkMotion(self, a: Any, b: Any) -> bool:  # noqa: N802 (OMPL asks for this name)
            return around.clear_along(np.array([_values(a, joints), _values(b, joints)]))

    information.setMotionValidator(Edges(information))
    information.setup()
    return information


def _state(space: Any, q: Float64Array) -> Any:
    state = space.allocState()
    for i, value in enumerate(q):
        state[i] = float(value)
    return state


def _values(state: Any, joints: int) -> Float64Array:
    return np.array([state[i] for i in range(joints)])


def _after(steps: int) -> Callable[[], bool]:
    """True from the given number of calls on."""
    left = iter(range(steps))
    return lambda: next(left, None) is None


@contextmanager
def _quiet(util: Any) -> Iterator[None]:
    """OMPL prints what it does, and that seeds had been given before."""
    level = util.getLogLevel()
    util.setLogLevel(util.LOG_NONE)
    try:
        yield
    finally:
        util.setLogLevel(level)
