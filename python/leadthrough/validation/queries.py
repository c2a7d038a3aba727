"""One query after the other through the whole way: drawn, planned, retimed, checked."""

from __future__ import annotations

import pickle
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough import check, motion_planning, simulation
from leadthrough.arm import Arm, check_arm
from leadthrough.check import Float64Array, IkFailure, InvalidInput, LimitsInfeasible, NoPath
from leadthrough.models import Skill, Target, TargetRegion, load_skill
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory
from leadthrough.shapes import Scene, SceneLike, as_scene
from leadthrough.tasks import Row
from leadthrough.timing import check_limits, retime

# Path tolerance of retiming, rad or m.
_PATH = 1e-4


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
        raise InvalidInput(
            f"{name}: expected {len(position)} coordinates, as the skill's, got {len(region.lower)}"
        )
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
    learned = load_skill(skill)
    with setup.open("rb") as file:
        common: Setup = pickle.load(file)
    rows = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # unusual queries show in their motions
        for number in range(first, first + count):
            asked, scene = draw_query(common, seed, number)
            cause, detail = answer(learned, common, asked, scene)
            rows.append({**_told(asked), "number": number, "cause": cause, "detail": detail})
    return rows


def answer(
    skill: Skill[Motion], setup: Setup, asked: motion_planning.Query, scene: Scene
) -> tuple[str, str]:
    """Why the arm cannot run the skill's motion, in a word and in a sentence; empty if it can."""
    try:
        joints = motion_planning.plan_motion(skill, setup.arm, scene, asked).joints
        timed = retime(joints, setup.arm.limits, rate=setup.rate, path_tolerance=_PATH)
    except NoPath as error:
        return f"no path: {error.reason}", str(error)
    except IkFailure as error:
        return f"follow: {error.status}", str(error)
    except LimitsInfeasible as error:
        return f"limits: {error.joint}", str(error)
    except InvalidInput as error:
        return "refused", str(error)
    return _judged(setup, timed, scene)


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


def _told(asked: motion_planning.Query) -> dict[str, Any]:
    assert asked.start is not None
    assert asked.goal is not None
    return {"start": _numbers(asked.start), "goal": _numbers(asked.goal)}


def _numbers(place: Target) -> list[float]:
    """A place as numbers: (d,), or position and orientation one after the other."""
    parts = place if isinstance(place, tuple) else (place,)
    flat: Float64Array = np.concatenate([np.asarray(part, dtype=np.float64) for part in parts])
    return [float(number) for number in flat]
