"""The paths of an experiment, run by the whole arm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure
from leadthrough.models import FastMarching
from leadthrough.motion import Demonstration, JointTrajectory, Trajectory
from leadthrough.motion_planning import PlannedMotion, Query, plan_motion
from leadthrough.shapes import Scene, Shape
from leadthrough.shapes.scene import PLANNING_TOLERANCE
from leadthrough_studies.study import Row
from leadthrough_studies.ur3.setups import SETUPS, Setup

_JOINT_STEP = 0.1  # degrees, the paper's joint resolution
MARGIN = 0.005  # m
_MEASURED = (
    "arm_distance_m",
    "arm_self_distance_m",
    "tip_error_m",
    "tip_left_path_m",
    "tip_paths",
    "quantised_error_m",
    "quantised_end_error_m",
)


def on_the_arm(
    model: FastMarching, shown: list[Demonstration[Trajectory]], setup: int
) -> tuple[Row, JointTrajectory | None]:
    """The motion of the whole arm: clear or not, how far its tip leaves the path, and its joints.

    Args:
        model: with its workspace in the paper's frame.
        shown: demonstrations, in the paper's frame.
        setup: number of the experiment.
    """
    place, arm = SETUPS[setup], Arm.load("ur3")
    around = place.around_the_arm()
    try:
        planned = _planned(model, shown, place, arm, around)
    except IkFailure as failure:
        failed = {"arm_ok": 0, "arm_fails": _named(str(failure))}
        return failed | dict.fromkeys(_MEASURED), None
    report = arm.check(planned.joints, Scene(around, MARGIN))
    measured = (
        report.obstacles.minimum_distance,
        report.itself.minimum_distance,
        float(arm.path_report(planned.joints, planned.tip).position_error.max()),
        planned.deviation,
        planned.rounds,
        *_quantised(arm, planned),
    )
    found = dict(zip(_MEASURED, measured, strict=True))
    return {"arm_ok": int(report.ok), "arm_fails": None, **found}, planned.joints


def _planned(
    model: FastMarching,
    shown: list[Demonstration[Trajectory]],
    place: Setup,
    arm: Arm,
    obstacles: list[Shape],
) -> PlannedMotion:
    """Everything in the frame of the arm's base."""
    base = np.array(place.base)
    here = [_shifted(each.motion, -base) for each in shown]
    assert model.workspace is not None
    low, high = (tuple(corner) for corner in np.array(model.workspace) - base)
    skill = replace(model, workspace=(low, high)).fit(here)
    start, goal = np.array(place.start) - base, np.array(place.goal) - base
    scene = Scene(obstacles, MARGIN - PLANNING_TOLERANCE)  # planning keeps the rest besides
    return plan_motion(skill, arm, scene, Query(start, goal))


def _shifted(motion: Trajectory, offset: Float64Array) -> Trajectory:
    return replace(motion, positions=motion.positions + offset)


def _quantised(arm: Arm, planned: PlannedMotion) -> tuple[float, float]:
    """Errors of the tip with quantised joint positions: the largest, and that at the end."""
    steps = np.round(np.rad2deg(planned.joints.positions) / _JOINT_STEP) * _JOINT_STEP
    reached, _ = arm.forward_kinematics(np.deg2rad(steps))
    errors = np.linalg.norm(reached - planned.tip.positions, axis=1)
    return float(errors.max()), float(errors[-1])


def _named(failure: str) -> str:
    """The first obstacle is the table."""
    return failure.replace("obstacle 0", "table").replace("obstacle 1", "box")
