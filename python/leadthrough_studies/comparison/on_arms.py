"""Whether an arm can run a motion: reachable, without a leap, clear of itself, how much slower."""

from __future__ import annotations

import numpy as np

import leadthrough as lt
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure
from leadthrough.motion import PoseTrajectory, Trajectory
from leadthrough_studies.comparison.measures import evenly_sampled
from leadthrough_studies.study import Row

ARMS = ("panda", "ur3")
_FOLLOWED = 200  # samples at which an arm follows
_RATE = 100.0  # Hz, of the motion inside the limits
_PATH_TOLERANCE = 1e-3  # rad (m)
# By arm: m per mm of a drawing, the middle of the place where it moves, and the largest extent of a
# motion there, m. Larger motions are scaled down to it.
_PLACES = {"panda": (0.004, (0.5, 0.0, 0.3), 0.4), "ur3": (0.003, (-0.05, -0.3, 0.2), 0.22)}
_DOWN = (0.0, 1.0, 0.0, 0.0)
# A joint that turns by more than this from one of 200 samples to the next has leapt, rad.
_LEAP = 0.3


def on_paper(arm: str, made: Trajectory) -> PoseTrajectory:
    """A drawing in mm on a horizontal table before an arm, the tool pointing down."""
    scale, middle, _ = _PLACES[arm]
    flat = made.positions - 0.5 * (made.positions.min(axis=0) + made.positions.max(axis=0))
    points = np.column_stack([flat[:, 1], flat[:, 0], np.zeros(len(flat))]) * scale + middle
    return PoseTrajectory(made.times, points, np.tile(_DOWN, (len(points), 1)))


def before(arm: str, made: Trajectory | PoseTrajectory) -> PoseTrajectory:
    """A motion in m moved to before an arm, with its own orientation or the tool pointing down."""
    _, middle, largest = _PLACES[arm]
    low, high = made.positions.min(axis=0), made.positions.max(axis=0)
    scale = min(1.0, largest / float((high - low).max()))
    points = (made.positions - 0.5 * (low + high)) * scale + middle
    down: Float64Array = np.tile(_DOWN, (len(points), 1))
    turned = made.orientations if isinstance(made, PoseTrajectory) else down
    return PoseTrajectory(made.times, points, turned)


def on_arm(arm: str, motion: PoseTrajectory) -> Row:
    """Whether an arm can run a motion, and what is in the way.

    Args:
        arm: name of the robot.
        motion: the tool's motion, in the arm's base frame.

    Returns:
        The columns "executed", "reachable", "without_leap" and "clear" (1 or 0; the last two only
        where it is reachable), "leap_rad", "slower" by the arm's limits, and "begins_at", the
        first speed over the largest.
    """
    robot = lt.Arm.load(arm)
    times = np.linspace(motion.times[0], motion.times[-1], _FOLLOWED)
    way = PoseTrajectory(times, *evenly_sampled(motion, _FOLLOWED))
    speeds = np.linalg.norm(np.diff(way.positions, axis=0), axis=1)
    row = {"begins_at": float(speeds[0] / max(speeds.max(), 1e-12))}
    try:
        joints = robot.follow(way, on_rate_limit="exceed_limits")
    except IkFailure as error:
        return {**row, "executed": 0, "reachable": 0, "refused": str(error)[:120]}
    slow = lt.keep_timing(joints, robot.limits, rate=_RATE, path_tolerance=_PATH_TOLERANCE)
    leap = float(np.abs(np.diff(joints.positions, axis=0)).max())
    smooth, clear = leap < _LEAP, bool(robot.check(joints).ok)
    return {
        **row,
        "executed": int(smooth and clear),
        "reachable": 1,
        "without_leap": int(smooth),
        "clear": int(clear),
        "leap_rad": leap,
        "slower": slow.duration / joints.duration,
    }


def on_all(motions: dict[str, PoseTrajectory]) -> Row:
    """The columns of `on_arm` for every arm, each headed by the arm's name.

    Args:
        motions: the motion for each arm.
    """
    return {
        f"{arm}_{name}": value
        for arm, motion in motions.items()
        for name, value in on_arm(arm, motion).items()
    }
