"""Success rate of a skill's motions on an arm, for random queries."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.check import ShortRepr
from leadthrough.models import Skill, TargetRegion
from leadthrough.models.certificate import Certificate, ConfidenceInterval, ValidatedScene
from leadthrough.motion import Motion
from leadthrough.shapes import SceneLike
from leadthrough.simulation import Controller
from leadthrough.tasks import Execution, Outcome, Row, Store, Task, pickled
from leadthrough.validation.queries import Setup, answers
from leadthrough.validation.validation import ERROR, Findings, Validation

# Queries of a task: at least a second of work, beside which a task's own costs do not count; more
# of many runs, so that a scheduler has at most some 2000 tasks.
_MIN_QUERIES, _MAX_QUERIES, _MAX_TASKS = 20, 200, 2000


@dataclass(frozen=True, eq=False)
class SamplingPlan(ShortRepr):
    """Number of random queries and certainty of their count.

    Attributes:
        runs: number of queries, >= 1; with `width`, the most.
        width: stop once the interval is at most this wide, in (0, 1). It then is one of a
            confidence sequence, which is valid for this.
        required: fraction in (0, 1) for the part of the goals that the certificate names.
        confidence: of the interval and of that part, in (0, 1).
        seed: of the random number generator, >= 0.
    """

    runs: int = 1000
    width: float | None = None
    required: float = 0.95
    confidence: float = 0.95
    seed: int = 0

    def __post_init__(self) -> None:
        check.integer(self.runs, "runs", at_least=1)
        for name in ("required", "confidence") + (() if self.width is None else ("width",)):
            check.number(getattr(self, name), name, above=0.0, below=1.0)
        check.integer(self.seed, "seed", at_least=0)


def validate(
    skill: Skill[Motion],
    arm: Arm,
    scene: SceneLike = (),
    *,
    goals: TargetRegion | None = None,
    starts: TargetRegion | None = None,
    plan: SamplingPlan | None = None,
    rate: float = 250.0,
    controller: Controller | None = None,
    execution: Execution | None = None,
) -> Validation:
    """Success rate of the skill's motions on the arm, for queries drawn at random from regions.

    Each query goes the whole way: the skill's motion is planned for the whole arm, retimed inside
    its limits and checked, limits and collisions. The answer is the same wherever it is computed.

    Args:
        skill: of poses, of points in 3-D, or of the arm's joints, fitted or loaded.
        scene: of every query; the position of each `RandomObstacle` is drawn too.
        goals: region of the goals; by default the demonstrated goal.
        starts: region of the starts; by default the demonstrated start.
        plan: number of queries, certainty and seed; by default 1000 queries.
        rate: samples per second of the motions that are checked, > 0.
        controller: if given, each motion is simulated too, run by this controller as by
            `lt.simulate`; needs the extra `simulation`.
        execution: process or cluster of the tasks, of 20 to 200 queries each, and folder of
            finished ones; by default here.

    Raises:
        InvalidInput: if a worker has other code.
        UnsupportedQuery: if the skill takes no start or no goal, and one is asked for.
        MissingDependency: if the extra `dask` is needed for a cluster, or `simulation` for a
            controller, and it is not installed.
        SchedulerUnreachable: if its scheduler does not answer any more.
    """
    sampling = SamplingPlan() if plan is None else plan
    setup = Setup.of(skill, arm, scene, (starts, goals), rate=rate, controller=controller)
    findings = Findings(setup.goals, sampling.confidence)
    how = Execution() if execution is None else execution
    with how.folder() as folder:
        todo = _todo(skill, setup, folder, sampling)
        store = Store(folder / "cache")
        outcomes = how.outcomes(todo, store, folder, "validating")
        _collected(outcomes, todo, store, sampling.width, findings)
    return findings.validation(_certificate(setup, sampling, findings))


def _certificate(setup: Setup, plan: SamplingPlan, findings: Findings) -> Certificate:
    """The certificate of the findings."""
    stopped_early = plan.width is not None
    return Certificate(
        setup.goals,
        setup.starts,
        ValidatedScene.of(setup.scene, name_of(setup.arm)),
        findings.runs,
        dict(findings.causes.most_common()),
        ConfidenceInterval(
            *(findings.sequence if stopped_early else findings.interval),
            plan.confidence,
            "confidence sequence" if stopped_early else "Clopper and Pearson",
        ),
        plan.required,
        findings.largest_part(plan.required),
        plan.seed,
    )


def _todo(skill: Skill[Motion], setup: Setup, folder: Path, plan: SamplingPlan) -> list[Task]:
    """The tasks, of some queries each, whose files are in the folder."""
    files = {"skill": folder / "skill.npz", "setup": pickled(setup, folder / "setup.pickle")}
    skill.certified(None).save(files["skill"])
    each = min(max(_MIN_QUERIES, plan.runs // _MAX_TASKS), _MAX_QUERIES)
    return [
        Task(
            answers,
            {"first": first, "count": min(each, plan.runs - first), "seed": plan.seed},
            files,
        )
        for first in range(0, plan.runs, each)
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
