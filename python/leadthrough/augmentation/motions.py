"""Motions of a skill on an arm for random queries, at the skill's own pace, packed as rows."""

from __future__ import annotations

import base64
import pickle
import warnings
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from leadthrough.check import Float64Array
from leadthrough.models import Skill, load_skill
from leadthrough.motion import Event, JointTrajectory, Motion
from leadthrough.tasks import Row
from leadthrough.timing import check_limits, keep_timing
from leadthrough.validation.validate import PATH_TOLERANCE, Setup, attempt, draw_query, numbers_of


def motions(*, first: int, count: int, seed: int, skill: Path, setup: Path) -> list[Row]:
    """A row for each of some queries: the motion, or the reason if the arm cannot run it."""
    learned = load_skill(skill)
    with setup.open("rb") as file:
        common: Setup = pickle.load(file)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # unusual queries show in their motions
        return [_row(learned, common, seed, number) for number in range(first, first + count)]


def _row(learned: Skill[Motion], common: Setup, seed: int, number: int) -> Row:
    asked, scene = draw_query(common, seed, number)
    asked = replace(asked, dt=1.0 / common.rate)
    timed, cause, _ = attempt(learned, common, asked, scene, timing=_demonstrated)
    row: Row = {"number": number, "cause": cause}
    if timed is None or cause:
        return row
    assert asked.goal is not None
    places = [shape.position.tolist() for shape in scene.shapes]
    assert timed.velocities is not None
    packed = np.hstack([timed.positions, timed.velocities]).astype(np.float32)
    return row | {
        "objects": [*numbers_of(asked.goal), *(x for place in places for x in place)],
        "events": [[event.time, event.name] for event in timed.events],
        "rows": base64.b64encode(zlib.compress(packed.tobytes())).decode(),
    }


def _demonstrated(joints: JointTrajectory, setup: Setup) -> JointTrajectory:
    """The motion at its own pace, slowed down where limits require it."""
    sampled = _sampled(joints, setup.rate)
    if check_limits(sampled, setup.arm.limits).ok:
        return sampled
    return keep_timing(joints, setup.arm.limits, rate=setup.rate, path_tolerance=PATH_TOLERANCE)


def _sampled(joints: JointTrajectory, rate: float) -> JointTrajectory:
    """Samples of the spline through a motion, from rest to rest, over a whole number of periods."""
    curve = CubicSpline(joints.times, joints.positions, bc_type="clamped")
    periods = max(1, int(np.ceil(joints.duration * rate - 1e-9)))
    stretch = periods / rate / joints.duration
    own = np.arange(periods + 1) / rate
    times = joints.times[0] + np.minimum(own / stretch, joints.duration)
    events = tuple(
        Event((event.time - float(joints.times[0])) * stretch, event.name)
        for event in joints.events
    )
    q, qd, qdd = (curve(times, order) / stretch**order for order in range(3))
    names = joints.joint_names
    return JointTrajectory(own, q, qd, qdd, joint_names=names, events=events)


def unpacked(row: Row, joints: int) -> tuple[Float64Array, Float64Array]:
    """Positions and velocities (n, joints) of a row that has a motion."""
    packed = zlib.decompress(base64.b64decode(row["rows"]))
    rows = np.frombuffer(packed, np.float32).reshape(-1, 2 * joints).astype(np.float64)
    return np.ascontiguousarray(rows[:, :joints]), rows[:, joints:]
