"""Recordings that contradict the others, or that the arm could not make: named, left out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import typer

import leadthrough as lt
from leadthrough import check
from leadthrough.cli import output, robot as robots
from leadthrough.models.contradictions import contradictions
from leadthrough.models.protocol import motions_of
from leadthrough.noise import noise_of

_WINDOW = 0.05  # s, over which a speed is taken, so that noise does not count
_QUANTILE = 0.999  # of a recording's speeds; the few above it are spikes
# A difference of two samples exceeds so many deviations of their noise once in 1,000: 3.3 sqrt(2).
_SPREAD = 4.7


def without(demonstrations: Sequence[lt.Demonstration], names: list[str]) -> list[lt.Demonstration]:
    """The recordings without some, by their names."""
    known = [each.name for each in demonstrations]
    for name in names:
        check.choice(name, "--drop", known)
    return [each for each in demonstrations if each.name not in names]


def refuse_contradictions(ctx: typer.Context, demonstrations: Sequence[lt.Demonstration]) -> None:
    """Refuses a recording that contradicts all others, with the command that drops it."""
    motions = motions_of(demonstrations)
    found = {demonstrations[each.index].name: each.text for each in contradictions(motions)}
    _refuse(ctx, found, len(demonstrations))


def refuse_too_fast(
    ctx: typer.Context, arm: lt.Arm, demonstrations: Sequence[lt.Demonstration]
) -> None:
    """Refuses recordings of joints that move faster than the arm can."""
    found = {
        each.name: text
        for each in demonstrations
        if isinstance(each.motion, lt.JointTrajectory)
        and (text := _too_fast(arm, robots.own_joints(arm, each.motion, each.name)))
    }
    _refuse(ctx, found, len(demonstrations))


def _too_fast(arm: lt.Arm, motion: lt.JointTrajectory) -> str:
    """The joint that is fastest against its limit, if that is exceeded."""
    q, t = motion.positions, motion.times
    if len(t) < 2:
        return ""
    apart = min(max(1, round(_WINDOW / float(np.median(np.diff(t))))), len(t) - 1)
    speeds = np.abs(q[apart:] - q[:-apart]) / (t[apart:] - t[:-apart])[:, None]
    limits = np.where(arm.limits.velocity > 0.0, arm.limits.velocity, np.inf)
    noise = np.array([noise_of(column[:, None]) for column in q.T])
    speeds -= _SPREAD * noise / np.median(t[apart:] - t[:-apart])
    factors = np.quantile(speeds, _QUANTILE, axis=0) / limits
    joint = int(np.argmax(factors))
    if factors[joint] <= 1.0:
        return ""
    return (
        f"moves {arm.joint_names[joint]} at {factors[joint]:.1f} times its speed limit; check "
        "its times or --rate"
    )


def _refuse(ctx: typer.Context, found: Mapping[str, str], count: int) -> None:
    """Raises the error that names recordings; prints the command without them, if others stay."""
    if not found:
        return
    if len(found) < count and not ctx.params["as_json"]:
        dropped = tuple(word for name in found for word in ("--drop", name))
        output.advise(output.line(ctx, *output.repeated(ctx, changed=dropped)))
    texts = "; ".join(f"{name}: {text}" for name, text in found.items())
    names = " ".join(f"--drop {name}" for name in found)
    raise lt.errors.FitError(f"{texts}; leave out with {names}")
