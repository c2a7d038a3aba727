"""The options of inverse kinematics, checked."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# Of the target's frame: along its axes, then about them.
AXES = ("x", "y", "z", "rx", "ry", "rz")

_MODES = {"fastest": _core.IkMode.FASTEST, "closest": _core.IkMode.CLOSEST}


def ik_options(
    *,
    position_tolerance: Any = 1e-6,
    orientation_tolerance: Any = 1e-6,
    free: Sequence[str] = (),
    weights: Any = None,
    mode: str = "fastest",
    reference: Float64Array | None = None,
    midrange: float = 0.0,
    posture: Float64Array | None = None,
    max_iterations: int = 2000,
    max_restarts: int = 100,
    max_cpu_seconds: float | None = None,
    random_seed: int = 0,
) -> _core.IkOptions:
    """Options of `Arm.inverse_kinematics`.

    position_tolerance, orientation_tolerance: m and rad, > 0: of the length of the error, or (3,),
        of its component along each axis.
    free: axes left free, of "x", "y", "z" and the rotations about them "rx", "ry", "rz". With one
        free rotation the tool may spin about that axis of its own, and only the swing of the axis
        is an error; with two only the twist about the third is.
    weights: (6,), > 0: what an error along or about each axis counts against the others while the
        arm moves, and where a target cannot be met; 1 m as much as 1 / 0.3 rad at weights of 1.
    mode: "fastest", the first solution found; "closest", of all that the budget finds the one
        nearest to `reference`, moved in the null space nearer still.
    reference: (joints,), the seed where there is none. Distances are Euclidean, rad and m alike.
    midrange: how far a redundant arm moves itself towards the middle of its ranges once the tip is
        on the target, 0 (it stays next to the seed) to 1.
    posture: (joints,), where a redundant arm moves itself instead, say with its elbow up.
    max_iterations, max_restarts: the effort, the same on every machine.
    max_cpu_seconds: > 0, of CPU time of the thread that solves the pose, besides the iterations;
        what comes out then depends on the machine.
    random_seed: of the restarts.

    The axes are those of the target's frame (of the base frame where no orientation is asked for),
    as are those of tolerances and weights. Self-motion is in the exact null space: the tool stays
    within 1e-6 m. Raises InvalidInput.
    """
    if posture is not None and (midrange != 0 or mode != "fastest"):
        raise InvalidInput("posture: expected none beside midrange or mode 'closest', got one")
    if reference is not None and mode != "closest":
        raise InvalidInput("reference: only mode 'closest' has a use for it")
    position, along = _tolerance(position_tolerance, "position_tolerance")
    orientation, about = _tolerance(orientation_tolerance, "orientation_tolerance")
    return _core.IkOptions(
        _core.IkTolerance(position, orientation),
        _axes(free, (*along, *about), weights),
        _MODES[check.choice(mode, "mode", tuple(_MODES))],
        reference,
        check.number(midrange, "midrange", at_least=0.0, at_most=1.0),
        posture,
        check.integer(max_iterations, "max_iterations", at_least=1, at_most=10**9),
        check.integer(max_restarts, "max_restarts", at_least=0, at_most=10**9),
        math.inf
        if max_cpu_seconds is None
        else check.number(max_cpu_seconds, "max_cpu_seconds", above=0.0),
        check.integer(random_seed, "random_seed", at_least=0, at_most=2**64 - 1),
    )


def tolerance(position: float, orientation: float) -> _core.IkTolerance:
    """Tolerances in m and rad. Raises InvalidInput."""
    return _core.IkTolerance(
        check.number(position, "position_tolerance", above=0.0),
        check.number(orientation, "orientation_tolerance", above=0.0),
    )


def _tolerance(value: Any, name: str) -> tuple[float, Float64Array]:
    """Of the length, and of each axis; one of them does not bind."""
    if np.ndim(value) == 0:
        return check.number(value, name, above=0.0), np.full(3, math.inf)
    return math.inf, _positive(value, name, 3)


def _axes(free: Any, bounds: Sequence[float], weights: Any) -> _core.IkAxes | None:
    """None where all axes are asked for alike, which is solved faster."""
    if isinstance(free, str) or not isinstance(free, Collection):
        raise InvalidInput(f"free: expected names out of {AXES}, got {free!r}")
    for name in free:
        check.choice(name, "free", AXES)
    if set(free) == set(AXES):
        raise InvalidInput("free: expected an axis to be left, got all of them")
    if not free and weights is None and np.isinf(bounds).all():
        return None
    return _core.IkAxes(
        [name in free for name in AXES],
        bounds,
        np.ones(6) if weights is None else _positive(weights, "weights", 6),
    )


def _positive(value: Any, name: str, size: int) -> Float64Array:
    result = check.array(value, name, shape=(size,))
    if not (result > 0).all():
        raise InvalidInput(f"{name}: expected numbers > 0, got {result.min()}")
    return result
