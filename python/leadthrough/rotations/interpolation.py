"""Interpolation between rotations: slerp, piecewise slerp and squad."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.rotations.derivatives import angular_velocity
from leadthrough.rotations.group import align_signs, pair, timed


def slerp(a: ArrayLike, b: ArrayLike, fractions: ArrayLike) -> Float64Array:
    """Rotations (n, 4) on the shortest turns from a to b, at constant speed.

    Args:
        a: unit quaternions (n, 4).
        b: unit quaternions (n, 4). Of the two ways of exactly half a turn, the result takes the
            one to b with the sign as given.
        fractions: how far to turn, (n,), from 0 at a to 1 at b.

    Returns:
        Quaternions that are continuous from a, so that at 1 they may be -b.

    Raises:
        InvalidInput: if the arguments are malformed or a fraction lies outside [0, 1].

    Source: Shoemake 1985, "Animating rotation with quaternion curves".
    """
    first, second = pair(a, b)
    parts = check.array(fractions, "fractions", shape=(len(first),))
    if ((parts < 0) | (parts > 1)).any():
        raise InvalidInput(
            f"fractions: expected numbers from 0 to 1, got {parts.min()} to {parts.max()}"
        )
    return _core.so3_slerp(first, second, parts)


def interpolate(times: ArrayLike, quaternions: ArrayLike, at: ArrayLike) -> Float64Array:
    """Rotations (m, 4) on the shortest turns between samples.

    They are continuous, signs too, with a jump of the angular velocity at every sample.

    Args:
        times: of the samples, s, (n,), n >= 2.
        quaternions: the samples, unit quaternions (n, 4).
        at: times of the result, s, (m,), not before the first sample or after the last.

    Raises:
        InvalidInput: if the arguments are malformed or a time lies outside the samples'.
    """
    t, samples = timed(times, quaternions, at_least=2)
    q = align_signs(samples)
    i, fractions = _places(t, at)
    return _core.so3_slerp(q[i], q[i + 1], fractions)


def squad(times: ArrayLike, quaternions: ArrayLike, at: ArrayLike) -> Float64Array:
    """Rotations (m, 4) on a curve through samples with a continuous angular velocity.

    At the samples the velocity is that of `angular_velocity`. At evenly spaced times it is
    Shoemake's curve. A long step after a short and fast one starts with the velocity of the short
    one and swings far out: `interpolate` is safer there.

    Args:
        times: of the samples, s, (n,), n >= 2, evenly spaced or not.
        quaternions: the samples, unit quaternions (n, 4); any three neighbours turn less than half
            a turn.
        at: times of the result, s, (m,), not before the first sample or after the last.

    Raises:
        InvalidInput: if the arguments are malformed, a time lies outside the samples', or steps are
            too uneven.

    Source: Shoemake 1987, "Quaternion calculus and fast animation".
    """
    t, samples = timed(times, quaternions, at_least=2)
    q = align_signs(samples)
    i, fractions = _places(t, at)
    leaving, arriving = squad_controls(t, q)
    chord = _core.so3_slerp(q[i], q[i + 1], fractions)
    handle = _core.so3_slerp(leaving[i], arriving[i], fractions)
    return _core.so3_slerp(chord, handle, 2.0 * fractions * (1.0 - fractions))


def squad_controls(times: Float64Array, q: Float64Array) -> tuple[Float64Array, Float64Array]:
    """The two inner rotations of every step between samples, which make `squad` smooth at them."""
    velocities = angular_velocity(times, q)
    turns = _core.so3_log(_core.so3_compose(q[1:], q[:-1] * [1.0, -1.0, -1.0, -1.0]))
    steps = np.diff(times)[:, None]
    with np.errstate(over="ignore"):  # what is not finite is refused below
        outwards = _core.so3_exp(0.5 * (steps * velocities[:-1] - turns))
        inwards = _core.so3_exp(0.5 * (turns - steps * velocities[1:]))
    if not (np.isfinite(outwards).all() and np.isfinite(inwards).all()):
        raise InvalidInput("times: expected steps of similar length, got steps that are too uneven")
    return _core.so3_compose(outwards, q[:-1]), _core.so3_compose(inwards, q[1:])


def _places(times: Float64Array, at: ArrayLike) -> tuple[NDArray[np.intp], Float64Array]:
    """The interval that each time lies in, and the fraction of it that has passed."""
    asked = check.array(at, "at", shape=("m",))
    outside = (asked < times[0]) | (asked > times[-1])
    if outside.any():
        raise InvalidInput(
            f"at: expected times from {times[0]} s to {times[-1]} s, got {asked[outside][0]} s"
        )
    i = np.clip(np.searchsorted(times, asked, side="right") - 1, 0, len(times) - 2)
    return i, (asked - times[i]) / (times[i + 1] - times[i])
