"""What is measured of a skill: errors, response to a push and to a moved goal, its stability."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any, TypeAlias

import numpy as np
from scipy.ndimage import gaussian_filter1d

from leadthrough import rotations
from leadthrough.check import Float64Array
from leadthrough.errors import LeadthroughError
from leadthrough.models import DynamicalSkill
from leadthrough.motion import PoseTrajectory, Trajectory
from leadthrough.preprocess import dtw_distance, frechet_distance
from leadthrough.preprocess.resample import by_arc_length
from leadthrough_studies import metrics
from leadthrough_studies.study import Row

# The positions (n, d) of a skill's motion from a position to a goal, or to its own without one.
Made: TypeAlias = Callable[[Float64Array, Float64Array | None], Float64Array]
# The positions (n, d) of a skill's motion after a push: the fraction of the path at which it comes,
# where to, and for how many durations the tool is held there.
Pushed: TypeAlias = Callable[[float, Float64Array, float], Float64Array]

_COMPARED = 200  # evenly spaced samples
# A push and a moved goal, in sizes of the motion, the fractions of the path at which the tool is
# pushed, and for how long it is held, in durations.
_PUSH, _MOVED, _PUSHED_AT, _HELD = 0.1, 0.2, (0.25, 0.5, 0.75), 0.25
# Fractions of the rest over which the push may fade.
_FADING = (1.0, 0.5, 0.25, 0.125)
_MM = 1e3  # per m


def drawing_errors(shown: Trajectory, made: Trajectory) -> Row:
    """The errors of a drawing, in mm and s."""
    names = ("SEA_mm2", "V_rmse_mm_s", "DTW_mm", "Frechet_mm", "end_mm")
    errors = asdict(metrics.reproduction_errors(shown, made))
    return dict(zip(names, errors.values(), strict=True))


def course_errors(shown: Trajectory, made: Trajectory) -> Row:
    """The errors of a course of points in m, in mm and s; shapes at equal steps of arc length."""
    wanted, found = (by_arc_length(each.positions, _COMPARED) for each in (shown, made))
    return {
        "V_rmse_mm_s": _MM * metrics.velocity_rmse(shown, made),
        "DTW_mm": _MM * dtw_distance(wanted, found) / _COMPARED,
        "Frechet_mm": _MM * frechet_distance(wanted, found),
        "end_mm": _MM * metrics.end_error(shown, made),
    }


def pose_errors(shown: PoseTrajectory, made: PoseTrajectory) -> Row:
    """The errors of a motion of poses at evenly spaced times, in mm and degrees."""
    wanted, turned = evenly_sampled(shown, _COMPARED)
    positions, orientations = evenly_sampled(made, _COMPARED)
    apart = np.linalg.norm(positions - wanted, axis=1)
    angles = np.degrees(rotations.distance(orientations, turned))
    speeds = [Trajectory(each.times, each.positions) for each in (shown, made)]
    return {
        "mean_mm": _MM * float(apart.mean()),
        "V_rmse_mm_s": _MM * metrics.velocity_rmse(*speeds),
        "DTW_mm": _MM * dtw_distance(positions, wanted) / _COMPARED,
        "Frechet_mm": _MM * frechet_distance(positions, wanted),
        "mean_deg": float(angles.mean()),
        "end_mm": _MM * float(apart[-1]),
        "end_deg": float(angles[-1]),
    }


def response_to_goal(made: Made, shown: Float64Array, *, unit: float = 1.0) -> Row:
    """Errors of a skill for a goal that has moved, in mm.

    Args:
        made: the skill's motions.
        shown: positions (n, d) of the demonstration, with which the motion is compared, carried to
            the new goal.
        unit: mm per unit of the positions.
    """
    path, size = path_and_size(shown)
    row = _COMPARED // 2
    goal = path[-1] + _MOVED * size * across(path[row + 1] - path[row - 1])
    moved = made(path[0], goal)
    carried = _carried(path, path[0], goal)
    return {
        "goal_Frechet_mm": unit * frechet_distance(carried, by_arc_length(moved, _COMPARED)),
        "goal_end_mm": unit * float(np.linalg.norm(moved[-1] - goal)),
    }


def response_to_pushes(
    pushed: Pushed, shown: Float64Array, *, clock: bool, unit: float = 1.0
) -> Row:
    """Errors of a skill after pushes at a quarter, half and three quarters of the path, in mm.

    The following motion is compared with the rest of the demonstration, shifted by the push; the
    shift fades over all of the rest ("push_Frechet_mm"), or over that part of it with the least
    error ("push_any_fade_mm"), so that neither a quick nor a slow return counts as an error.

    Args:
        pushed: the skill's motions after a push.
        shown: positions (n, d) of the demonstration.
        clock: whether the skill has a clock of its own, so that a held tool is another question.
        unit: mm per unit of the positions.
    """
    path, size = path_and_size(shown)
    errors: dict[str, list[float]] = {"push": [], "fade": [], "held": []}
    for at in _PUSHED_AT:
        row = int(at * _COMPARED)
        place = path[row] + _PUSH * size * across(path[row + 1] - path[row - 1])
        after = pushed(at, place, 0.0)
        held = pushed(at, place, _HELD) if clock else after
        for name, error in zip(
            ("push", "fade"), faded_errors(path[row:], place, after), strict=True
        ):
            errors[name].append(error)
        errors["held"].append(faded_errors(path[row:], place, held)[0])
    parts = zip(_PUSHED_AT, errors["push"], strict=True)
    return {
        "push_Frechet_mm": unit * float(np.mean(errors["push"])),
        "push_any_fade_mm": unit * float(np.mean(errors["fade"])),
        "held_Frechet_mm": unit * float(np.mean(errors["held"])),
        **{f"push_at_{100 * at:.0f}_mm": unit * error for at, error in parts},
    }


def faded_errors(
    left: Float64Array, place: Float64Array, after: Float64Array
) -> tuple[float, float]:
    """Fréchet distances of a motion after a push from the rest of a demonstration.

    Args:
        left: the rest (n, d) of the demonstration.
        place: position (d,) after the push, to which the rest is shifted.
        after: positions (m, d) of the motion.

    Returns:
        The distance with the shift fading over all of the rest, and the least over parts of it.
    """
    compared = by_arc_length(after, _COMPARED)
    fading = [frechet_distance(_faded(left, place, part), compared) for part in _FADING]
    return fading[0], min(fading)


def path_and_size(shown: Float64Array) -> tuple[Float64Array, float]:
    """The positions (n, d) at equal steps of arc length, and the largest distance from the end."""
    path = by_arc_length(shown, _COMPARED)
    return path, float(np.linalg.norm(path - path[-1], axis=1).max())


def across(along: Float64Array) -> Float64Array:
    """A direction (d,) across another; in space a horizontal one, if there is one."""
    if len(along) == 2:
        side = np.array([-along[1], along[0]])
    elif len(along) == 3:
        upright = abs(along[2]) > 0.99 * np.linalg.norm(along)
        side = np.cross([1.0, 0.0, 0.0] if upright else [0.0, 0.0, 1.0], along)
    else:  # of joints, as far as they go together
        side = 1.0 - along * along.sum() / (along @ along)
    return np.asarray(side / np.linalg.norm(side))


def _carried(path: Float64Array, start: Float64Array, goal: Float64Array) -> Float64Array:
    """A path (n, d) with offsets of its ends that fade along it."""
    rise = np.linspace(0.0, 1.0, len(path))[:, None]
    return np.asarray(path + (1.0 - rise) * (start - path[0]) + rise * (goal - path[-1]))


def _faded(path: Float64Array, start: Float64Array, part: float) -> Float64Array:
    """A path (n, d) from another start, whose offset fades over a part of the path."""
    left = np.maximum(1.0 - np.linspace(0.0, 1.0, len(path)) / part, 0.0)[:, None]
    return np.asarray(path + left * (start - path[0]))


def stability(skill: DynamicalSkill, starts: int) -> Row:
    """The counts of the skill's stability report.

    Args:
        skill: the system.
        starts: number of starts.
    """
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
    skill: DynamicalSkill,
    shown: Trajectory,
    *,
    along: float = 0.6,
    speed: float = 0.4,
    smoothing: float = 0.0,
    slowest: float = 0.02,
) -> float:
    """The error of the velocities at a demonstration's samples, without a unit.

    The mean of sqrt(r (1 - v.w / |v| |w|)^2 + q |v - w|^2 / |v| |w|), with the demonstrated
    velocities v and the system's own w, without its pace.

    Args:
        skill: the system.
        shown: the demonstration; its goal is moved to the system's.
        along: r, of the direction.
        speed: q, of the difference.
        smoothing: deviation of a Gaussian over which positions are averaged before they are
            differentiated, in samples of 200; 0 for none.
        slowest: samples slower than this fraction of the fastest are left out.

    Source: Khansari-Zadeh and Billard 2011, section VII.
    """
    times = np.linspace(shown.times[0], shown.times[-1], _COMPARED)
    path = np.column_stack([np.interp(times, shown.times, x) for x in shown.positions.T])
    smooth = gaussian_filter1d(path, smoothing, axis=0, mode="nearest") if smoothing else path
    v = np.gradient(smooth, times, axis=0)
    moving = np.linalg.norm(v, axis=1) > slowest * np.linalg.norm(v, axis=1).max()
    moving[-1] = False
    v = v[moving]
    w = skill.policy(path[moving], goal=path[-1]) / skill.pace
    product = np.linalg.norm(v, axis=1) * np.linalg.norm(w, axis=1) + 1e-9
    turned = 1.0 - (v * w).sum(axis=1) / product
    apart = ((v - w) ** 2).sum(axis=1) / product
    return float(np.sqrt(along * turned**2 + speed * apart).mean())


def evenly_sampled(motion: PoseTrajectory, count: int) -> tuple[Float64Array, Float64Array]:
    """Positions (count, 3) and orientations (count, 4) at evenly spaced times."""
    at = np.linspace(motion.times[0], motion.times[-1], count)
    columns = [np.interp(at, motion.times, column) for column in motion.positions.T]
    return np.column_stack(columns), rotations.interpolate(motion.times, motion.orientations, at)


def tried(work: Any) -> Row:
    """The row that some work returns, or why the method refused it.

    Args:
        work: called without arguments.
    """
    try:
        row: Row = work()
    except (LeadthroughError, np.linalg.LinAlgError) as error:
        return {"refused": str(error)[:160]}
    return row
