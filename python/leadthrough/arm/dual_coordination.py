"""Two arms with a task each: both keep their paths, and one waits where they would meet.

The progress of the left arm is one axis of a plane, that of the right arm the other. A path through
the plane that never turns back, and keeps out of the configurations in which the arms or the
obstacles are too near, is a schedule; the quickest one is taken, with a price on every stop.

Source: O'Donnell and Lozano-Perez 1989.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from leadthrough import check
from leadthrough.arm.collision import ClosestPair
from leadthrough.arm.dual_arm import DualArm
from leadthrough.arm.dual_following import SIDES
from leadthrough.arm.following import timed
from leadthrough.arm.tip_path import CollisionTest
from leadthrough.check import Float64Array, InvalidInput, NoPath, ShortRepr
from leadthrough.motion import JointTrajectory, in_order, moved_events
from leadthrough.shapes import Scene, SceneLike, as_scene

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

# Knots of either arm's motion, where it may stop.
_KNOTS = 96
# Price of a change between moving and waiting, in steps from knot to knot.
_CHANGE = 2.0
_COARSE = 0.01  # rad or m between a chord of the motions and a spline
# Schedules that are tried; steps of one that are not clear are closed to the next.
_MAX_SCHEDULES = 60
_MAX_ROWS = 1_000_000
_CHECKED = 1e-3  # m, to which the bodies of a wait are searched
# Knots that the left and the right arm advance in a step.
_MOVES = np.array([[1, 1], [1, 0], [0, 1]])

Knots = NDArray[np.int_]


@dataclass(frozen=True, eq=False)
class Wait(ShortRepr):
    """A stop of one arm until the other has passed.

    Attributes:
        side: "left" or "right", the arm that gives way.
        begin: of the stop, s of the coordinated motion.
        end: of the stop, s.
        q: configuration (joints,) of that arm there.
        bodies: those that would be the first to come too near without the stop.
    """

    side: str
    begin: float
    end: float
    q: Float64Array
    bodies: tuple[str, str]

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", check.frozen(self.q, "q", shape=("joints",)))


@dataclass(frozen=True, eq=False)
class CoordinatedMotion(ShortRepr):
    """Two motions as one, clear of obstacles and of each other.

    Attributes:
        joints: of both arms, the left arm's first, at evenly spaced times until they are slowed.
        waits: the stops, in order; none if the arms never meet.
    """

    joints: JointTrajectory
    waits: tuple[Wait, ...]


def coordinate(
    pair: DualArm, left: JointTrajectory, right: JointTrajectory, *, scene: SceneLike = ()
) -> CoordinatedMotion:
    """Separate tasks of two arms as one motion: each keeps its path, and one waits if needed.

    Both begin together. The quickest schedule is taken that keeps the arms clear of each other,
    with few stops. Retime its `joints` as a whole: that stops no arm longer than it has to.

    Args:
        pair: the two arms.
        left: joints of the left arm, two dense samples or more: a cubic spline goes through.
        right: joints of the right arm, likewise. The times need not be the same.
        scene: obstacles that both arms keep clear of, with the margin between the arms.

    Raises:
        NoPath: if no waiting helps, as where one arm ends in the other's way; with the bodies.
        InvalidRobot: if a robot has no collision geometry.
        LimitsInfeasible: if a joint has to move whose limits are zero.

    Source: O'Donnell and Lozano-Perez 1989.
    """
    if not isinstance(pair, DualArm):
        raise check.refused("pair", "a DualArm", repr(pair))
    motions = (
        in_order(left, pair.left.joint_names, "left"),
        in_order(right, pair.right.joint_names, "right"),
    )
    return _Coordination(pair, motions, as_scene(scene)).found()


class _Coordination:
    """The motions of the left and the right arm, and what both keep clear of."""

    def __init__(
        self, pair: DualArm, motions: tuple[JointTrajectory, JointTrajectory], scene: Scene
    ) -> None:
        self._pair, self._motions = pair, motions
        # Times (n,) of either motion from its own beginning, and those (k,) of possible stops, s.
        self._own_times = [motion.times - motion.times[0] for motion in motions]
        self._knots = np.linspace(0.0, max(times[-1] for times in self._own_times), _KNOTS)
        sides = zip(SIDES, self._own_times, motions, strict=True)
        self._paths = [_spline(name, times, motion.positions) for name, times, motion in sides]
        self._test = CollisionTest.of(pair._collision, scene)

    def found(self) -> CoordinatedMotion:
        """The quickest motion; NoPath if there is none."""
        open_ = self._open()
        for _ in range(_MAX_SCHEDULES):
            if (schedule := self._schedule(open_)) is None:
                break
            clock, progress = self._progress(schedule)
            clear = self._test.clear_edges(self._joined(progress))
            if all(clear):
                return self._timed(schedule, clock, progress)
            for step in np.unique(np.flatnonzero(~np.array(clear)) // self._rows_in_step):
                (i, j), ahead = schedule[step], schedule[step + 1] - schedule[step]
                open_[int(np.argmax((ahead == _MOVES).all(axis=1))), i, j] = False
        raise NoPath(self._refusal(), reason="blocked")

    def _open(self) -> NDArray[np.bool_]:
        """Steps (3, k, k) by `_MOVES` from pairs of knots to pairs that are clear."""
        count = len(self._knots)
        both = np.stack(np.meshgrid(self._knots, self._knots, indexing="ij"), axis=-1)
        pairs = self._joined(both.reshape(-1, 2))
        clear = np.zeros((count + 1, count + 1), dtype=bool)
        clear[:-1, :-1] = np.reshape(self._test.clear_rows(pairs), (count, count))
        ends = [clear[a : a + count, b : b + count] for a, b in _MOVES]
        return np.stack([clear[:-1, :-1] & end for end in ends])

    def _schedule(self, open_: NDArray[np.bool_]) -> Knots | None:
        """Pairs of knots (m, 2) of the cheapest way from both beginnings to both ends."""
        from scipy.sparse import csr_array
        from scipy.sparse.csgraph import dijkstra

        count = len(self._knots)
        node = np.arange(3 * count * count).reshape(3, count, count)  # by the step that led there
        columns = []
        for move, (a, b) in enumerate(_MOVES):
            i, j = np.nonzero(open_[move])
            for before in range(3):
                cost = np.full(len(i), 1.0 + _CHANGE * (before != move))
                columns.append((cost, node[before, i, j], node[move, i + a, j + b]))
        cost, begin, end = (np.concatenate(part) for part in zip(*columns, strict=True))
        graph = csr_array((cost, (begin, end)), shape=(node.size, node.size))
        costs, before = dijkstra(graph, indices=node[0, 0, 0], return_predecessors=True)
        at = int(min(node[:, -1, -1], key=lambda last: costs[last]))
        if not np.isfinite(costs[at]):
            return None
        way = [at]
        while way[-1] != node[0, 0, 0]:
            way.append(int(before[way[-1]]))
        return np.column_stack(np.unravel_index(way[::-1], node.shape)[1:])

    @cached_property
    def _rows_in_step(self) -> int:
        """Rows from knot to knot, as dense as the samples of either motion."""
        between = min(float(np.median(np.diff(times))) for times in self._own_times)
        rows = math.ceil(float(self._knots[1]) / between)
        if rows * _KNOTS > _MAX_ROWS:
            raise InvalidInput(
                f"left, right: expected at most {_MAX_ROWS:,} samples, got one every "
                f"{between:.3g} s in {self._knots[-1]:.6g} s; sample both motions at one rate"
            )
        return rows

    def _progress(self, schedule: Knots) -> tuple[Float64Array, Float64Array]:
        """Evenly spaced times (r,), and what time (r, 2) of its motion either arm has got to."""
        steps = len(schedule) - 1
        end = steps * float(self._knots[1])
        rows = np.linspace(0.0, end, steps * self._rows_in_step + 1)
        at = np.linspace(0.0, end, steps + 1)
        return rows, np.column_stack([np.interp(rows, at, self._knots[k]) for k in schedule.T])

    def _joined(self, progress: Float64Array) -> Float64Array:
        """Joints (r, joints) of both arms at times (r, 2) of their motions."""
        rows = [
            path(np.minimum(at, times[-1]))
            for at, times, path in zip(progress.T, self._own_times, self._paths, strict=True)
        ]
        return np.ascontiguousarray(np.hstack(rows))

    def _timed(
        self, schedule: Knots, clock: Float64Array, progress: Float64Array
    ) -> CoordinatedMotion:
        events = [
            event
            for motion, times in zip(self._motions, progress.T, strict=True)
            for event in moved_events(motion.events, motion.times[0] + times, clock)
        ]
        events.sort(key=lambda event: event.time)
        q = self._joined(progress)
        joints = timed(self._pair.limits, JointTrajectory(clock, q, events=events), q, "slow")
        return CoordinatedMotion(joints, self._waits(schedule, joints.times[:: self._rows_in_step]))

    def _waits(self, schedule: Knots, times: Float64Array) -> tuple[Wait, ...]:
        """The stops of arms that have not ended."""
        waits = []
        for k, name in enumerate(SIDES):
            progress = self._knots[schedule[:, k]]
            stands = (np.diff(progress) == 0.0) & (progress[:-1] < self._own_times[k][-1])
            edges = np.flatnonzero(np.diff(stands, prepend=False, append=False))
            for begin, end in edges.reshape(-1, 2):
                q = self._paths[k](progress[begin])
                bodies = self._meeting(self._knots[schedule[begin]]).bodies
                waits.append(Wait(name, float(times[begin]), float(times[end]), q, bodies))
        return tuple(sorted(waits, key=lambda wait: wait.begin))

    def _meeting(self, begin: Float64Array) -> ClosestPair:
        """The first bodies too near if both arms went on from times (2,) of their motions."""
        ahead = [times - at for times, at in zip(self._own_times, begin, strict=True)]
        clock = np.unique(np.concatenate([[0.0], *ahead]).clip(0.0))
        q = self._joined(begin + clock[:, None])
        report = self._pair.check(q, self._test.scene, tolerance=_CHECKED)
        pair = report.first or report.closest
        assert pair is not None
        return pair

    def _refusal(self) -> str:
        pair = self._meeting(np.zeros(2))
        near = f"come {1e3 * pair.distance:.1f} mm near" if pair.distance > 0.0 else "touch"
        return (
            f"no waiting of either arm keeps both clear: without any, {' and '.join(pair.bodies)} "
            f"{near}; change a path, or where it ends"
        )


def _spline(name: str, times: Float64Array, q: Float64Array) -> CubicSpline:
    """A spline through the samples: chords would make the joint path of both arms rough."""
    from scipy.interpolate import CubicSpline

    if len(times) == 1:
        raise check.refused(name, "two samples or more", "one")
    path = CubicSpline(times, q)
    off = path(0.5 * (times[1:] + times[:-1])) - 0.5 * (q[1:] + q[:-1])
    if (worst := float(np.abs(off).max())) > _COARSE:
        raise InvalidInput(
            f"{name}: expected samples so dense that a cubic spline through them stays within "
            f"{_COARSE:g} rad of the straight motion, got {worst:.2g}; take more"
        )
    return path
