"""Reasons why an arm misses a sample of a path: the limiting joint, or the distance that is left.

Samples beyond the arm's reach, and first and last samples that no joint positions reach, end in an
`IkFailure` before any other is solved.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from copy import copy

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough import rotations
from leadthrough.arm.inverse_kinematics import STATUSES, Axis, IkOptions, compiled
from leadthrough.arm.limits import JointLimits
from leadthrough.arm.link_geometry import link_poses
from leadthrough.arm.model import ArmModel
from leadthrough.arm.tip_path import TipPath, Track
from leadthrough.check import Float64Array, IkFailure

# A joint this near to a limit is at it, rad (m).
_AT_LIMIT = 1e-4
# Cosine between a joint's effect on the tip and what is missing, from which on it would help.
_HELPS = 1e-3
# Samples of the rest of a path that are looked at for how far it goes beyond.
_LOOKED_AT = 9
# A position this many reaches away is not meant: it is in mm.
_IMPLAUSIBLE = 20.0
# A pose is not reached if this thorough a search says so, twice.
_ITERATIONS, _RESTARTS, _SEEDS = 20_000, 200, (0, 1)
_SIX = 6  # joints, with which an arm can have any position and orientation
_MIN_TOLERANCES = (1e-6, 1e-5)  # m and rad, of the ends and the reach
_REASONS = {
    "unreachable": "no joint positions reach the pose",
    "limits": "the joint limits keep the tip from the pose",
    "jump": "the pose can be reached, but not from the sample before",
    "rate_limit": "the arm's limits are too low for the motion's pace; slow the motion down",
}


def failure(
    chain: core.Chain, limits: JointLimits, path: TipPath, track: Track, *, otherwise: str
) -> IkFailure:
    """The error for the first sample that a track misses."""
    i, closest = track.reached, track.q[track.reached]
    q, codes, far, angles, bars = _nearest(chain, path, np.array([i]), closest)
    beyond = ""
    if codes[0]:
        status, residual = STATUSES[codes[0]], (float(far[0]), float(angles[0]))
        closest, barred = q[0], bars[0]
        why = limiting_joints_text(limits, closest, barred.tolist())
        beyond = _beyond(chain, path, i, track.q[i])
    else:
        status = otherwise
        residual = (float(track.position_errors[i]), float(track.orientation_errors[i]))
        barred = _barred(chain, limits, path.only(slice(i, i + 1)), closest)
        why = limiting_joints_text(limits, closest, barred.tolist())
        if status == "jump" and not why:
            why = _leap(limits, track.q[max(i - 1, 0)], q[0])
    reasons = ": ".join(text for text in (_REASONS.get(status), why) if text)
    message = (
        f"sample {i} at {path.times[i]:.6g} s: {status}{f' ({reasons})' if reasons else ''}, "
        f"{residual[0]:.3g} m and {residual[1]:.3g} rad away{beyond}"
    )
    names = tuple(np.array(limits.joint_names)[barred].tolist())
    return IkFailure(
        message, index=i, status=status, residual=residual, q=closest.copy(), limiting_joints=names
    )


def with_reason(failure: IkFailure, reason: str) -> IkFailure:
    same = copy(failure)
    same.args = (f"{failure}; {reason}",)
    return same


def limiting_joints_text(limits: JointLimits, q: Float64Array, bars: Sequence[bool]) -> str:
    """The joints that limit the arm and the limits that they are at; empty if there are none."""
    texts = []
    for j in np.flatnonzero(bars):
        low, high = float(limits.lower[j]), float(limits.upper[j])
        side, limit = ("lower", low) if q[j] - low < high - q[j] else ("upper", high)
        texts.append(f"{limits.joint_names[j]} at its {side} limit {limit:.4g}")
    return " and ".join(texts)


def _nearest(
    chain: core.Chain, path: TipPath, samples: NDArray[np.intp], q0: Float64Array
) -> tuple[Float64Array, NDArray[np.int32], Float64Array, Float64Array, NDArray[np.bool_]]:
    """Joints (m, joints) nearest to samples, status codes, errors in m and rad, limiting joints."""
    wanted, starts = path.only(samples), np.repeat(q0[None], len(samples), axis=0)
    q, codes, far, angles, _, bars = core.solve_ik_batch(
        chain,
        wanted.positions,
        wanted.orientations,
        starts,
        path.options(),
        1,
        None,
        own_restarts=False,
    )
    return q, codes, far, angles, bars


def _beyond(chain: core.Chain, path: TipPath, first: int, q0: Float64Array) -> str:
    """By how much the rest of a path, some samples of it, exceeds what the arm reaches."""
    samples = np.unique(np.linspace(first, len(path) - 1, _LOOKED_AT).round().astype(np.intp))
    _, codes, far, angles, _ = _nearest(chain, path, samples, q0)
    farthest, most = float(far[codes != 0].max()), float(angles[codes != 0].max())
    return f"; the motion goes up to {farthest:.3g} m and {most:.3g} rad beyond what is reached"


def _barred(
    chain: core.Chain, limits: JointLimits, sample: TipPath, q: Float64Array
) -> NDArray[np.bool_]:
    """Joints (joints,) whose limits keep the tip from coming nearer to a sample."""
    positions, orientations = chain.forward_kinematics(q[None])
    missing = sample.positions[0] - positions[0]
    columns = core.jacobian(chain, q[None])[0]
    if len(sample.orientations) and not sample.free:
        turn = rotations.compose(sample.orientations, rotations.inverse(orientations))
        missing = np.concatenate([missing, rotations.log(turn)[0]])
    columns = columns[: len(missing)]
    pull = missing @ columns
    helps = np.abs(pull) > _HELPS * np.linalg.norm(columns, axis=0) * np.linalg.norm(missing)
    low, high = q <= limits.lower + _AT_LIMIT, q >= limits.upper - _AT_LIMIT
    return np.asarray(helps & np.where(pull < 0.0, low, high))


def _leap(limits: JointLimits, before: Float64Array, after: Float64Array) -> str:
    """The joint that is farthest from where a pose needs it."""
    away = np.abs(after - before)
    name = limits.joint_names[int(np.argmax(away))]
    return f"{name} would have to move by {away.max():.3g} rad (m) at once"


def require_reachable(
    arm: ArmModel,
    path: TipPath,
    *,
    free: Collection[Axis] | None,
    tolerances: tuple[float, float],
    near: tuple[Float64Array | None, Float64Array | None],
) -> None:
    """Refuses a path that leaves the arm's reach, or whose ends no joint positions reach."""
    left = set(free or ())
    if left & {"x", "y", "z"}:
        return  # then the position need not be reached
    away = np.linalg.norm(path.positions - _shoulder(arm), axis=1)
    slack = max(tolerances[0], _MIN_TOLERANCES[0])
    if away.max() > arm._chain.reach + slack:
        raise _too_far(arm, path, away, slack)
    oriented = not left and len(path.orientations) > 0 and len(arm.joint_names) >= _SIX
    for i in dict.fromkeys((len(path) - 1, 0)):
        orientation = path.orientations[i : i + 1] if oriented else np.empty((0, 4))
        likely = near[-1 if i else 0]
        q0 = arm._chain.middle if likely is None else likely
        _require_end(arm, path, i, orientation, tolerances=tolerances, near=q0)


def _shoulder(arm: ArmModel) -> Float64Array:
    """Position of the first joint, (3,) m in the base frame; the reach is measured from there."""
    joints = arm._robot.path(arm.base, arm.tip)
    first = next(joint for joint in joints if joint.kind != "fixed")
    orientations, positions = link_poses(arm, arm._chain.middle[None])[
        arm._robot.links[first.parent]
    ]
    return np.asarray(positions[0] + orientations[0] @ first.position)


def _too_far(arm: ArmModel, path: TipPath, away: Float64Array, slack: float) -> IkFailure:
    reach = arm._chain.reach
    i, worst = int(np.argmax(away > reach + slack)), int(np.argmax(away))
    unit = "; give positions in m, not mm" if away[worst] > _IMPLAUSIBLE * reach else ""
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
    arm: ArmModel,
    path: TipPath,
    i: int,
    orientation: Float64Array,
    *,
    tolerances: tuple[float, float],
    near: Float64Array,
) -> None:
    options = IkOptions(
        position_tolerance=max(tolerances[0], _MIN_TOLERANCES[0]),
        orientation_tolerance=max(tolerances[1], _MIN_TOLERANCES[1]),
        max_iterations=_ITERATIONS,
        max_restarts=_RESTARTS,
    )
    for seed in _SEEDS:
        q, codes, far, angles, _, bars = core.solve_ik_batch(
            arm._chain,
            path.positions[i : i + 1],
            orientation,
            near[None],
            compiled(options, seed),
            1,
            arm._closed_form,
            own_restarts=False,
        )
        if codes[0] == 0:
            return
    end = "the motion's end" if i else "the motion's start"
    why = limiting_joints_text(arm.limits, q[0], bars[0].tolist()) or "no joint positions reach it"
    status = STATUSES[codes[0]]
    message = (
        f"sample {i} at {path.times[i]:.6g} s: {status} ({end} is not reached: {why}), "
        f"{far[0]:.3g} m and {angles[0]:.3g} rad away"
    )
    residual = (float(far[0]), float(angles[0]))
    names = tuple(np.array(arm.joint_names)[bars[0]].tolist())
    raise IkFailure(
        message, index=i, status=status, residual=residual, q=q[0].copy(), limiting_joints=names
    )
