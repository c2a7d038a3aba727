"""700 published problems for a Panda: paths by RRT-Connect, ours checked continuously.

`connect_configurations` connects the start with the goal, and the answer is checked between its
configurations. Beside it OMPL's RRT-Connect is run as it comes, with the same arm and the same
obstacles: it looks at edges at places only, so some of its ways touch in between. The margin is 0:
goals grasp things. If coal and Pinocchio are installed, distances and verdicts for the bundled
Panda are compared with theirs in each scene, at the start, the goal and four random configurations.
"""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.motion_planning import connect_configurations
from leadthrough_studies import coal_arm
from leadthrough_studies.coal_arm import CoalArm
from leadthrough_studies.connection.problems import ARCHIVE, KINDS, Problem, panda, problems
from leadthrough_studies.connection.report import report
from leadthrough_studies.study import Row, Study, Task

_TOGETHER = 10  # problems of a task
_STEPS = 200_000  # that the plain planner may take
_RANDOM = 4  # configurations, beside the ends
_TOUCHING = 1e-6  # m that bodies may overlap and count as apart


@dataclass(frozen=True)
class ConnectionConfig:
    """The configuration of the study.

    Attributes:
        archive: address of the published problems.
        kinds: of problems.
        count: of each kind, 1 to 100.
        seed: of the random configurations and of both planners.
    """

    archive: str
    kinds: tuple[str, ...] = KINDS
    count: int = 100
    seed: int = 0


def configure(quick: bool, seed: int) -> ConnectionConfig:
    """All problems in the folder of recordings, or two of each kind.

    Raises:
        InvalidInput: if LEADTHROUGH_DATA names no folder with the problems.
    """
    archive = Path(os.environ.get("LEADTHROUGH_DATA", "")) / ARCHIVE
    if not archive.is_file():
        raise InvalidInput(
            f"LEADTHROUGH_DATA: expected a folder with {ARCHIVE}, found no {archive}"
        )
    return ConnectionConfig(str(archive), count=2 if quick else 100, seed=seed)


def tasks(config: ConnectionConfig) -> list[Task]:
    """A task for every ten problems of a kind."""
    numbers = range(1, config.count + 1)
    return [
        Task(
            connect,
            {
                "archive": config.archive,
                "kind": kind,
                "numbers": list(numbers[first : first + _TOGETHER]),
                "seed": config.seed,
            },
        )
        for kind in config.kinds
        for first in range(0, config.count, _TOGETHER)
    ]


def connect(*, archive: str, kind: str, numbers: list[int], seed: int) -> list[Row]:
    """A row for each problem: results of both planners, and coal's verdict on the scene."""
    arm = panda()
    bundled = Arm.load("panda")
    peer = CoalArm(bundled) if coal_arm.installed() else None
    rows = []
    for number, problem in zip(numbers, problems(Path(archive), kind, numbers), strict=True):
        row = {"kind": kind, "number": number, **_ways(arm, problem, seed)}
        if peer:
            rng = np.random.default_rng([seed, number])
            row |= _compared(bundled, peer, problem, rng)
        rows.append(row)
    return rows


def _ways(arm: Arm, problem: Problem, seed: int) -> Row:
    ends = np.vstack([problem.start, problem.goal])
    begin = time.process_time()
    way = connect_configurations(arm, problem.start, problem.goal, problem.scene, seed=seed)
    own = time.process_time() - begin
    begin = time.process_time()
    plain = _plain(arm, problem, seed)
    theirs = time.process_time() - begin
    return {
        "ends_clear": int(np.all(arm.is_clear(ends, problem.scene))),
        "solved": int(way is not None),
        "certified": int(way is not None and arm.check(way, problem.scene).ok),
        "connect_cpu_s": own,
        "plain_solved": int(plain is not None),
        "plain_touches": int(plain is not None and not arm.check(plain, problem.scene).ok),
        "plain_cpu_s": theirs,
    }


def _plain(arm: Arm, problem: Problem, seed: int) -> Float64Array | None:
    """A way by RRT-Connect with OMPL's own settings, None if it finds none."""
    base, geometric, util = (
        check.package(f"ompl.{name}", extra="rivals") for name in ("base", "geometric", "util")
    )
    util.setLogLevel(util.LOG_NONE)
    util.RNG.setSeed(seed + 1)
    joints = len(problem.start)
    space, bounds = base.RealVectorStateSpace(joints), base.RealVectorBounds(joints)
    for i in range(joints):
        bounds.setLow(i, float(arm.limits.lower[i]))
        bounds.setHigh(i, float(arm.limits.upper[i]))
    space.setBounds(bounds)
    setup = geometric.SimpleSetup(space)

    def values(state: Any) -> Float64Array:  # of OMPL, which declares no types
        return np.array([state[i] for i in range(joints)])

    def state_at(q: Float64Array) -> Any:
        state = space.allocState()
        for i, value in enumerate(q):
            state[i] = float(value)
        return state

    scene = problem.scene
    setup.setStateValidityChecker(lambda state: arm.is_clear(values(state), scene))
    setup.setStartAndGoalStates(state_at(problem.start), state_at(problem.goal))
    setup.setPlanner(geometric.RRTConnect(setup.getSpaceInformation()))
    left = iter(range(_STEPS))
    setup.solve(base.PlannerTerminationCondition(lambda: next(left, None) is None))
    if not setup.haveExactSolutionPath():
        return None
    return np.array([values(state) for state in setup.getSolutionPath().getStates()])


def _compared(arm: Arm, peer: CoalArm, problem: Problem, rng: np.random.Generator) -> Row:
    """How far distances differ where both are apart, and how many verdicts differ."""
    some = rng.uniform(arm.limits.lower, arm.limits.upper, (_RANDOM, len(problem.start)))
    rows = np.vstack([problem.start, problem.goal, some])
    solids = [peer.solid(shape) for shape in problem.obstacles]
    links = peer.moving_links()
    differs, verdicts = 0.0, 0
    distances = np.asarray(arm.distance(rows, problem.scene))
    clear = np.asarray(arm.is_clear(rows, problem.scene))
    for q, ours, verdict in zip(rows, distances, clear, strict=True):
        peer.place(q)
        theirs = min(peer.distance_to(links, *solid) for solid in solids)
        itself = min(peer.link_distance(*pair) for pair in arm.collision_pairs.checked)
        if theirs > 0.0:
            differs = max(differs, abs(ours - theirs))
        verdicts += int(verdict != (min(theirs, itself) > -_TOUCHING))
    return {"compared": len(rows), "distance_differs_m": differs, "verdicts_differ": verdicts}


STUDY = Study(configure, tasks, report)
