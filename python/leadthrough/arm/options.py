"""The options of inverse kinematics, checked and as the core takes them."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from functools import lru_cache, wraps
from typing import Literal, ParamSpec, TypeVar, get_args

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

# Of the target's frame: along its axes, then about them.
Axis = Literal["x", "y", "z", "rx", "ry", "rz"]
AXES: tuple[Axis, ...] = get_args(Axis)

IkMode = Literal["fastest", "closest"]
_MODES = {"fastest": _core.IkMode.FASTEST, "closest": _core.IkMode.CLOSEST}

_P = ParamSpec("_P")
_R = TypeVar("_R")


def _remembered(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """The function with its last answers kept: a control loop asks with the same options."""
    # By type as well: 100.0 must not pass as the 100 that was seen before.
    remembered = lru_cache(maxsize=64, typed=True)(function)

    @wraps(function)
    def call(*args: _P.args, **kwargs: _P.kwargs) -> _R:
        try:
            return remembered(*args, **kwargs)  # type: ignore[arg-type]  # that is what is tried
        except TypeError:  # an argument, such as an array, has no hash
            return function(*args, **kwargs)

    return call


@_remembered
def ik_options(
    *,
    position_tolerance: ArrayLike = 1e-6,
    orientation_tolerance: ArrayLike = 1e-6,
    free: Sequence[Axis] = (),
    weights: ArrayLike | None = None,
    mode: IkMode = "fastest",
    reference: Float64Array | None = None,
    midrange: float = 0.0,
    posture: Float64Array | None = None,
    max_iterations: int = 2000,
    max_restarts: int = 100,
    max_cpu_seconds: float | None = None,
    random_seed: int = 0,
) -> _core.IkOptions:
    """The core's options from those of `Arm.inverse_kinematics`, which says what they mean."""
    _refuse_contradictions(mode, reference, midrange, posture)
    position, along = _tolerance(position_tolerance, "position_tolerance")
    orientation, about = _tolerance(orientation_tolerance, "orientation_tolerance")
    seconds = math.inf
    if max_cpu_seconds is not None:
        seconds = check.number(max_cpu_seconds, "max_cpu_seconds", above=0.0)
    return _core.IkOptions(
        _core.IkTolerance(position, orientation),
        _axes(free, (*along, *about), weights),
        _MODES[check.choice(mode, "mode", tuple(_MODES))],
        reference,
        check.number(midrange, "midrange", at_least=0.0, at_most=1.0),
        posture,
        check.integer(max_iterations, "max_iterations", at_least=1, at_most=10**9),
        check.integer(max_restarts, "max_restarts", at_least=0, at_most=10**9),
        seconds,
        check.integer(random_seed, "random_seed", at_least=0, at_most=2**64 - 1),
    )


def tolerance(position: float, orientation: float) -> _core.IkTolerance:
    """Tolerances in m and rad."""
    return _core.IkTolerance(
        check.number(position, "position_tolerance", above=0.0),
        check.number(orientation, "orientation_tolerance", above=0.0),
    )


def free_axes(free: Sequence[Axis]) -> _core.IkAxes | None:
    """The axes of a path along which each sample's are free, or None if none is."""
    return _axes(free, [math.inf] * len(AXES), None)


def all_axes(free: Sequence[Axis]) -> _core.IkAxes:
    """The same, given also where none is free: errors are then along each sample's axes."""
    return _core.IkAxes([name in free for name in AXES], [math.inf] * len(AXES), np.ones(6))


def _refuse_contradictions(mode: str, reference: object, midrange: float, posture: object) -> None:
    if posture is not None and midrange != 0:
        raise InvalidInput("posture: not used together with midrange; remove one of the two")
    if posture is not None and mode != "fastest":
        raise InvalidInput(
            "posture: only used with mode='fastest'; with mode='closest' pass it as reference"
        )
    if reference is not None and mode != "closest":
        raise InvalidInput(
            "reference: only used with mode='closest'; remove it or set mode='closest'"
        )


def _tolerance(value: ArrayLike, name: str) -> tuple[float, Float64Array]:
    """Bounds on the length of the error and on each axis; one of the two does not bind."""
    if np.ndim(value) == 0:
        return check.number(value, name, above=0.0), np.full(3, math.inf)
    return math.inf, _positive(value, name, 3)


def _axes(
    free: Sequence[Axis], bounds: Sequence[float], weights: ArrayLike | None
) -> _core.IkAxes | None:
    """The axes, or None if none is free and all count alike, which is solved faster."""
    if isinstance(free, str) or not isinstance(free, Collection):
        names = ", ".join(repr(name) for name in AXES)
        raise InvalidInput(f"free: expected a collection of names out of {names}, got {free!r}")
    for name in free:
        check.choice(name, "free", AXES)
    if set(free) == set(AXES):
        raise InvalidInput("free: expected at least one axis not to be free, got all six")
    if not free and weights is None and np.isinf(bounds).all():
        return None
    return _core.IkAxes(
        [name in free for name in AXES],
        bounds,
        np.ones(6) if weights is None else _positive(weights, "weights", 6),
    )


def _positive(value: ArrayLike, name: str, size: int) -> Float64Array:
    result = check.array(value, name, shape=(size,))
    if not (result > 0).all():
        raise InvalidInput(f"{name}: expected numbers > 0, got {result.min()}")
    return result
