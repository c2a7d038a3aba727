"""Queries of a skill: checked against its demonstrations, sampled in time, many at once."""

from __future__ import annotations

import math
import sys
import threading
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import wraps
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, sanity
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.models.protocol import Generator, check_skill
from leadthrough.motion import JointTrajectory, Motion, MotionT, PoseTrajectory, Target, Trajectory
from leadthrough.shapes import Shape, check_shapes

_Generate = TypeVar("_Generate", bound=Callable[..., Any])
_Value = TypeVar("_Value")
_Result = TypeVar("_Result")
# More samples than this come from a wrong unit of dt or of the duration.
MAX_SAMPLES = 10_000_000
# A duration of n steps of dt has n steps, whatever the quotient rounds to.
_ROUNDING = 1e-9
# Shorter steps have few digits left, and times would not rise.
_MIN_STEP = sys.float_info.min  # s
# Covariances of more times would take gigabytes.
_MAX_TIMES = 1_000_000
_MAX_THREADS = 256


Via = Sequence[tuple[float, ArrayLike]]


@dataclass(frozen=True, eq=False)
class CheckedQuery:
    """Parts of a query as `generate` takes them; None and () are as demonstrated."""

    start: Target | None = None
    goal: Target | None = None
    duration: float | None = None
    dt: float = 0.01
    obstacles: Sequence[Shape] = ()
    via: Via = ()
    start_velocity: ArrayLike | None = None
    final_velocity: ArrayLike | None = None
    limits: tuple[ArrayLike, ArrayLike] | None = None

    def __post_init__(self) -> None:
        vars(self)["dt"] = check.number(self.dt, "dt", above=0.0)
        if self.duration is not None:
            vars(self)["duration"] = check.number(self.duration, "duration", above=0.0)
        object.__setattr__(self, "obstacles", check_shapes(self.obstacles))
        check.instance(self.via, "via", Sequence, "a sequence of (phase, point)")

    def given(self) -> dict[str, Any]:
        """The parts that differ from the defaults, by name."""
        return {
            name: value
            for name, value in vars(self).items()
            if value is not None and not (name in ("obstacles", "via") and len(value) == 0)
        }

    def end(self, nominal: float) -> float:
        """The duration, s, by default the nominal one."""
        return nominal if self.duration is None else self.duration


def checked_query(generate: _Generate) -> _Generate:
    """The method `generate` of a skill, after a check that rejects implausible queries."""

    @wraps(generate)
    def checked(self: Any, **query: Any) -> Any:
        places = [(name, query[name]) for name in ("start", "goal") if query.get(name) is not None]
        via, shapes = query.get("via"), query.get("obstacles")
        pairs = via if isinstance(via, Sequence) else ()
        places += [("via", each[-1]) for each in pairs if isinstance(each, tuple | list) and each]
        if places or (isinstance(shapes, Sequence) and len(shapes) > 0):
            demonstrated = self._own_motion
            for name, place in places:
                check_place(place, demonstrated, name)
            if isinstance(demonstrated, Trajectory | PoseTrajectory):
                known = [shape for shape in shapes or () if isinstance(shape, Shape)]
                sanity.obstacles(known, demonstrated.positions)
        return generate(self, **query)

    return checked  # type: ignore[return-value]  # of the same signature, as wraps states


def check_place(end: Any, demonstrated: Motion | None, name: str) -> None:
    """Refuses a start, goal or via point that is in another unit than a motion, if there is one."""
    if demonstrated is None:
        return
    is_pose = isinstance(demonstrated, PoseTrajectory)
    oriented = is_pose and isinstance(end, tuple | list) and len(end) == 2
    if is_pose and _numbers(end, 7) is not None:
        raise InvalidInput(
            f"{name}: expected a position (3,), which keeps the demonstrated orientation, or "
            "(position (3,), orientation (4,) w, x, y, z), got seven numbers"
        )
    position = _numbers(end[0] if oriented else end, demonstrated.positions.shape[1])
    if position is not None:
        compare = sanity.joints if isinstance(demonstrated, JointTrajectory) else sanity.position
        compare(position, demonstrated.positions, name)
        if is_pose and name == "goal":
            sanity.stretched(position, demonstrated.positions, name)
    quaternion = _numbers(end[1], 4) if oriented else None
    if quaternion is not None and isinstance(demonstrated, PoseTrajectory):
        own = demonstrated.orientations[0 if name == "start" else -1]
        sanity.orientation(quaternion, demonstrated.orientations, own, name)


def ends_apart(query: CheckedQuery, motion: Motion | None) -> float:
    """Of a query's start and goal from a motion's, in its extents and rad; 0 for malformed ones."""
    apart = 0.0
    ends: list[tuple[Any, int]] = [(query.start, 0), (query.goal, -1)]
    for value, row in ends:
        if value is None or motion is None:
            continue
        posed = isinstance(motion, PoseTrajectory) and isinstance(value, tuple | list)
        oriented = posed and len(value) == 2
        position = _numbers(value[0] if oriented else value, motion.positions.shape[1])
        if position is not None:
            extent = float(np.linalg.norm(np.ptp(motion.positions, axis=0))) or 1.0
            apart += float(np.linalg.norm(position - motion.positions[row])) / extent
        quaternion = _numbers(value[1], 4) if oriented else None
        if quaternion is not None and isinstance(motion, PoseTrajectory):
            own = abs(float(quaternion @ motion.orientations[row]))
            apart += 2.0 * math.acos(min(own / (float(np.linalg.norm(quaternion)) or 1.0), 1.0))
    return apart


def is_free(points: Float64Array, obstacles: Sequence[Shape]) -> bool:
    """Whether points (n, d) keep out of obstacles."""
    from leadthrough.planning import detours

    return detours.is_free(points, obstacles)


def _numbers(value: Any, count: int) -> Float64Array | None:
    """The finite numbers (count,) of a position or quaternion; None if it is malformed."""
    try:
        numbers = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, RuntimeError, OverflowError):
        return None
    if numbers.shape != (count,) or not all(map(math.isfinite, numbers.tolist())):
        return None
    return numbers


def even_times(duration: float, dt: float) -> Float64Array:
    """Evenly spaced times (n,) from 0 to a duration, s."""
    return duration * even_phases(duration, dt)


def even_phases(duration: float, dt: float) -> Float64Array:
    """Those times as fractions (n,) of the duration, from 0 to 1; arguments as in `even_times`."""
    if not duration / dt <= MAX_SAMPLES:
        raise InvalidInput(
            f"dt: expected at most {MAX_SAMPLES:.0e} samples in {duration:.6g} s, got steps of "
            f"{dt} s; check the units of dt and duration"
        )
    sanity.step(dt, duration)
    steps = max(math.ceil(duration / dt - _ROUNDING), 1)
    if duration / steps < _MIN_STEP:
        raise InvalidInput(
            f"duration: expected at least {_MIN_STEP:.3g} s a step, got {duration} s in {steps}"
        )
    return np.arange(steps + 1) / steps


def checked_limits(limits: Any, shape: tuple[int, ...]) -> Float64Array:  # Any: checked here
    """Lower and upper limits (2, d) of points of a shape (d,)."""
    if not isinstance(limits, Sequence) or len(limits) != 2:
        raise InvalidInput(f"limits: expected a pair (lower, upper), got {limits!r}")
    lower, upper = (check.array(side, "limits", shape=shape) for side in limits)
    if not (lower < upper).all():
        raise InvalidInput(f"limits: expected lower < upper, got {lower} and {upper}")
    return np.stack([lower, upper])


def asked_times(times: ArrayLike, name: str, *, at_least: int = 1) -> Float64Array:
    """Times (n,) of a distribution, s, neither too few nor too many."""
    checked = check.array(times, name, shape=("n",))
    if not at_least <= len(checked) <= _MAX_TIMES:
        raise check.refused(name, f"{at_least} to {_MAX_TIMES:,} times", f"{len(checked):,}")
    return checked


def generate_all(
    skill: Generator[MotionT], queries: Sequence[Mapping[str, Any]], *, threads: int = 1
) -> list[MotionT]:
    """The motion of a skill for each of several queries.

    Threads help where the compiled core computes, which lets other threads run: past obstacles and
    along many samples. Short plans without obstacles are mostly Python.

    Args:
        skill: any skill.
        queries: the keyword arguments of `generate`, for each motion.
        threads: number of threads, 1 to 256; does not change the answers.

    Raises:
        UnsupportedQuery: for a part of a query that the skill does not support.
        NoPath: if obstacles leave no path. The first query without an answer raises.
    """
    check_skill(skill)
    check.instance(queries, "queries", Sequence, "a sequence")
    for i, query in enumerate(queries):
        if not isinstance(query, Mapping):
            raise InvalidInput(
                f"queries[{i}]: expected the arguments of generate by name, as in "
                f"{{'goal': (0.4, 0.1, 0.2)}}, got {type(query).__name__}"
            )
    return mapped(lambda query: skill.generate(**query), queries, threads)


def checked_threads(threads: int) -> int:
    return check.integer(threads, "threads", at_least=1, at_most=_MAX_THREADS)


def mapped(
    function: Callable[[_Value], _Result], values: Iterable[_Value], threads: int
) -> list[_Result]:
    """The function's results, in the order of the values, on that many threads."""
    count = checked_threads(threads)
    every = list(values)
    if count == 1:
        return [function(value) for value in every]
    runs = _runs(every, count)
    pool, is_over = ThreadPoolExecutor(count), threading.Event()
    try:
        done = pool.map(lambda run: [function(each) for each in run if not is_over.is_set()], runs)
        return [result for run in done for result in run]
    finally:  # Ctrl-C waits for no other thread
        is_over.set()
        pool.shutdown(wait=False, cancel_futures=True)


def _runs(values: Sequence[_Value], threads: int) -> list[Sequence[_Value]]:
    """The values in consecutive runs: a task costs some tens of microseconds."""
    runs = []
    first = 0
    while first < len(values):
        size = max(1, (len(values) - first) // (2 * threads))
        runs.append(values[first : first + size])
        first += size
    return runs
