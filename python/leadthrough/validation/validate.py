"""A skill on an arm, asked at random: how often is its motion one that the arm can run?"""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough import check, optional, tasks
from leadthrough.arm import Arm
from leadthrough.arm.model import check_arm
from leadthrough.errors import InvalidInput
from leadthrough.io.atomic import replacing
from leadthrough.models.certificate import Certificate, ValidatedObstacle
from leadthrough.models.protocol import Skill
from leadthrough.models.targets import TargetRegion
from leadthrough.motion import Motion, PoseTrajectory
from leadthrough.shapes import SceneLike, as_scene
from leadthrough.simulation import Controller
from leadthrough.tasks import Outcome, Row, Store, Task
from leadthrough.validation.queries import Setup, answers
from leadthrough.validation.validation import ERROR, Findings, Validation

# Queries of a task: a second of work or so, beside which what a task costs does not count; of many
# runs more, so that a scheduler has no more than some 2000 tasks, and these are long.
_LEAST, _MOST, _TASKS = 20, 200, 2000


def validate(
    skill: Skill[Motion],
    arm: Arm,
    scene: SceneLike = (),
    *,
    goals: TargetRegion | None = None,
    starts: TargetRegion | None = None,
    runs: int = 1000,
    width: float | None = None,
    required: float = 0.95,
    confidence: float = 0.95,
    rate: float = 250.0,
    controller: Controller | None = None,
    seed: int = 0,
    on: str | None = None,
    out: Path | None = None,
    task_timeout: float | None = None,
    progress: tasks.Progress | None = None,
) -> Validation:
    """How often the arm can run the skill's motion, for queries drawn at random from regions.

    Each query goes the whole way: the skill's motion is planned for the whole arm, retimed inside
    its limits and checked, limits and collisions. The answer is the same wherever it is computed.

    Args:
        skill: of poses, of points in 3-D, or of the arm's joints, fitted or loaded.
        arm: that is to move.
        scene: of every query; the position of each `RandomObstacle` is drawn too.
        goals: where the goals lie; by default the demonstrated goal.
        starts: where the starts lie; by default the demonstrated start.
        runs: number of queries, >= 1; with `width`, the most.
        width: stop as soon as the interval is at most this wide, in (0, 1). It then is one of a
            confidence sequence, which is valid for this.
        required: fraction in (0, 1) for the part of the goals that the certificate names.
        confidence: of the interval and of that part, in (0, 1).
        rate: samples per second of the motions that are checked, > 0.
        controller: if given, each motion is simulated too, run by this controller as by
            `lt.simulate`; needs the extra `simulation`.
        seed: of the random number generator, >= 0.
        on: where to compute, as `leadthrough.tasks.run` takes it; None for this process.
        out: folder that keeps what is finished, made if missing; the same call goes on there. None
            keeps nothing.
        task_timeout: the longest that a task may take, of 20 to 200 queries, s; None for no
            bound.
        progress: shows the tasks' outcomes and passes them on: `leadthrough.tasks.with_progress`.

    Raises:
        InvalidInput: if an argument is wrong or a worker has other code.
        UnsupportedQuery: if the skill takes no start or no goal, and one is asked for.
        MissingDependency: if the extra `dask` is needed for a cluster, or `simulation` for a
            controller, and it is not installed.
        SchedulerUnreachable: if its scheduler does not answer any more.
    """
    check_arm(arm)
    most = check.integer(runs, "runs", at_least=1)
    check.number(required, "required", above=0.0, below=1.0)
    narrow = None if width is None else check.number(width, "width", above=0.0, below=1.0)
    first = check.integer(seed, "seed", at_least=0)
    setup = Setup(
        arm,
        _places(skill, goals, "goals", -1),
        _places(skill, starts, "starts", 0),
        as_scene(scene),
        check.number(rate, "rate", above=0.0),
        controller,
    )
    if controller is not None:
        optional.load("mujoco", extra="simulation")
    findings = Findings(setup.goals, check.number(confidence, "confidence", above=0.0, below=1.0))
    with ExitStack() as stack:
        folder = out or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        todo = _todo(skill, setup, folder, most, first)
        store = Store(folder / "cache")
        outcomes = tasks.run(todo, store, on=on, timeout=task_timeout)
        told = tasks.with_manifest(outcomes, folder)
        told = told if progress is None else progress(told, len(todo), "validating")
        _collected(told, todo, store, narrow, findings)
    certificate = Certificate(
        setup.goals,
        setup.starts,
        tuple(ValidatedObstacle.of(each) for each in setup.scene.obstacles),
        name_of(arm),
        setup.scene.margin,
        findings.runs,
        findings.successes,
        dict(findings.causes.most_common()),
        findings.interval if narrow is None else findings.sequence,
        confidence,
        "Clopper and Pearson" if narrow is None else "confidence sequence",
        required,
        findings.largest_part(required),
        first,
    )
    return findings.validation(certificate)


def _places(
    skill: Skill[Motion], asked: TargetRegion | None, name: str, index: int
) -> TargetRegion:
    """A region with the orientation in its middle, for a skill of poses."""
    motion = skill.generate()
    position = motion.positions[index]
    region = TargetRegion(position, position) if asked is None else asked
    if region.lower.shape != position.shape:
        raise InvalidInput(
            f"{name}: expected {len(position)} coordinates, as the skill's, got {len(region.lower)}"
        )
    if asked is not None:
        # The skill refuses what it has no say in, now and not in each of the queries.
        end: dict[str, Any] = {name.removesuffix("s"): region.middle}
        skill.generate(**end)
    if not isinstance(motion, PoseTrajectory):
        if region.turn:
            raise InvalidInput(f"{name}: expected no turn for a skill of {type(motion).__name__}")
        return region
    turned = motion.orientations[index] if region.orientation is None else region.orientation
    return TargetRegion(region.lower, region.upper, region.turn, turned)


def _todo(skill: Skill[Motion], setup: Setup, folder: Path, runs: int, seed: int) -> list[Task]:
    """The tasks, of some queries each, whose files are in the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    files = {"skill": folder / "skill.npz", "setup": folder / "setup.pickle"}
    skill.certified(None).save(files["skill"])
    with replacing(files["setup"]) as temporary:
        temporary.write_bytes(pickle.dumps(setup, protocol=5))
    each = min(max(_LEAST, runs // _TASKS), _MOST)
    return [
        Task(answers, {"first": first, "count": min(each, runs - first), "seed": seed}, files)
        for first in range(0, runs, each)
    ]


def _collected(
    outcomes: Iterator[Outcome],
    todo: Sequence[Task],
    store: Store,
    width: float | None,
    findings: Findings,
) -> None:
    """Collects the rows of the first tasks, of as many as the interval needs, or of all."""
    finished: dict[int, Outcome] = {}
    for each in outcomes:
        finished[each.index] = each
        while findings.batches in finished:
            task = todo[findings.batches]
            findings.add(_rows(task, finished.pop(findings.batches), store))
            if width is not None and np.ptp(findings.sequence) <= width:
                outcomes.close()  # type: ignore[attr-defined]  # a generator
                return


def _rows(task: Task, outcome: Outcome, store: Store) -> list[Row]:
    """The rows of a task; those of one that failed say so."""
    if outcome.failure is None:
        return store.rows(outcome.key) or []
    told = {"cause": ERROR, "detail": outcome.failure["message"], "start": None, "goal": None}
    first, count = task.arguments["first"], task.arguments["count"]
    return [{"number": number, **told} for number in range(first, first + count)]


def name_of(arm: Arm) -> str:
    """An arm, as certificates name it."""
    return f"{arm.robot.name} {arm.base} to {arm.tip}"
