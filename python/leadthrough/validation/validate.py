"""Success rate of a skill's motions on an arm, for random queries, and its bounds.

Source: Clopper and Pearson 1934, "The use of confidence or fiducial limits illustrated in the case
of the binomial", Biometrika 26(4). Robbins 1970, "Statistical methods related to the law of the
iterated logarithm", Ann. Math. Stat. 41(5): a likelihood ratio against a mixture of alternatives
exceeds 1 / alpha at any time with a probability of at most alpha (Ville's inequality).
"""

from __future__ import annotations

import math
import pickle
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import betaincinv, betaln, xlog1py, xlogy

from leadthrough import check, models, motion_planning, simulation
from leadthrough.arm import Arm, check_arm
from leadthrough.check import Float64Array, InvalidInput, LimitsInfeasible, NoPath, ShortRepr
from leadthrough.models import Certificate, Skill, Target, TargetRegion, ValidatedScene
from leadthrough.models.protocol import check_skill
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory
from leadthrough.shapes import Scene, SceneLike, as_scene
from leadthrough.tasks import Execution, Outcome, Row, Store, Task, pickled
from leadthrough.timing import check_limits, retime


@dataclass(frozen=True, eq=False)
class Failing(ShortRepr):
    """A query whose motion the arm cannot run.

    Attributes:
        number: of the query; with the seed it draws the query again.
        start: (d,), or of a pose (7,): position and w, x, y, z.
        goal: as the start.
        cause: in a word.
        detail: in a sentence.
        distance: from the middle of the goals, m (rad).
    """

    number: int
    start: Float64Array
    goal: Float64Array
    cause: str
    detail: str
    distance: float


@dataclass(frozen=True, eq=False)
class Validation(ShortRepr):
    """Success of a skill's motions on an arm.

    Attributes:
        certificate: the fractions and regions; `skill.certified(...)` keeps it with the skill.
        starts: (runs, d) of the queries, of poses (runs, 7).
        goals: (runs, d) of the queries, as the starts.
        causes: (runs,) why each failed, in a word; empty where it succeeded.
        nearest: the failing query nearest to the middle of the goals; None if none failed.
        errors: number of queries that were not answered, because a task failed; they count as
            failures, with the cause "error".
    """

    certificate: Certificate
    starts: Float64Array
    goals: Float64Array
    causes: NDArray[np.str_]
    nearest: Failing | None
    errors: int

    @property
    def succeeded(self) -> NDArray[np.bool_]:
        """(runs,) whether the arm can run the motion."""
        return np.asarray(self.causes == "")

    def __str__(self) -> str:
        return str(self.certificate)


# The cause of queries whose task failed.
ERROR = "error"
# Parts of the region of goals that are looked at: about its middle, by the length of their sides.
_PARTS = np.linspace(1.0, 0.1, 10)


class Findings:
    """Results up to now."""

    def __init__(self, goals: TargetRegion, confidence: float) -> None:
        self._goals = goals
        self._confidence = confidence
        self._starts: list[Float64Array] = []
        self._places: list[Float64Array] = []
        self._causes: list[str] = []
        self._nearest: Failing | None = None
        self.batches = 0
        self.causes: Counter[str] = Counter()

    def add(self, rows: Sequence[Row]) -> None:
        """Takes the answers of a task."""
        self.batches += 1
        self._starts += [_numbers(row["start"]) for row in rows]
        self._places += [_numbers(row["goal"]) for row in rows]
        self._causes += [row["cause"] for row in rows]
        for row in rows:
            if row["cause"]:
                self.causes[row["cause"]] += 1
                self._look_at(row)

    @property
    def runs(self) -> int:
        return len(self._causes)

    @property
    def successes(self) -> int:
        return self.runs - self.causes.total()

    @property
    def interval(self) -> tuple[float, float]:
        """Bounds of the fraction that succeeds, where the number of runs was fixed before."""
        return clopper_pearson(self.successes, self.runs, confidence=self._confidence)

    @property
    def sequence(self) -> tuple[float, float]:
        """Bounds of the fraction that succeeds, where one stops as they are narrow enough."""
        return confidence_sequence(self.successes, self.runs, confidence=self._confidence)

    def largest_part(self, required: float) -> TargetRegion | None:
        """The largest part of the goals, about their middle, in which enough queries succeed."""
        # For the lower of the two bounds alone, in all parts at once.
        each = 1.0 - 2.0 * (1.0 - self._confidence) / len(_PARTS)
        positions = _stacked(self._places)[:, : len(self._goals.lower)]
        if not positions.size:
            return None  # no query was answered
        succeeded = np.array([not cause for cause in self._causes])
        for factor in _PARTS:
            part = self._goals.shrunk(float(factor))
            inside = ((positions >= part.lower) & (positions <= part.upper)).all(axis=1)
            good, runs = int(succeeded[inside].sum()), int(inside.sum())
            if runs and clopper_pearson(good, runs, confidence=each)[0] >= required:
                return part
        return None

    def validation(self, certificate: Certificate) -> Validation:
        places, causes = _stacked(self._places), np.array(self._causes)
        starts = _stacked(self._starts)
        return Validation(certificate, starts, places, causes, self._nearest, self.causes[ERROR])

    def _look_at(self, row: Row) -> None:
        """Keeps a failure that is nearer to the middle of the goals than those before."""
        if row["goal"] is None:
            return
        goal = _numbers(row["goal"])
        away = float(np.linalg.norm(goal[: len(self._goals.lower)] - self._goals.middle))
        if self._nearest is None or away < self._nearest.distance:
            start, told = _numbers(row["start"]), (row["cause"], row["detail"])
            self._nearest = Failing(row["number"], start, goal, *told, away)


def _numbers(place: Sequence[float] | None) -> Float64Array:
    """A place as an array; an empty one where there was no answer."""
    return np.array(place or (), dtype=np.float64)


def _stacked(places: Sequence[Float64Array]) -> NDArray[np.float64]:
    """Places (runs, d), NaN of those that were not answered."""
    found = np.full((len(places), max(map(len, places), default=0)), np.nan)
    for row, place in zip(found, places, strict=True):
        row[: len(place)] = place
    return found


# The mixture is Jeffreys' prior of a fraction: Beta(1/2, 1/2).
_PRIOR = 0.5
_SMALLEST = 1e-15  # fraction: the bounds lie between this and 1 less this


def clopper_pearson(successes: int, runs: int, *, confidence: float = 0.95) -> tuple[float, float]:
    """Clopper-Pearson bounds of the success rate, for a number of runs fixed in advance.

    Args:
        successes: number of runs that succeeded.
        runs: number of all runs, >= 1.
        confidence: probability, in (0, 1), with which the bounds hold at least.
    """
    count, total = _counted(successes, runs)
    rest = 0.5 * (1.0 - check.number(confidence, "confidence", above=0.0, below=1.0))
    low = 0.0 if count == 0 else float(betaincinv(count, total - count + 1, rest))
    high = 1.0 if count == total else float(betaincinv(count + 1, total - count, 1.0 - rest))
    return low, high


def confidence_sequence(
    successes: int, runs: int, *, confidence: float = 0.95
) -> tuple[float, float]:
    """Lower and upper bound of the fraction that succeeds, valid whenever one stops to look.

    With the stated probability the bounds hold after every number of runs at once, so one may stop
    as soon as they are narrow enough.

    Args:
        successes: number of runs that succeeded until now.
        runs: number of all runs until now, >= 1.
        confidence: probability, in (0, 1), with which all bounds hold at least.
    """
    count, total = _counted(successes, runs)
    alpha = 1.0 - check.number(confidence, "confidence", above=0.0, below=1.0)
    failures = total - count
    mixed = betaln(_PRIOR + count, _PRIOR + failures) - betaln(_PRIOR, _PRIOR)

    def excess(fraction: float) -> float:
        """Of the logarithm of the likelihood ratio over that of 1 / alpha."""
        single = xlogy(count, fraction) + xlog1py(failures, -fraction)
        return float(mixed - single + math.log(alpha))

    best = count / total
    low = high = best
    if count > 0:
        low = float(brentq(excess, _SMALLEST, best)) if excess(_SMALLEST) > 0.0 else 0.0
    if failures > 0:
        top = 1.0 - _SMALLEST
        high = float(brentq(excess, best, top)) if excess(top) > 0.0 else 1.0
    return low, high


def _counted(successes: int, runs: int) -> tuple[int, int]:
    total = check.integer(runs, "runs", at_least=1)
    return check.integer(successes, "successes", at_least=0, at_most=total), total


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
    controller: simulation.Controller | None = None,
    execution: Execution | None = None,
) -> Validation:
    """Success rate of the skill's motions on the arm, for queries drawn at random from regions.

    For each query the skill's motion is planned for the whole arm, retimed inside its limits and
    checked for limits and collisions. The answer is the same wherever it is computed.

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
    stopped_early = plan.width is not None
    return Certificate(
        setup.goals,
        setup.starts,
        ValidatedScene.of(setup.scene, name_of(setup.arm)),
        findings.runs,
        dict(findings.causes.most_common()),
        models.ConfidenceInterval(
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
    return f"{arm.robot.name} {arm.base} to {arm.tip}"


# Path tolerance of retiming, rad or m.
PATH_TOLERANCE = 1e-4


@dataclass(frozen=True, eq=False)
class Setup:
    """Data common to all queries of a validation."""

    arm: Arm  # that is to move
    goals: TargetRegion  # of the queries
    starts: TargetRegion  # of the queries
    scene: Scene  # with the obstacles whose position is drawn
    rate: float  # of the motion that is checked, Hz
    controller: simulation.Controller | None  # of the simulated arm; None for no simulation

    @classmethod
    def of(
        cls,
        skill: Skill[Motion],
        arm: Arm,
        scene: SceneLike,
        regions: tuple[TargetRegion | None, TargetRegion | None],
        *,
        rate: float,
        controller: simulation.Controller | None,
    ) -> Setup:
        """The setup, checked, with regions of the starts and goals."""
        check_skill(skill)
        check_arm(arm)
        if controller is not None:
            check.package("mujoco", extra="simulation")
        starts, goals = regions
        return cls(
            arm,
            _region(skill, goals, "goals", -1),
            _region(skill, starts, "starts", 0),
            as_scene(scene),
            check.number(rate, "rate", above=0.0),
            controller,
        )


def _region(
    skill: Skill[Motion], asked: TargetRegion | None, name: str, index: int
) -> TargetRegion:
    """A region with the orientation in its middle, for a skill of poses."""
    motion = skill.generate()
    position = motion.positions[index]
    region = TargetRegion(position, position) if asked is None else asked
    if region.lower.shape != position.shape:
        raise check.refused(name, f"{len(position)} coordinates, as the skill's", len(region.lower))
    if asked is not None:
        # Queries that the skill does not support are refused at once, not in each of the runs.
        end: dict[str, Any] = {name.removesuffix("s"): region.middle}
        skill.generate(**end)
    if not isinstance(motion, PoseTrajectory):
        if region.turn:
            raise InvalidInput(f"{name}: expected no turn for a skill of {type(motion).__name__}")
        return region
    middle = motion.orientations[index] if region.orientation is None else region.orientation
    return TargetRegion(region.lower, region.upper, region.turn, middle)


def draw_query(setup: Setup, seed: int, number: int) -> tuple[motion_planning.Query, Scene]:
    """A query of a validation and its scene, the same wherever and whenever they are drawn."""
    rng = np.random.default_rng([seed, number])
    start, goal = setup.starts.draw(rng), setup.goals.draw(rng)
    return motion_planning.Query(start, goal), setup.scene.draw(rng)


def answers(*, first: int, count: int, seed: int, skill: Path, setup: Path) -> list[Row]:
    """A row for each of some queries: start, end, and the reason if the motion fails."""
    learned = models.load_skill(skill)
    common: Setup = pickle.loads(setup.read_bytes())
    rows = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # unusual queries show in their motions
        for number in range(first, first + count):
            asked, scene = draw_query(common, seed, number)
            cause, detail = answer(learned, common, asked, scene)
            rows.append({**_ends(asked), "number": number, "cause": cause, "detail": detail})
    return rows


def answer(
    skill: Skill[Motion], setup: Setup, asked: motion_planning.Query, scene: Scene
) -> tuple[str, str]:
    """Why the arm cannot run the skill's motion, in a word and in a sentence; empty if it can."""
    return attempt(skill, setup, asked, scene, timing=_fastest)[1:]


def _fastest(joints: JointTrajectory, setup: Setup) -> JointTrajectory:
    return retime(joints, setup.arm.limits, rate=setup.rate, path_tolerance=PATH_TOLERANCE)


Timing = Callable[[JointTrajectory, "Setup"], JointTrajectory]


def attempt(
    skill: Skill[Motion],
    setup: Setup,
    asked: motion_planning.Query,
    scene: Scene,
    *,
    timing: Timing,
) -> tuple[JointTrajectory | None, str, str]:
    """The skill's motion, timed, if there is one; and why the arm cannot run it, as `answer`."""
    try:
        joints = motion_planning.plan_motion(skill, setup.arm, scene, asked).joints
        timed = timing(joints, setup)
    except NoPath as error:
        return None, f"no path: {error.reason}", str(error)
    except check.IkFailure as error:
        return None, f"follow: {error.status}", str(error)
    except LimitsInfeasible as error:
        return None, f"limits: {error.joint}", str(error)
    except InvalidInput as error:
        return None, "refused", str(error)
    return timed, *_judged(setup, timed, scene)


def _judged(setup: Setup, timed: JointTrajectory, scene: Scene) -> tuple[str, str]:
    """The fault of a motion, in a word and in a sentence; empty without one."""
    arm = setup.arm
    limits = check_limits(timed, arm.limits)
    if not limits.ok:
        return "limits", str(limits)
    report = arm.check(timed, scene)
    if not report.ok:
        return "collision", str(report)
    if setup.controller is not None:
        seen = simulation.simulate(arm, timed, scene, controller=setup.controller)
        if not seen.ok:
            return f"simulation: {seen.findings[0].kind}", str(seen)
    return "", ""


def _ends(asked: motion_planning.Query) -> dict[str, Any]:
    assert asked.start is not None
    assert asked.goal is not None
    return {"start": numbers_of(asked.start), "goal": numbers_of(asked.goal)}


def numbers_of(place: Target) -> list[float]:
    """A place as numbers: (d,), or position and orientation one after the other."""
    parts = place if isinstance(place, tuple) else (place,)
    flat: Float64Array = np.concatenate([np.asarray(part, dtype=np.float64) for part in parts])
    return [float(number) for number in flat]
