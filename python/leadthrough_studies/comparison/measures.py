"""What is measured of a skill: errors, response to a push and to a moved goal, and on an arm."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

import leadthrough as lt
from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure, LeadthroughError
from leadthrough.models import DynamicalSkill
from leadthrough.motion import PoseTrajectory, Trajectory
from leadthrough.preprocess import dtw_distance, frechet_distance
from leadthrough.preprocess.resample import by_arc_length
from leadthrough_studies import metrics
from leadthrough_studies.study import Row

_COMPARED = 200  # evenly spaced samples
# A push and a moved goal, in sizes of the motion, and the fraction of the path at which it is
# pushed.
_PUSH, _MOVED, _PUSHED_AT = 0.1, 0.2, 0.5
# Samples at which an arm follows, and metres per unit of a drawing, middle and tool orientation.
_FOLLOWED = 200
_PLACES = {"panda": (0.004, (0.5, 0.0, 0.3)), "ur3": (0.003, (-0.05, -0.3, 0.2))}
_DOWN = (0.0, 1.0, 0.0, 0.0)
# A joint that turns by more than this from one of 200 samples to the next has leapt, rad.
_LEAP = 0.3


def drawing_errors(shown: Trajectory, made: Trajectory) -> Row:
    """The errors of a drawing, in mm and s."""
    names = ("SEA_mm2", "V_rmse_mm_s", "DTW_mm", "Frechet_mm", "end_mm")
    errors = asdict(metrics.reproduction_errors(shown, made))
    return dict(zip(names, errors.values(), strict=True))


def pose_errors(shown: PoseTrajectory, made: PoseTrajectory) -> Row:
    """The errors of a motion of poses at evenly spaced times, in mm and degrees."""
    wanted, turned = _sampled(shown)
    positions, orientations = _sampled(made)
    apart = np.linalg.norm(positions - wanted, axis=1)
    angles = np.degrees(rotations.distance(orientations, turned))
    return {
        "mean_mm": 1e3 * float(apart.mean()),
        "DTW_mm": 1e3 * dtw_distance(positions, wanted) / _COMPARED,
        "mean_deg": float(angles.mean()),
        "end_mm": 1e3 * float(apart[-1]),
        "end_deg": float(angles[-1]),
    }


def responses(skill: Any, shown: Trajectory) -> Row:
    """What a skill does after a push half-way, and for a goal that has moved, in mm.

    A policy goes on from where the push has led; other skills are asked for a new motion from
    there. The rest of the demonstration, carried to the new start or goal, is what is compared
    with.
    """
    path = by_arc_length(shown.positions, _COMPARED)
    size = float(np.linalg.norm(path - path[-1], axis=1).max())
    row = int(_PUSHED_AT * _COMPARED)
    along = path[row + 1] - path[row - 1]
    across = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    pushed = path[row] + _PUSH * size * across
    rest = _carried(path[row:], pushed, path[-1])
    goal = path[-1] + _MOVED * size * across
    after = skill.generate(start=pushed).positions
    moved = skill.generate(start=path[0], goal=goal).positions
    return {
        "push_Frechet_mm": frechet_distance(rest, by_arc_length(after, _COMPARED)),
        "goal_Frechet_mm": frechet_distance(
            _carried(path, path[0], goal), by_arc_length(moved, _COMPARED)
        ),
        "goal_end_mm": float(np.linalg.norm(moved[-1] - goal)),
    }


def _carried(path: Float64Array, start: Float64Array, goal: Float64Array) -> Float64Array:
    """A path (n, d) with offsets of its ends that fade along it."""
    rise = np.linspace(0.0, 1.0, len(path))[:, None]
    return np.asarray(path + (1.0 - rise) * (start - path[0]) + rise * (goal - path[-1]))


def on_paper(arm: str, made: Trajectory) -> PoseTrajectory:
    """A drawing in mm on a horizontal table before an arm, the tool pointing down."""
    scale, middle = _PLACES[arm]
    flat = made.positions - 0.5 * (made.positions.min(axis=0) + made.positions.max(axis=0))
    points = np.column_stack([flat[:, 1], flat[:, 0], np.zeros(len(flat))]) * scale + middle
    return PoseTrajectory(made.times, points, np.tile(_DOWN, (len(points), 1)))


def on_arm(arm: str, motion: PoseTrajectory) -> Row:
    """Whether an arm can run a motion: reachable, without a leap, clear, and how much slower."""
    robot = lt.Arm.load(arm)
    times = np.linspace(motion.times[0], motion.times[-1], _FOLLOWED)
    columns = [np.interp(times, motion.times, column) for column in motion.positions.T]
    turned = rotations.interpolate(motion.times, motion.orientations, times)
    way = PoseTrajectory(times, np.column_stack(columns), turned)
    speeds = np.linalg.norm(np.diff(way.positions, axis=0), axis=1)
    row = {"begins_at": float(speeds[0] / max(speeds.max(), 1e-12))}
    try:
        joints = robot.follow(way, too_fast="exceed_limits")
    except IkFailure as error:
        return {**row, "executed": 0, "refused": str(error)[:120]}
    slow = lt.scale_to_limits(joints, robot.limits)
    leap = float(np.abs(np.diff(joints.positions, axis=0)).max())
    clear = bool(robot.check(joints).ok)
    return {
        **row,
        "executed": int(leap < _LEAP and clear),
        "leap_rad": leap,
        "clear": int(clear),
        "slower": slow.duration / joints.duration,
    }


def stability(skill: DynamicalSkill, starts: int) -> Row:
    """The counts of the skill's stability report, and its own errors by the measure of SEDS."""
    report = skill.stability(starts)
    return {
        "starts": report.starts,
        "arrived": report.arrived,
        "rising": report.rising,
        "resting": report.resting,
        "violations": report.violations,
        "longest": report.longest,
    }


def direction_error(
    skill: DynamicalSkill, shown: Trajectory, *, along: float = 0.6, speed: float = 0.4
) -> float:
    """The error of the velocities at a demonstration's samples, without a unit.

    The mean of sqrt(r (1 - v.w / |v| |w|)^2 + q |v - w|^2 / |v| |w|), with the demonstrated
    velocities v and the system's own w, without its pace. Samples that are slower than a fiftieth
    of the fastest are left out.

    Args:
        skill: the system.
        shown: the demonstration; its goal is moved to the system's.
        along: r, of the direction.
        speed: q, of the difference.

    Source: Khansari-Zadeh and Billard 2011, section VII.
    """
    times = np.linspace(shown.times[0], shown.times[-1], _COMPARED)
    path = np.column_stack([np.interp(times, shown.times, x) for x in shown.positions.T])
    v = np.gradient(path, times, axis=0)
    moving = np.linalg.norm(v, axis=1) > 0.02 * np.linalg.norm(v, axis=1).max()
    moving[-1] = False
    v = v[moving]
    w = skill.policy(path[moving], goal=path[-1]) / skill.pace
    product = np.linalg.norm(v, axis=1) * np.linalg.norm(w, axis=1) + 1e-9
    turned = 1.0 - (v * w).sum(axis=1) / product
    apart = ((v - w) ** 2).sum(axis=1) / product
    return float(np.sqrt(along * turned**2 + speed * apart).mean())


def _sampled(motion: PoseTrajectory) -> tuple[Float64Array, Float64Array]:
    at = np.linspace(motion.times[0], motion.times[-1], _COMPARED)
    columns = [np.interp(at, motion.times, column) for column in motion.positions.T]
    return np.column_stack(columns), rotations.interpolate(motion.times, motion.orientations, at)


def tried(work: Any) -> Row:
    """The row that some work returns, or why the method refused it."""
    try:
        row: Row = work()
    except LeadthroughError as error:
        return {"refused": str(error)[:160]}
    return row
