"""One query after the other through the whole way: drawn, planned, retimed, checked."""

from __future__ import annotations

import pickle
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure, InvalidInput, LimitsInfeasible, NoPath
from leadthrough.models import load_skill
from leadthrough.models.certificate import Scattered
from leadthrough.models.place import Place
from leadthrough.models.places import Places
from leadthrough.models.protocol import Skill
from leadthrough.motion import JointTrajectory, Motion
from leadthrough.shapes import Shape
from leadthrough.simulation import Controller, simulate
from leadthrough.tasks import Row
from leadthrough.timing import check_limits, retime
from leadthrough.whole_arm import plan_motion

# rad or m: how far the path that is retimed may lie off the planned samples.
_PATH = 1e-4


@dataclass(frozen=True, eq=False)
class Scene:
    """What all queries of a validation have in common."""

    arm: Arm  # that is to move
    goals: Places  # of the queries
    starts: Places  # of the queries
    obstacles: tuple[Shape | Scattered, ...]  # that stand still, and those whose position is drawn
    margin: float  # distance that the arm keeps from them, m
    rate: float  # of the motion that is checked, Hz
    controller: Controller | None  # of the simulated arm; None for no simulation


@dataclass(frozen=True, eq=False)
class Query:
    """What a skill is asked for."""

    start: Place
    goal: Place
    obstacles: tuple[Shape, ...]


def query(scene: Scene, seed: int, number: int) -> Query:
    """A query of a validation, the same wherever and whenever it is drawn."""
    rng = np.random.default_rng([seed, number])
    start, goal = scene.starts.draw(rng), scene.goals.draw(rng)
    shapes = (each.draw(rng) if isinstance(each, Scattered) else each for each in scene.obstacles)
    return Query(start, goal, tuple(shapes))


def answers(*, first: int, count: int, seed: int, skill: Path, scene: Path) -> list[Row]:
    """A row for each of some queries: where they start and end, and why the motion fails, if so."""
    learned = load_skill(skill)
    with scene.open("rb") as file:
        common: Scene = pickle.load(file)
    rows = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what is unusual of a query shows in its motion
        for number in range(first, first + count):
            asked = query(common, seed, number)
            cause, detail = answer(learned, common, asked)
            rows.append({**_told(asked), "number": number, "cause": cause, "detail": detail})
    return rows


def answer(skill: Skill[Motion], scene: Scene, asked: Query) -> tuple[str, str]:
    """Why the arm cannot run the skill's motion, in a word and in a sentence; empty if it can."""
    try:
        joints = plan_motion(
            skill,
            scene.arm,
            start=asked.start,
            goal=asked.goal,
            obstacles=asked.obstacles,
            margin=scene.margin,
        ).joints
        timed = retime(joints, scene.arm.limits, rate=scene.rate, path_tolerance=_PATH)
    except NoPath as error:
        return f"no path: {error.reason}", str(error)
    except IkFailure as error:
        return f"follow: {error.status}", str(error)
    except LimitsInfeasible as error:
        return f"limits: {error.joint}", str(error)
    except InvalidInput as error:
        return "refused", str(error)
    return _judged(scene, timed, asked.obstacles)


def _judged(scene: Scene, timed: JointTrajectory, obstacles: tuple[Shape, ...]) -> tuple[str, str]:
    """What is wrong with a motion, in a word and in a sentence."""
    arm = scene.arm
    limits = check_limits(timed, arm.limits)
    if not limits.ok:
        return "limits", str(limits)
    report = arm.check(timed, obstacles)
    if not report.ok:
        return "collision", str(report)
    if scene.controller is not None:
        seen = simulate(arm, timed, obstacles=obstacles, controller=scene.controller)
        if not seen.ok:
            return f"simulation: {seen.findings[0].kind}", str(seen)
    return "", ""


def _told(asked: Query) -> dict[str, Any]:
    return {"start": _numbers(asked.start), "goal": _numbers(asked.goal)}


def _numbers(place: Place) -> list[float]:
    """A place as numbers: (d,), or position and orientation one after the other."""
    parts = place if isinstance(place, tuple) else (place,)
    flat: Float64Array = np.concatenate([np.asarray(part, dtype=np.float64) for part in parts])
    return [float(number) for number in flat]
