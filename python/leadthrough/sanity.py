"""Sanity of inputs: units, frames and orders that contradict the demonstrations.

Impossible input raises `InvalidInput`; implausible input is an `ImplausibleInputWarning`. Both name
the argument and the remedy. No other part of the package guesses units.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array, InvalidInput, numbers_text
from leadthrough.shapes import Shape

_PACKAGE = "leadthrough."
# A position this many times as far away as a motion or an arm is large is in another unit: a
# thousand times in mm. No task stretches a motion a hundred times.
_FAR = 100.0
# Extents of the demonstrations beyond which a moved goal leaves little of their shape.
_STRETCHED = 5.0
_RETURNS = 0.1  # extents between its ends, at most, of a motion that returns
# Joints, rad: no query is more than two turns from a demonstrated joint position; degrees are.
_TURNS = 4.0 * np.pi
# rad: a step that is a turn but for the first is a leap, where the usual step is below the second.
_OF_TURN, _USUAL_STEP = 0.6, 0.3
# rad: joints that are this near to a whole number of turns apart are in one place.
_OF_WHOLE = 1.0
# rad: an orientation farther than the first from all demonstrated ones, and with its components in
# another order nearer than the second to the demonstrated end, was given in that order. One
# rotation in five thousand is as near by chance.
_MAX_ROTATED, _SAME = 1.6, 0.15
_CLEARLY_NEAR = 0.75  # more than the cosine of half of the former
# s between samples: no recording of a hand is slower, but ms read as s are; of whole numbers, or of
# steps as even as a logger's, nine in ten at most so many usual ones, less is enough.
_MAX_STEP, _MAX_EVEN_STEP, _EVEN = 20.0, 1.0, 1.5
# A time without samples is longer than so many usual steps and s, as for `preprocess.clean`.
_GAP, _MIN_GAP = 5.0, 0.5
_UNIT = 1e-2  # error of a quaternion's norm, of a log that rounds to two digits
_RECORDED = 20  # samples from which on a motion was recorded, not typed


class ImplausibleInputWarning(UserWarning):
    """Implausible input, such as a wrong unit; the message names the remedy."""


def warn(message: str, category: type[UserWarning] = ImplausibleInputWarning) -> None:
    """Warns, by default of implausible input, at the line of the user's program."""
    level, frame = 1, sys._getframe(0)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(_PACKAGE):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, category, stacklevel=level)


def position(given: Float64Array, demonstrated: Float64Array, name: str) -> None:
    """Refuses a position (d,) at a hundred times the extent of the demonstrated ones (n, d)."""
    if _is_near(given.tolist(), demonstrated[0].tolist(), demonstrated[-1].tolist()):
        return  # quick answer for most queries
    size = max(float(np.ptp(demonstrated, axis=0).max()), float(np.abs(demonstrated).max()))
    away = float(np.abs(demonstrated - given).max(axis=1).min())
    if size > 0.0 and away > _FAR * size:
        raise InvalidInput(
            f"{name}: {numbers_text(given)} lies {away:.4g} from a motion that keeps within "
            f"{size:.3g} of the origin; give it in the unit of the demonstrations (m, not mm)"
        )


def _is_near(given: list[float], first: list[float], last: list[float]) -> bool:
    """Whether a position is near the first one, by the size that the motion's ends imply."""
    size = max(*map(abs, first), *(abs(b - a) for a, b in zip(first, last, strict=True)))
    return all(abs(b - a) <= _FAR * size for a, b in zip(first, given, strict=True))


def stretched(given: Float64Array, demonstrated: Float64Array, name: str) -> None:
    """Warns of a position (d,) many extents away from the demonstrated ones (n, d)."""
    first, last, wanted = demonstrated[0].tolist(), demonstrated[-1].tolist(), given.tolist()
    chord = max(abs(b - a) for a, b in zip(first, last, strict=True))
    if all(abs(b - a) <= _STRETCHED * chord for a, b in zip(last, wanted, strict=True)):
        return  # quick answer for most queries
    extent = float(np.ptp(demonstrated, axis=0).max())
    away = float(np.abs(demonstrated - given).max(axis=1).min())
    leads_on = np.abs(demonstrated[-1] - demonstrated[0]).max() > _RETURNS * extent
    if away > _STRETCHED * extent and leads_on:
        warn(
            f"{name}: {numbers_text(given)} lies {away:.4g} from a motion whose extent is "
            f"{extent:.3g}; give it in the frame of the demonstrations, or demonstrate the task "
            "there"
        )


def joints(given: Float64Array, demonstrated: Float64Array, name: str) -> None:
    """Refuses joint positions (d,) that are turns away from all demonstrated ones (n, d), rad."""
    away = np.abs(demonstrated - given).min(axis=0)
    farthest = int(np.argmax(away))
    if away[farthest] > _TURNS:
        raise InvalidInput(
            f"{name}: number {farthest + 1} is {given[farthest]:.4g} rad, more than two turns "
            "from the demonstrated ones; give joints in radians, not degrees"
        )
    if turns(away)[farthest]:
        warn(
            f"{name}: number {farthest + 1} is {given[farthest]:.4g} rad, a whole turn from the "
            "demonstrated ones, and the motion turns by as much; give it at theirs if it can be"
        )


def whole_turns(positions: Float64Array) -> NDArray[np.bool_]:
    """The joints (d,) that leap by a whole turn between samples (n, d), as encoders do."""
    steps = np.abs(np.diff(positions, axis=0))
    leaps = np.asarray((np.abs(steps - 2.0 * np.pi) < _OF_TURN).any(axis=0))
    if len(positions) < _RECORDED or not leaps.any():
        return np.zeros_like(leaps)
    return leaps & (np.median(steps, axis=0) < _USUAL_STEP)


def without_turns(positions: Float64Array) -> Float64Array:
    """Joints (n, d) without the leaps of whole turns that encoders make."""
    leaps = whole_turns(positions)
    return np.where(leaps, np.unwrap(positions, axis=0), positions) if leaps.any() else positions


def continuous(positions: Float64Array, names: Sequence[str]) -> Float64Array:
    """Joints (n, d) of a file without leaps of whole turns, with a warning if there were any."""
    rows = without_turns(positions)
    if rows is not positions:
        changed = (rows != positions).any(axis=0)
        leaps = [name for name, leap in zip(names, changed, strict=True) if leap]
        warn(
            "columns: read as continuous, without the leaps by whole turns that encoders make: "
            f"{', '.join(leaps)}"
        )
    return rows


def turns(angles: Float64Array) -> Float64Array:
    """The turns in angles, rad, that are almost whole and two at most, and 0 for all others."""
    whole = (angles / (2.0 * np.pi)).round()
    near = np.abs(angles - 2.0 * np.pi * whole) < _OF_WHOLE
    return np.where(near & (np.abs(angles) < _TURNS + _OF_WHOLE), whole, 0.0)


def degrees(outside: float) -> str:
    """The question about joints this far beyond their limits, rad; empty within two turns."""
    return "degrees? joints are in radians" if outside > _TURNS else ""


def orientation(
    given: Float64Array, demonstrated: Float64Array, end: Float64Array, name: str
) -> None:
    """Warns of an orientation that seems to be given as x, y, z, w."""
    if abs(float(given @ end)) > _CLEARLY_NEAR:
        return  # quick answer for most queries
    away = _nearest(given, demonstrated)
    x, y, z, w = given
    if away > _MAX_ROTATED and _nearest(np.array([w, x, y, z]), end[None]) < _SAME:
        warn(
            f"{name}: the orientation {numbers_text(given)} is {away:.3g} rad from all "
            "demonstrated ones, but near them as x, y, z, w; give quaternions as w, x, y, z"
        )


def obstacles(shapes: Sequence[Shape], demonstrated: Float64Array) -> None:
    """Warns of obstacles in another unit than positions (n, d)."""
    if not shapes:
        return
    size = max(float(np.ptp(demonstrated, axis=0).max()), float(np.abs(demonstrated).max()))
    for i, shape in enumerate(shapes):
        farthest = float(np.abs(shape.middle).max())
        if size > 0.0 and farthest > _FAR * size:
            warn(
                f"obstacles[{i}]: lies at {numbers_text(shape.middle)}, while the motion keeps "
                f"within {size:.3g} of the origin; give it in the same unit (m, not mm)"
            )


def clock(times: Float64Array, name: str) -> None:
    """Warns of a recording's times (n,) that are hardly in s, or jump."""
    if len(times) < _RECORDED:
        return
    steps = np.diff(times)
    step = float(np.median(steps))
    i = int(np.argmax(steps))
    even = np.percentile(steps, 90) < _EVEN * step or (times == np.round(times)).all()
    if step > _MAX_STEP or (even and step >= _MAX_EVEN_STEP):
        warn(
            f"{name}: one sample in {step:.4g} s; times are in s, so divide those in ms by 1000, "
            "or leave them out of the columns and set rate"
        )
    elif steps[i] > max(_GAP * step, _MIN_GAP):
        start, end = times[i : i + 2].round(3)
        warn(
            f"{name}: no sample from {start:.13g} to {end:.13g} s; if a clock jumped or "
            "another motion begins, divide it there, in Python with preprocess.cut_at_gaps"
        )


def pose(rows: Float64Array, cure: str) -> None:
    """Refuses rows (n, 7) that end in a quaternion, which are neither a point nor joints."""
    if rows.shape[1] == 7 and are_quaternions(rows[:, 3:].T):
        raise InvalidInput(f"columns: the last four of each row have norm 1, as of a pose; {cure}")


def are_quaternions(numbers: Float64Array) -> bool:
    """Whether numbers (4, n) are quaternions."""
    return len(numbers) == 4 and bool((np.abs(np.linalg.norm(numbers, axis=0) - 1) < _UNIT).all())


def step(dt: float, duration: float) -> None:
    """Refuses a sampling step that is longer than the motion, s."""
    if dt > duration:
        raise InvalidInput(
            f"dt: expected at most the motion's duration, {duration:.4g} s, got {dt:g} s; dt is "
            "the time between samples in s, not ms"
        )


def _nearest(given: Float64Array, demonstrated: Float64Array) -> float:
    """The least angle between an orientation (4,) and others (n, 4), rad."""
    cosine = min(1.0, float(np.abs(demonstrated @ given).max()))
    return 2.0 * float(np.arccos(cosine))
