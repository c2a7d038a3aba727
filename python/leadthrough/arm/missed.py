"""Why an arm misses a sample of a path: the joint that stands in the way, or how far it gets."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from leadthrough import _core, rotations
from leadthrough.arm.limits import JointLimits
from leadthrough.arm.results import STATUSES
from leadthrough.arm.tracks import TipPath, Track
from leadthrough.check import Float64Array
from leadthrough.errors import IkFailure

# A joint this near to a limit is at it, rad (m).
_AT_LIMIT = 1e-4
# Cosine between a joint's effect on the tip and what is missing, from which on it would help.
_HELPS = 1e-3
# Samples of the rest of a path that are looked at for how far it goes beyond.
_LOOKED_AT = 9
_REASONS = {
    "unreachable": "no joint positions reach the pose",
    "limits": "the joint limits keep the tip from the pose",
    "jump": "the pose can be reached, but not from the sample before",
    "too_fast": "the arm's limits are too low for the motion's pace; slow the motion down",
}


def failure(
    chain: _core.Chain, limits: JointLimits, path: TipPath, track: Track, *, on_the_way: str
) -> IkFailure:
    """The error for the first sample that a track misses."""
    i, closest = track.reached, track.q[track.reached]
    q, codes, far, turned, bars = _nearest(chain, path, np.array([i]), closest)
    beyond = ""
    if codes[0]:
        status, residual = STATUSES[codes[0]], (float(far[0]), float(turned[0]))
        closest, barred = q[0], bars[0]
        why = limits_in_the_way(limits, closest, barred.tolist())
        beyond = _beyond(chain, path, i, track.q[i])
    else:
        status = on_the_way
        residual = (float(track.position_errors[i]), float(track.orientation_errors[i]))
        barred = _barred(chain, limits, path.only(slice(i, i + 1)), closest)
        why = limits_in_the_way(limits, closest, barred.tolist())
        if status == "jump" and not why:
            why = _leap(limits, track.q[max(i - 1, 0)], q[0])
    told = ": ".join(text for text in (_REASONS.get(status), why) if text)
    message = (
        f"sample {i} at {path.times[i]:.6g} s: {status}{f' ({told})' if told else ''}, "
        f"{residual[0]:.3g} m and {residual[1]:.3g} rad away{beyond}"
    )
    names = tuple(np.array(limits.joint_names)[barred].tolist())
    return IkFailure(
        message, index=i, status=status, residual=residual, q=closest.copy(), limiting_joints=names
    )


def limits_in_the_way(limits: JointLimits, q: Float64Array, bars: Sequence[bool]) -> str:
    """The joints that bar the way and the limits that they are at; empty if there are none."""
    return " and ".join(_at_limit(limits, q, bars))


def _at_limit(limits: JointLimits, q: Float64Array, bars: Sequence[bool]) -> Iterator[str]:
    for j, name in enumerate(limits.joint_names):
        if bars[j]:
            low, high = float(limits.lower[j]), float(limits.upper[j])
            side, limit = ("lower", low) if q[j] - low < high - q[j] else ("upper", high)
            yield f"{name} at its {side} limit {limit:.4g}"


def _nearest(
    chain: _core.Chain, path: TipPath, samples: NDArray[np.intp], seed: Float64Array
) -> tuple[Float64Array, NDArray[np.int32], Float64Array, Float64Array, NDArray[np.bool_]]:
    """Joints (m, joints) nearest to samples, status codes, errors in m and rad, what bars them."""
    wanted, seeds = path.only(samples), np.repeat(seed[None], len(samples), axis=0)
    q, codes, far, turned, _, bars = _core.solve_ik_batch(
        chain, wanted.positions, wanted.orientations, seeds, path.options(), 1
    )
    return q, codes, far, turned, bars


def _beyond(chain: _core.Chain, path: TipPath, first: int, seed: Float64Array) -> str:
    """By how much the rest of a path, some samples of it, exceeds what the arm reaches."""
    samples = np.unique(np.linspace(first, len(path) - 1, _LOOKED_AT).round().astype(np.intp))
    _, codes, far, turned, _ = _nearest(chain, path, samples, seed)
    farthest, most = float(far[codes != 0].max()), float(turned[codes != 0].max())
    return f"; the motion goes up to {farthest:.3g} m and {most:.3g} rad beyond what is reached"


def _barred(
    chain: _core.Chain, limits: JointLimits, sample: TipPath, q: Float64Array
) -> NDArray[np.bool_]:
    """Which joints (joints,) their limits keep from taking the tip nearer to a sample."""
    positions, orientations = chain.forward_kinematics(q[None])
    missing = sample.positions[0] - positions[0]
    columns = _core.jacobian(chain, q[None])[0]
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
