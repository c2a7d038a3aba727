"""Whether an arm can reach a motion at all, told before any of its samples is solved.

Places beyond the arm's length, and first and last samples that no joint positions reach, end in an
`IkFailure` that says by how much, or which joint's limit stands in the way.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from leadthrough import _core, plausible
from leadthrough.arm.definition import ArmDefinition
from leadthrough.arm.link_poses import link_poses
from leadthrough.arm.missed import limits_in_the_way
from leadthrough.arm.options import Axis, ik_options
from leadthrough.arm.results import STATUSES
from leadthrough.arm.tracks import TipPath
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure
from leadthrough.shapes import Box, Shape

_ROUNDING = 1e-6  # m beyond the reach
# A place this many reaches away is not meant: it is in mm.
_ELSEWHERE = 20.0
# A pose is not reached if this thorough a search says so, twice.
_ITERATIONS, _RESTARTS, _SEEDS = 20_000, 200, (0, 1)
_SIX = 6  # joints, with which an arm can have any position and orientation
_TOLERANCES = (1e-6, 1e-5)  # m and rad, beyond those that were asked for


def require_reachable(
    arm: ArmDefinition,
    path: TipPath,
    *,
    free: Sequence[Axis] | None,
    tolerances: tuple[float, float],
    near: tuple[Float64Array | None, Float64Array | None],
) -> None:
    """Refuses a path that leaves the arm's reach, or whose ends no joint positions reach."""
    left = set(free or ())
    if left & {"x", "y", "z"}:
        return  # then the position need not be reached
    away = np.linalg.norm(path.positions - shoulder(arm), axis=1)
    beyond = away - arm._chain.reach
    if beyond.max() > _ROUNDING:
        raise _too_far(arm, path, away)
    turned = not left and len(path.orientations) > 0 and len(arm.joint_names) >= _SIX
    for i in dict.fromkeys((len(path) - 1, 0)):
        orientation = path.orientations[i : i + 1] if turned else np.empty((0, 4))
        likely = near[-1 if i else 0]
        seed = arm._chain.middle if likely is None else likely
        _require_end(arm, path, i, orientation, tolerances=tolerances, near=seed)


def shoulder(arm: ArmDefinition) -> Float64Array:
    """Where the first joint is, (3,) m in the base frame; its reach is measured from there."""
    joints = arm._robot.path(arm.base, arm.tip)
    first = next(joint for joint in joints if joint.kind != "fixed")
    turned, placed = link_poses(arm, arm._chain.middle[None])[arm._robot.links[first.parent]]
    return np.asarray(placed[0] + turned[0] @ first.position)


def look_at_obstacles(arm: ArmDefinition, shapes: Sequence[Shape]) -> None:
    """Warns of obstacles whose place or size does not go with an arm, as in mm."""
    reach = arm._chain.reach
    for i, shape in enumerate(shapes):
        away = float(np.abs(shape.middle).max())
        size = 0.0 if isinstance(shape, Box) else shape.bounding_radius
        if max(away, size) > _ELSEWHERE * reach > 0.0:
            what = f"lies {away:.4g} m from the arm's base" if away > size else f"is {size:.4g} m"
            plausible.warn(
                f"obstacles[{i}]: {what}, and the arm reaches {reach:.3g} m; give places and sizes "
                "in m, not mm, in the arm's base frame"
            )


def _too_far(arm: ArmDefinition, path: TipPath, away: Float64Array) -> IkFailure:
    reach = arm._chain.reach
    i, worst = int(np.argmax(away > reach + _ROUNDING)), int(np.argmax(away))
    unit = "; give places in m, not mm" if away[worst] > _ELSEWHERE * reach else ""
    message = (
        f"sample {i} at {path.times[i]:.6g} s: unreachable (the motion goes up to "
        f"{away[worst] - reach:.3g} m beyond the arm's reach of {reach:.3g} m from its first "
        f"joint); choose a nearer start or goal{unit}"
    )
    residual = (float(away[i]) - reach, 0.0)
    return IkFailure(
        message, index=i, status="unreachable", residual=residual, q=arm._chain.middle.copy()
    )


def _require_end(
    arm: ArmDefinition,
    path: TipPath,
    i: int,
    orientation: Float64Array,
    *,
    tolerances: tuple[float, float],
    near: Float64Array,
) -> None:
    for seed in _SEEDS:
        options = ik_options(
            position_tolerance=max(tolerances[0], _TOLERANCES[0]),
            orientation_tolerance=max(tolerances[1], _TOLERANCES[1]),
            max_iterations=_ITERATIONS,
            max_restarts=_RESTARTS,
            random_seed=seed,
        )
        q, codes, far, turned, _, bars = _core.solve_ik_batch(
            arm._chain, path.positions[i : i + 1], orientation, near[None], options, 1
        )
        if codes[0] == 0:
            return
    end = "the motion's end" if i else "the motion's start"
    why = limits_in_the_way(arm.limits, q[0], bars[0].tolist()) or "no joint positions reach it"
    status = STATUSES[codes[0]]
    message = (
        f"sample {i} at {path.times[i]:.6g} s: {status} ({end} is not reached: {why}), "
        f"{far[0]:.3g} m and {turned[0]:.3g} rad away"
    )
    residual = (float(far[0]), float(turned[0]))
    names = tuple(np.array(arm.joint_names)[bars[0]].tolist())
    raise IkFailure(
        message, index=i, status=status, residual=residual, q=q[0].copy(), limiting_joints=names
    )
