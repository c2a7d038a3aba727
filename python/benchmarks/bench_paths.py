"""Inverse kinematics along paths against TRAC-IK, which starts each pose from its last answer.

One long slow path is followed from a given posture. Many random paths are followed without a given
first posture, slowed down where our joints need it; each was made from a joint motion at half of
all limits. A sample counts as missed if it is more than 1e-4 m or 1e-3 rad off. Position, velocity
and acceleration limits must hold at every sample. The peer gets the first posture that each path
was made from.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from frame import Benchmark
from judge import Judge, quaternion, ranges, urdf_of
from peers import TRAC_IK_TOLERANCE, Solve, trac_ik
from scipy.interpolate import CubicSpline

import leadthrough as lt

MISSED = (1e-4, 1e-3)  # m, rad
MISSED_SHARE = 0.002
DEVIATION = (0.1, 0.5)  # m, rad: wide, because the fraction of missed samples is what counts
SAMPLES = 200
ALLOWED = 1e-6  # beyond a limit, rad or relative


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows for every robot."""
    for name in ("panda",) if quick else ("panda", "ur3", "tiago"):
        arm, urdf = lt.Arm.load(name), urdf_of(name)
        judge = Judge(arm, urdf)
        yield _long_path(name, arm, judge, urdf, 200 if quick else 1000)
        yield _random_paths(name, arm, judge, urdf, 5 if quick else 100)


def _long_path(name: str, arm: lt.Arm, judge: Judge, urdf: Path, count: int) -> Benchmark:
    q = _smooth(arm, count)
    motion, targets = _posed(judge, np.linspace(0.0, 4.0, count), q)
    peer = partial(_warm_started, trac_ik(arm, urdf), targets, q[0])
    solved = judge.percent_solved(targets, peer(), tolerance=TRAC_IK_TOLERANCE)
    return Benchmark(
        f"{name}: path of {count} poses, peer solves {solved}",
        ours=lambda: arm.follow(motion, q0=q[0]).positions,
        peer=peer,
        peer_name="pytracik",
        error=partial(judge.worst, targets),
        tolerance=TRAC_IK_TOLERANCE,
    )


def _random_paths(name: str, arm: lt.Arm, judge: Judge, urdf: Path, count: int) -> Benchmark:
    rng = np.random.default_rng(4)
    paths = [_feasible(arm, rng) for _ in range(count)]
    posed = [_posed(judge, times, q) for times, q in paths]
    motions = [motion for motion, _ in posed]
    solve = trac_ik(arm, urdf)

    def peer() -> Any:
        pairs = zip(paths, posed, strict=True)
        return [_warm_started(solve, targets, q[0]) for (_, q), (_, targets) in pairs]

    missed = _missed_share(arm, motions, _follow_all(arm, motions, DEVIATION))
    return Benchmark(
        f"{name}: {count} random paths, {missed:.2%} missed at their own pace",
        ours=lambda: _follow_all(arm, motions, None),
        peer=peer,
        peer_name="pytracik",
        error=lambda answers, _: _missed_share(arm, motions, answers),
        tolerance=MISSED_SHARE,
    )


def _follow_all(arm: lt.Arm, motions: Sequence[Any], deviation: Any) -> list[Any]:
    way = "slow" if deviation is None else "deviate"
    answers: list[Any] = []
    for motion in motions:
        try:
            answers.append(arm.follow(motion, on_rate_limit=way, deviation=deviation))
        except lt.errors.IkFailure as failure:
            answers.append(failure)
    return answers


def _missed_share(arm: lt.Arm, motions: Sequence[Any], answers: Sequence[Any]) -> float:
    """Fraction of missed samples: all of a refused path; inf if a limit is exceeded."""
    missed = 0
    for motion, answer in zip(motions, answers, strict=True):
        if isinstance(answer, lt.errors.IkFailure):
            missed += len(motion.times)
            continue
        if not _in_limits(answer, arm.limits):
            return np.inf
        report = arm.path_report(answer, motion)
        away = (report.position_error > MISSED[0]) | (report.orientation_error > MISSED[1])
        missed += int(away.sum())
    return missed / sum(len(motion.times) for motion in motions)


def _in_limits(joints: lt.JointTrajectory, limits: lt.arm.JointLimits) -> bool:
    """Whether positions and their first and second differences are in the limits at all samples."""
    q, steps = joints.positions, np.diff(joints.times)[:, None]
    speeds = np.diff(q, axis=0) / steps
    accelerations = np.diff(speeds, axis=0) / (0.5 * (steps[1:] + steps[:-1]))
    return bool(
        (q >= limits.lower - ALLOWED).all()
        and (q <= limits.upper + ALLOWED).all()
        and (np.abs(speeds) <= (1.0 + ALLOWED) * limits.velocity).all()
        and (np.abs(accelerations) <= (1.0 + ALLOWED) * limits.acceleration).all()
    )


def _posed(judge: Judge, times: Any, q: Any) -> tuple[lt.PoseTrajectory, list[Any]]:
    targets = [judge.pose(row) for row in q]
    positions = [target.translation for target in targets]
    return lt.PoseTrajectory(times, positions, [quaternion(t) for t in targets]), targets


def _feasible(arm: lt.Arm, rng: Any) -> tuple[Any, Any]:
    """Times and joints of a spline through five points, rest to rest, at half of all limits."""
    lower, upper = ranges(arm)
    edge = 0.05 * (upper - lower)
    s = np.linspace(0.0, 1.0, SAMPLES)
    while True:
        way = [rng.uniform(lower + edge, upper - edge)]
        for _ in range(4):
            step = 0.15 * (upper - lower) * rng.uniform(-1.0, 1.0, len(lower))
            way.append(np.clip(way[-1] + step, lower + edge, upper - edge))
        spline = CubicSpline(np.linspace(0.0, 1.0, 5), way, bc_type="clamped")
        if (spline(s) > lower).all() and (spline(s) < upper).all():
            break
    speed = (np.abs(spline(s, 1)) / arm.limits.velocity).max()
    acceleration = (np.abs(spline(s, 2)) / arm.limits.acceleration).max()
    return s * max(speed / 0.5, np.sqrt(acceleration / 0.5)), spline(s)


def _warm_started(solve: Solve, targets: Sequence[Any], start: Any) -> list[Any]:
    answers, last = [], start
    for target in targets:
        answers.append(solve(target, last))
        last = last if answers[-1] is None else answers[-1]
    return answers


def _smooth(arm: lt.Arm, count: int) -> Any:
    """A slow motion of all joints in the middle parts of their ranges."""
    lower, upper = ranges(arm)
    phase = np.linspace(0.0, np.pi, count)[:, None] + np.arange(len(lower))
    return 0.5 * (lower + upper) + 0.15 * (upper - lower) * np.sin(phase)
