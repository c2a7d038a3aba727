"""The agriculture study: a TIAGo learns digging, seeding, irrigation and harvesting.

After Lauretti et al. 2023, sections 2.2 and 3: 16 subtasks and nine targets, with one demonstration
and one reproduction in 10 s by each planner. The paper's recordings are not public; a simulated
person (`demonstrator`) demonstrates the subtasks through the postures of `tasks`. The planners are
those of `planners`: Euler angles ZYZ and the plain logarithm, with which the paper compares its
own; "lifted", the paper's dynamic parameterisation; "lauretti", its whole planner by its own
equations; and "anchored", ours. `measures` defines the measures.

The arm follows every reproduction with all of it clear of the floor, slows down to its limits, and
is checked as a whole, with its hand, against itself and the floor. The redundant arm stays near the
demonstrated posture. Whole tasks are chained from their subtasks, each starting where the previous
one ended, for targets on the grid and between. The gripper closes or opens at the end of a subtask;
its events keep their places on the path when the arm slows down. Between the targets, skills are
looked up at the nearest target or interpolated, and compared with demonstrations there. If a folder
of recordings is given, motions of a real arm are learned and replayed as well.
"""

from __future__ import annotations

import os
from dataclasses import dataclass

import numpy as np

from leadthrough import rotations
from leadthrough.arm import Arm, FollowOptions
from leadthrough.check import Float64Array
from leadthrough.errors import FitError, IkFailure, InvalidInput, LimitsInfeasible
from leadthrough.motion import Demonstration, JointTrajectory, PoseTrajectory
from leadthrough.shapes import Scene
from leadthrough.shapes.scene import PLANNING_TOLERANCE
from leadthrough.timing import check_limits, keep_timing
from leadthrough_studies.agriculture import persons, printed, recordings
from leadthrough_studies.agriculture.measures import at_phases, gaps, judged
from leadthrough_studies.agriculture.planners import PLANNERS, planner_of
from leadthrough_studies.agriculture.report import report
from leadthrough_studies.agriculture.skills import (
    DURATION,
    LOOKUPS,
    PLANNED_STEP,
    STEP,
    Learned,
    Shown,
    chain,
    fastest_turn,
    learn,
    show,
)
from leadthrough_studies.agriculture.tasks import (
    CORNERS,
    TASKS,
    Subtask,
    amid,
    floor,
    load_arm,
    targets,
)
from leadthrough_studies.study import Row, Study, Task, cpu_time

_CLEARANCE = 1e-3  # m, tolerance of the check between samples
_DRAWN = "4-4"  # the subtask of the paper's figures 8 to 10
_DRAWN_SAMPLES = 201
_RATE = 100.0  # Hz, of the motions of the arm
_PATH_TOLERANCE = 1e-3  # rad (m)


@dataclass(frozen=True)
class AgricultureConfig:
    """The configuration of the study.

    Attributes:
        tasks: names of tasks, keys of TASKS.
        repetitions: numbers of targets, 0 to 8.
        planners: names in PLANNERS.
        between: whether to also run tasks for positions between four targets.
        recordings: folder with panda_execution/*.csv; empty for none.
        seed: seed of the simulated person.
        persons: how many persons, from that seed on, repeat the trials without the arm.
    """

    tasks: tuple[str, ...] = tuple(TASKS)
    repetitions: tuple[int, ...] = tuple(range(9))
    planners: tuple[str, ...] = tuple(PLANNERS)
    between: bool = True
    recordings: str = ""
    seed: int = 0
    persons: int = 10


def configure(quick: bool, seed: int) -> AgricultureConfig:
    """The full configuration with the recordings in LEADTHROUGH_DATA, or one task, two targets."""
    if quick:
        return AgricultureConfig(("harvesting",), (0, 4), between=False, seed=seed, persons=2)
    return AgricultureConfig(recordings=os.environ.get("LEADTHROUGH_DATA", ""), seed=seed)


def tasks(config: AgricultureConfig) -> list[Task]:
    """A task for every agricultural task and planner, every recording and every person."""
    common = {"repetitions": list(config.repetitions), "seed": config.seed}
    return [
        *(
            Task(perform, {"task": task, "planner": planner, "between": config.between, **common})
            for task in config.tasks
            for planner in config.planners
        ),
        *recordings.tasks(config.recordings, config.planners),
        *_of_persons(config),
    ]


def _of_persons(config: AgricultureConfig) -> list[Task]:
    """Tasks of the parts without the arm, and of formulas as printed."""
    trials = {"tasks": list(config.tasks), "repetitions": list(config.repetitions)}
    planners = {"planners": list(config.planners)}
    seeds = range(config.seed, config.seed + config.persons)
    return [
        *(
            Task(persons.of_seed, {"postures": name, **trials, **planners, "seed": k})
            for name in persons.POSTURES
            for k in seeds
        ),
        *(Task(printed.of_kernels, {**trials, "seed": k}) for k in seeds),
        *(Task(printed.of_maps, {"angle_deg": angle}) for angle in printed.ANGLES),
    ]


def perform(
    *, task: str, planner: str, repetitions: list[int], between: bool, seed: int
) -> list[Row]:
    """A row for every subtask and target, every whole task and every look-up of one planner."""
    arm = load_arm()
    learned = learn(arm, task, planner_of(planner), repetitions, seed=seed)
    labels = {"task": task, "planner": planner}
    subtasks = [
        {"study": "subtasks", **labels, "subtask": subtask.number, "title": subtask.title}
        | {"repetition": i}
        | _reproduced(arm, learned, subtask, i)
        for i in repetitions
        for subtask in TASKS[task]
    ]
    wholes = [
        {"study": "whole", **labels} | row
        for row in _wholes(arm, learned, repetitions, between=between)
    ]
    between_targets = [
        {"study": "lookup", **labels, "lookup": lookup, "subtask": subtask.number, "amid": i + 1}
        | looked_up(arm, learned, subtask, i, lookup, seed=seed)
        for i in (CORNERS if between else ())
        for subtask in TASKS[task]
        if subtask.depends_on_target
        for lookup in LOOKUPS
    ]
    return subtasks + wholes + between_targets


def _wanted(
    task: str, repetitions: list[int], *, between: bool
) -> list[tuple[str, Float64Array, tuple[str, ...]]]:
    """Label, target and look-ups of the whole tasks; on the grid both look-ups are the same."""
    grid = targets(task)
    return [
        *((f"target {i + 1}", grid[i], LOOKUPS[:1]) for i in repetitions),
        *((f"amid {i + 1}", amid(task, i), LOOKUPS) for i in (CORNERS if between else ())),
    ]


def _reproduced(arm: Arm, learned: Learned, subtask: Subtask, i: int) -> Row:
    """The measures of the subtask with the skill of its own target, or the refusal."""
    key = subtask.number, i
    if key in learned.refused:
        return {"succeeded": 0, "refused": learned.refused[key]}
    shown, skill = learned.shown[key], learned.skill(subtask, learned.targets[i])
    try:
        made = skill.generate(duration=DURATION, dt=STEP)
    except InvalidInput as error:  # "lifted" refuses to spin
        return {"succeeded": 0, "refused": str(error)}
    on_arm, _ = on_the_arm(arm, made, shown.joints)
    row = judged(made, shown.poses) | on_arm
    row |= {
        "fit_cpu_s": cpu_time(lambda: learned.model.fit([Demonstration(shown.poses)])),
        "plan_cpu_s": cpu_time(lambda: skill.generate(duration=DURATION, dt=PLANNED_STEP)),
    }
    return row | ({"course": _course(made, shown)} if subtask.number == _DRAWN else {})


def _wholes(arm: Arm, learned: Learned, repetitions: list[int], *, between: bool) -> list[Row]:
    """A row for every whole task; the first one has its joints, for the figures."""
    rows: list[Row] = []
    for where, target, lookups in _wanted(learned.task, repetitions, between=between):
        for lookup in lookups:
            row, joints = _whole(arm, learned, target, lookup)
            if joints is not None and not rows:
                row["joints"] = _drawn(arm, joints)
            rows.append({"where": where, "lookup": lookup} | row)
    return rows


def _whole(
    arm: Arm, learned: Learned, target: Float64Array, lookup: str
) -> tuple[Row, JointTrajectory | None]:
    """The measures and joints of the whole task for a target, or the refusal."""
    try:
        whole = chain(learned, target, lookup=lookup)
    except (InvalidInput, FitError) as error:
        return {"refused": str(error)}, None
    motion = whole.poses
    home = learned.shown[TASKS[learned.task][0].number, next(iter(learned.targets))]
    row, joints = on_the_arm(arm, motion, whole.joints)
    turned = rotations.distance(motion.orientations[-1:], home.poses.orientations[:1])[0]
    happened = motion.events if joints is None else joints.events
    row |= {
        "fastest_deg_s": fastest_turn(motion),
        "home_missed_m": float(np.linalg.norm(motion.positions[-1] - home.poses.positions[0])),
        "home_missed_deg": float(np.degrees(turned)),
        "gripper": [{"does": event.name, "time_s": event.time} for event in happened],
    }
    return row, joints


def _drawn(arm: Arm, joints: JointTrajectory) -> Row:
    """Time series of the joints, and their limits, for the figures."""
    some = np.linspace(0, len(joints.times) - 1, 2 * _DRAWN_SAMPLES).astype(int)
    return {
        "times": np.round(joints.times[some], 3).tolist(),
        "positions": np.round(joints.positions[some], 4).tolist(),
        "lower": arm.limits.lower.tolist(),
        "upper": arm.limits.upper.tolist(),
    }


def looked_up(
    arm: Arm, learned: Learned, subtask: Subtask, i: int, lookup: str, *, seed: int
) -> Row:
    """The subtask for a position between four targets, compared with a demonstration there."""
    target = amid(learned.task, i)
    number = len(targets(learned.task)) + i
    shown = show(arm, learned.task, subtask, number, seed=seed, target=target).poses
    start = shown.positions[0], shown.orientations[0]
    try:
        skill = learned.skill(subtask, target, lookup=lookup)
        goal = learned.goal(subtask, target, lookup=lookup)
        made = skill.generate(start=start, goal=goal, dt=STEP)
    except (InvalidInput, FitError) as error:
        return {"refused": str(error)}
    return gaps(made, shown)


def on_the_arm(
    arm: Arm, motion: PoseTrajectory, posture: JointTrajectory
) -> tuple[Row, JointTrajectory | None]:
    """The joints that follow a motion of the tool, slowed down to the limits and checked.

    Args:
        arm: the arm.
        motion: the motion of the tool.
        posture: joint positions that the arm stays near.

    Returns:
        A row of measures, and the joint trajectory, or None if the arm cannot follow.
    """
    row: Row = {"followed": 0}
    try:
        joints = arm.follow(
            motion, options=FollowOptions(posture=posture), on_rate_limit="slow", scene=_scene()
        )
    except IkFailure as error:
        return row | {"arm_failure": f"{error.status} at sample {error.index}"}, None
    row = {"followed": 1}
    try:
        # `follow` does not consider jerk.
        joints = keep_timing(joints, arm.limits, rate=_RATE, path_tolerance=_PATH_TOLERANCE)
    except LimitsInfeasible as error:
        return row | {"arm_failure": str(error)}, joints
    row |= {
        "limits_kept": int(check_limits(joints, arm.limits).ok),
        "slowing": joints.duration / motion.duration,
    }
    return row | _cleared(arm, joints), joints


def _scene() -> Scene:
    """The floor; planning keeps 5 mm in all."""
    return Scene([floor()], 0.005 - PLANNING_TOLERANCE)


def _cleared(arm: Arm, joints: JointTrajectory) -> Row:
    found = arm.check(joints, _scene(), tolerance=_CLEARANCE)
    hit = {} if found.first is None else {"arm_failure": " and ".join(found.first.bodies)}
    return {"arm_clear": int(found.ok), "arm_distance_m": found.minimum_distance, **hit}


def _course(made: PoseTrajectory, shown: Shown) -> Row:
    """Orientations over the fraction of the duration, for the figures."""
    phases = np.linspace(0.0, 1.0, _DRAWN_SAMPLES)
    recorded, drawn = at_phases(shown.poses, phases), at_phases(made, phases)
    return {
        "recorded": np.round(recorded.orientations, 6).tolist(),
        "made": np.round(drawn.orientations, 6).tolist(),
    }


STUDY = Study(configure, tasks, report)
