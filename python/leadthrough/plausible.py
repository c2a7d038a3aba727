"""Inputs that contradict what was shown: wrong units, wrong frames, a wrong order.

What cannot be meant raises `InvalidInput`; what can hardly be meant is a `Suspicious` warning. Both
name the argument and say what cures it. Nobody else in the package guesses at units.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.repr import numbers_text
from leadthrough.shapes import Shape

_PACKAGE = "leadthrough."
# A place this many times as far away as a motion or an arm is large is in another unit: a thousand
# times in mm. No task stretches a motion a hundred times.
_FAR = 100.0
# Joints, rad: nobody asks for more than two turns from where a joint was shown; degrees do.
_TURNS = 4.0 * np.pi
# rad: farther than this from all that were shown, the orientation of an end is looked at again; and
# nearer than this to the one shown there, with its components in another order, it was given so. Of
# all rotations one in five thousand is as near by chance.
_TURNED_AWAY, _THE_SAME = 1.6, 0.15
_CLEARLY_NEAR = 0.75  # more than the cosine of half of the former
# s between samples: no hand is recorded so slowly; ms read as s are. Whole numbers tell it earlier.
_SLOWEST, _SLOWEST_WHOLE = 20.0, 2.0
_RECORDED = 20  # samples from which on a motion was recorded, not typed


class Suspicious(UserWarning):
    """An input that can hardly be meant, such as a wrong unit; the message says what to do."""


def warn(message: str, category: type[UserWarning] = Suspicious) -> None:
    """Warns, by default of something suspicious, at the line of the user's program to blame."""
    level, frame = 1, sys._getframe(0)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(_PACKAGE):
        level, frame = level + 1, frame.f_back
    warnings.warn(message, category, stacklevel=level)


def place(wanted: Float64Array, shown: Float64Array, name: str) -> None:
    """Refuses a place (d,) that lies a hundred times as far away as a motion (n, d) is large."""
    if _is_near(wanted.tolist(), shown[0].tolist(), shown[-1].tolist()):
        return  # most queries, told at once
    size = max(float(np.ptp(shown, axis=0).max()), float(np.abs(shown).max()))
    away = float(np.abs(shown - wanted).max(axis=1).min())
    if size > 0.0 and away > _FAR * size:
        raise InvalidInput(
            f"{name}: {numbers_text(wanted)} lies {away:.4g} from a motion that keeps within "
            f"{size:.3g} of the origin; give it in the unit of the demonstrations (m, not mm)"
        )


def _is_near(wanted: list[float], first: list[float], last: list[float]) -> bool:
    """Whether a place is near the first of a motion's, by its size as far as its ends tell it."""
    size = max(*map(abs, first), *(abs(b - a) for a, b in zip(first, last, strict=True)))
    return all(abs(b - a) <= _FAR * size for a, b in zip(first, wanted, strict=True))


def joints(wanted: Float64Array, shown: Float64Array, name: str) -> None:
    """Refuses joint positions (d,) that are turns away from all that were shown (n, d), rad."""
    away = np.abs(shown - wanted).min(axis=0)
    farthest = int(np.argmax(away))
    if away[farthest] > _TURNS:
        raise InvalidInput(
            f"{name}: number {farthest + 1} is {wanted[farthest]:.4g} rad, more than two turns "
            "from what was shown; give joints in radians, not degrees"
        )


def orientation(wanted: Float64Array, shown: Float64Array, end: Float64Array, name: str) -> None:
    """Warns of an orientation that seems to be given as x, y, z, w."""
    if abs(float(wanted @ end)) > _CLEARLY_NEAR:
        return  # most queries, told at once
    away = _nearest(wanted, shown)
    x, y, z, w = wanted
    if away > _TURNED_AWAY and _nearest(np.array([w, x, y, z]), end[None]) < _THE_SAME:
        warn(
            f"{name}: the orientation {numbers_text(wanted)} is {away:.3g} rad from all that were "
            "shown, and as shown if it is x, y, z, w; give quaternions as w, x, y, z"
        )


def obstacles(shapes: Sequence[Shape], shown: Float64Array) -> None:
    """Warns of obstacles with position or size in another unit than positions (n, d)."""
    if not shapes:
        return
    size = max(float(np.ptp(shown, axis=0).max()), float(np.abs(shown).max()))
    for i, shape in enumerate(shapes):
        farthest = float(np.abs(shape.middle).max())
        if size > 0.0 and farthest > _FAR * size:
            warn(
                f"obstacles[{i}]: lies at {numbers_text(shape.middle)}, while the motion keeps "
                f"within {size:.3g} of the origin; give it in the same unit (m, not mm)"
            )


def clock(times: Float64Array, name: str) -> None:
    """Warns of a recording's times (n,) that can hardly be in s."""
    if len(times) < _RECORDED:
        return
    step = float(np.median(np.diff(times)))
    whole = bool((times == np.round(times)).all())
    if step > (_SLOWEST_WHOLE if whole else _SLOWEST):
        warn(
            f"{name}: one sample in {step:.4g} s; times are in s, so divide those in ms by 1000, "
            "or leave them out of the columns and set rate"
        )


def step(dt: float, duration: float) -> None:
    """Refuses a sampling step that is longer than the motion, s."""
    if dt > duration:
        raise InvalidInput(
            f"dt: expected at most the motion's duration, {duration:.4g} s, got {dt:g} s; dt is "
            "the time between samples in s, not ms"
        )


def _nearest(wanted: Float64Array, shown: Float64Array) -> float:
    """The least angle between an orientation (4,) and others (n, 4), rad."""
    cosine = min(1.0, float(np.abs(shown @ wanted).max()))
    return 2.0 * float(np.arccos(cosine))
