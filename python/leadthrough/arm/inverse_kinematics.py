"""Inverse kinematics of single poses and of batches of them: options, checks, solver, verdicts."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput, ShortRepr

Axis = Literal["x", "y", "z", "rx", "ry", "rz"]
"""Axes of a target's frame that may stay free: along them, then rotations about them."""
AXES: tuple[Axis, ...] = get_args(Axis)

IkMode = Literal["fastest", "closest"]
_MODES = {"fastest": core.IkMode.FASTEST, "closest": core.IkMode.CLOSEST}
IkStatus = Literal["converged", "unreachable", "limits", "budget"]
# In the order of the core's codes.
STATUSES: tuple[IkStatus, ...] = get_args(IkStatus)

# Iterations and restarts of a search for one solution, and of one for all of them.
_BUDGET, _BUDGET_OF_ALL = (2000, 100), (20_000, 1000)
_MAX_COUNT = 10**9
_FREE = np.empty(0)
_FREE_ROWS = np.empty((0, 4))

# The core's answer: the fields of IkResult with codes for the status and, one bit per joint, for
# the limiting joints; and those of IkBatch.
Answer = tuple[Float64Array, int, float, float, int, int]
Columns = tuple[
    Float64Array,
    NDArray[np.int32],
    Float64Array,
    Float64Array,
    NDArray[np.int32],
    NDArray[np.bool_],
]
# Of all configurations: rows, errors, iterations, reason, whether these are all, resolution.
Found = tuple[Float64Array, Float64Array, Float64Array, NDArray[np.int32], int, bool, float]


@dataclass(frozen=True, eq=False, kw_only=True)
class IkOptions(ShortRepr):
    """Options of inverse kinematics; make them once and pass them to each call.

    Attributes:
        position_tolerance: in m, > 0, of the length of the error; or (3,), of its component along
            each axis of the target's frame (of the base frame without orientation).
        orientation_tolerance: in rad, > 0, of the angle; or (3,), about each of these axes.
        free: axes left free, out of "x", "y", "z" and the rotations about them "rx", "ry", "rz",
            in the same frame as the tolerances; by default none. With one free rotation the tool
            may spin about that axis of its own, and only the tilt of the axis is an error; with
            two, only the twist about the third is.
        weights: (6,), > 0, cost of an error along and about each axis while the arm moves and
            where a target cannot be reached. With weights of 1, 1 m costs as much as 1 / 0.3 rad.
        mode: "fastest" returns the first solution; "closest", of all that the budget finds, the
            one nearest to `posture`, moved nearer still in the null space.
        posture: preferred configuration (joints,). In mode "fastest" a redundant arm moves towards
            it in its null space, for example with its elbow up. In mode "closest", and where all
            solutions are asked for, distances to it count, Euclidean, rad and m alike; by default
            distances to `q0`.
        nullspace_gain: fraction, 0 to 1, of the distance towards the middle of its ranges that a
            redundant arm moves in its null space once the tip is on the target; at 0 it stays next
            to `q0`. Not together with `posture` in mode "fastest".
        max_iterations: budget of iterations of a search, the same on every machine; by default
            2000, and 20,000 where all solutions are asked for.
        max_restarts: budget of restarts from random configurations; by default 100, and 1000 where
            all solutions are asked for.
        max_cpu_seconds: CPU time of the calling thread, > 0, that ends the search as well; the
            answer then depends on the machine.

    Raises:
        InvalidInput: if two options contradict each other.
    """

    position_tolerance: ArrayLike = 1e-6
    orientation_tolerance: ArrayLike = 1e-6
    free: Collection[Axis] | None = None
    weights: ArrayLike | None = None
    mode: IkMode = "fastest"
    posture: ArrayLike | None = None
    nullspace_gain: float = 0.0
    max_iterations: int | None = None
    max_restarts: int | None = None
    max_cpu_seconds: float | None = None

    def __post_init__(self) -> None:
        check.choice(self.mode, "mode", tuple(_MODES))
        if self.posture is not None and self.mode == "fastest" and self.nullspace_gain != 0:
            raise InvalidInput(
                "posture: not used together with nullspace_gain; remove one of the two"
            )
        for name, size in (("posture", "joints"), ("weights", 6)):
            if (value := getattr(self, name)) is not None:
                object.__setattr__(self, name, check.frozen(value, name, shape=(size,)))
        compiled(self, 0)
        object.__setattr__(self, "free", tuple(self.free or ()))


@lru_cache(maxsize=64)  # control loops ask with the same options
def compiled(options: IkOptions, seed: int, *, find_all: bool = False) -> core.IkOptions:
    """The options as the core takes them."""
    position, along = _tolerance(options.position_tolerance, "position_tolerance")
    orientation, about = _tolerance(options.orientation_tolerance, "orientation_tolerance")
    iterations, restarts = _BUDGET_OF_ALL if find_all else _BUDGET
    iterations = iterations if options.max_iterations is None else options.max_iterations
    restarts = restarts if options.max_restarts is None else options.max_restarts
    closest = find_all or options.mode == "closest"
    posture = None if options.posture is None else np.asarray(options.posture, dtype=np.float64)
    seconds = math.inf
    if options.max_cpu_seconds is not None:
        seconds = check.number(options.max_cpu_seconds, "max_cpu_seconds", above=0.0)
    return core.IkOptions(
        core.IkTolerance(position, orientation),
        _axes(options.free or (), (*along, *about), options.weights),
        _MODES["closest" if closest else "fastest"],
        posture if closest else None,
        check.number(options.nullspace_gain, "nullspace_gain", at_least=0.0, at_most=1.0),
        None if closest else posture,
        check.integer(iterations, "max_iterations", at_least=1, at_most=_MAX_COUNT),
        check.integer(restarts, "max_restarts", at_least=0, at_most=_MAX_COUNT),
        seconds,
        seed,
    )


@dataclass(frozen=True, eq=False, slots=True)
class IkResult(ShortRepr):
    """One solution, or the closest configuration.

    Attributes:
        q: configuration (joints,) in rad (m for prismatic joints), inside the limits.
        success: whether the status is "converged".
        status: "converged"; "unreachable", the target lies beyond the arm's length, or every
            attempt came to rest away from it; "limits", the same, but with joints pressed against
            limits that keep it away; "budget", the iterations or the CPU time were used up.
        position_error: distance from the target in m, without the axes left free.
        orientation_error: angle from the target in rad, without the axes left free; 0 if the whole
            orientation is free.
        iterations: how many were used, over all restarts.
        limiting_joints: with "limits", the joints at their limits that keep the tip away.
    """

    q: Float64Array
    success: bool
    status: IkStatus
    position_error: float
    orientation_error: float
    iterations: int
    limiting_joints: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class IkBatch(ShortRepr):
    """Solutions of many targets, one row per target; the fields mean what those of IkResult mean.

    Attributes:
        q: (m, joints).
        success: (m,).
        status: (m,).
        position_error: (m,) in m.
        orientation_error: (m,) in rad.
        iterations: (m,).
        limiting_joints: (m, joints), true for such joints.
    """

    q: Float64Array
    success: NDArray[np.bool_]
    status: NDArray[np.str_]
    position_error: Float64Array
    orientation_error: Float64Array
    iterations: NDArray[np.int32]
    limiting_joints: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.q)


@dataclass(frozen=True, eq=False)
class IkSolutions(IkBatch):
    """Distinct configurations for one pose, the one nearest to the posture first.

    Attributes:
        complete: whether there are no others inside the limits, apart from whole turns. A set of
            configurations that a singular pose leaves free has one row.
        reason: "converged"; without a row "unreachable" or "limits", if complete, else "budget".
        resolution: distance in rad of the values of a joint, or of the elbow's angle, by which the
            self-motion of an arm of seven joints was swept; None without a sweep.
    """

    complete: bool
    reason: IkStatus
    resolution: float | None


def one_start(
    chain: core.Chain, q0: ArrayLike | None, posture: ArrayLike | None = None
) -> Float64Array:
    """The configuration that a search starts from: q0, else the posture, else the middle."""
    if q0 is not None:
        return check.array(q0, "q0", shape=(chain.joints,))
    return chain.middle if posture is None else np.asarray(posture)


def many_starts(
    chain: core.Chain, q0: ArrayLike | None, count: int, posture: ArrayLike | None = None
) -> Float64Array:
    """Configurations (count, joints) from as many rows of q0, or from one for all."""
    if q0 is not None and check.rank(q0) == 2:
        return check.array(q0, "q0", shape=(count, chain.joints))
    return np.tile(one_start(chain, q0, posture), (count, 1))


def random_seed(seed: int) -> int:
    if not isinstance(seed, int) and check.rank(seed) > 0:
        raise InvalidInput(
            "seed: expected an integer, the seed of the random number generator, got an array; "
            "pass the configuration to start from as q0"
        )
    return check.integer(seed, "seed", at_least=0, at_most=2**64 - 1)


def one_result(joint_names: tuple[str, ...], answer: Answer) -> IkResult:
    """The core's answer to one target."""
    q, status, position_error, orientation_error, iterations, bits = answer
    barring: tuple[str, ...] = ()
    if bits:
        barring = tuple(name for i, name in enumerate(joint_names) if bits >> i & 1)
    return IkResult(
        q, status == 0, STATUSES[status], position_error, orientation_error, iterations, barring
    )


def batch_of_results(columns: Columns) -> IkBatch:
    """The core's answer to many targets."""
    q, codes, position_errors, orientation_errors, iterations, limiting = columns
    statuses = np.array(STATUSES)[codes]
    return IkBatch(
        q, codes == 0, statuses, position_errors, orientation_errors, iterations, limiting
    )


@cache
def _of_success(
    count: int, joints: int
) -> tuple[NDArray[np.bool_], NDArray[np.str_], NDArray[np.bool_]]:
    """Columns of solutions that all converged: success, status, limiting; read-only."""
    converged = np.full(count, STATUSES[0], dtype=np.array(STATUSES).dtype)
    limiting = np.zeros((count, joints), dtype=np.bool_)
    success = np.ones(count, dtype=np.bool_)
    check.freeze((success, converged, limiting))
    return success, converged, limiting


def solutions(found: Found) -> IkSolutions:
    """The core's answer to all configurations of one target."""
    q, position_errors, orientation_errors, iterations, status, complete, resolution = found
    success, converged, limiting = _of_success(*q.shape)
    made = object.__new__(IkSolutions)  # its own __init__ sets each field of a frozen class slowly
    vars(made).update(
        q=q,
        success=success,
        status=converged,
        position_error=position_errors,
        orientation_error=orientation_errors,
        iterations=iterations,
        limiting_joints=limiting,
        complete=complete,
        reason=STATUSES[status],
        resolution=resolution or None,
    )
    return made


def one_pose(
    position: ArrayLike, orientation: ArrayLike | None
) -> tuple[Float64Array, Float64Array]:
    """A position (3,) and an orientation (4,), or (0,) where it is free."""
    where = check.array(position, "position", shape=(3,))
    if orientation is None:
        return where, _FREE
    return where, check.quaternions(orientation, "orientation", shape=(4,))


def many_poses(
    positions: ArrayLike, orientations: ArrayLike | None
) -> tuple[Float64Array, Float64Array]:
    """Positions (m, 3) and orientations (m, 4), or (0, 4) where they are free."""
    where = check.array(positions, "positions", shape=("m", 3))
    if orientations is None:
        return where, _FREE_ROWS
    return where, check.quaternions(orientations, "orientations", shape=(len(where), 4))


def tolerance(position: float, orientation: float) -> core.IkTolerance:
    """Tolerances in m and rad."""
    return core.IkTolerance(
        check.number(position, "position_tolerance", above=0.0),
        check.number(orientation, "orientation_tolerance", above=0.0),
    )


def free_axes(free: Collection[Axis]) -> core.IkAxes | None:
    """The axes of a path along which each sample's are free, or None if none is."""
    return _axes(free, [math.inf] * len(AXES), None)


def all_axes(free: Collection[Axis]) -> core.IkAxes:
    """The same, given also where none is free: errors are then along each sample's axes."""
    return core.IkAxes([name in free for name in AXES], [math.inf] * len(AXES), np.ones(6))


def checked_options(
    options: IkOptions | None, chain: core.Chain, orientation: ArrayLike | None
) -> IkOptions:
    """The options, if they fit the arm and the target."""
    if options is None:
        return _DEFAULTS
    if not isinstance(options, IkOptions):
        raise InvalidInput(f"options: expected IkOptions, got {options!r}")
    if options.posture is not None:
        check.array(options.posture, "posture", shape=(chain.joints,))
    if orientation is None and set(options.free or ()) >= {"x", "y", "z"}:
        raise InvalidInput(
            "free: expected at least one of 'x', 'y', 'z' not to be free without an orientation"
        )
    return options


def _tolerance(value: ArrayLike, name: str) -> tuple[float, Float64Array]:
    """Bounds on the length of the error and on each axis; one of the two does not bind."""
    if check.rank(value) == 0:
        return check.number(value, name, above=0.0), np.full(3, math.inf)
    return math.inf, _positive(value, name, 3)


def _axes(
    free: Collection[Axis], bounds: Sequence[float], weights: ArrayLike | None
) -> core.IkAxes | None:
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
    return core.IkAxes(
        [name in free for name in AXES],
        bounds,
        np.ones(6) if weights is None else _positive(weights, "weights", 6),
    )


def _positive(value: ArrayLike, name: str, size: int) -> Float64Array:
    result = check.array(value, name, shape=(size,))
    if not (result > 0).all():
        raise InvalidInput(f"{name}: expected numbers > 0, got {result.min()}")
    return result


_DEFAULTS = IkOptions()  # here, as its checks need the functions above
