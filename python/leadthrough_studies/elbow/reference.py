"""A slow search for joints along a path of the tip with the whole arm clear, to compare with.

At every sample it takes configurations from inverse kinematics of many random ones, and others
beside those that it came to, along what the task leaves free. They are the nodes of a roadmap whose
edges lead from sample to sample: no joint leaps, and places in between are on the path and clear.
The search goes on from all that the edges reach from any first configuration. It has nothing of
`Arm.follow` but forward and inverse kinematics and `Arm.is_clear`.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from leadthrough import rotations
from leadthrough.arm import Arm, IkOptions
from leadthrough.check import Float64Array
from leadthrough.motion import PoseTrajectory
from leadthrough.shapes import Scene, Shape

# Random configurations that inverse kinematics starts from at each sample.
_SEEDS = 1500
_MINUTE = 60.0  # s of processor time
_MORE = 4  # times the effort of the search before
# Steps beside each configuration reached, rad.
_BESIDE = np.array([-0.08, -0.03, 0.03, 0.08])
# Configurations nearer than this to each other are one, rad: at first, and by how much more while
# there are too many of a sample.
_CELL, _COARSER = 0.03, 1.3
_WIDEST = 1500  # configurations of a sample
_LEAP = 0.4  # rad that a joint moves along an edge at the most
_PARTS = 4  # of an edge; the places between them are looked at
_ASTRAY = 0.15  # rad that a place may be away from the edge's straight line
# Configurations before it from which the search tries to reach another.
_PARENTS = 6
_EXACT = 1e-5  # m and rad


def searched_for_a_minute(
    arm: Arm,
    tip: PoseTrajectory,
    obstacles: tuple[Shape, ...],
    *,
    margin: float,
    free: tuple[Literal["rz"], ...],
) -> Roadmap:
    """The first search that finds a way; else the one that a minute of processor time ends with.

    Each search has more effort than the one before, and none is broken off.

    Args:
        arm: the arm.
        tip: the path.
        obstacles: to keep clear of.
        margin: distance to keep in m.
        free: axes of the tip's poses left free.
    """
    effort, begin = 1, time.process_time()
    while True:
        roadmap = Roadmap(arm, tip, obstacles, margin, free, effort)
        if roadmap.way() is not None or time.process_time() - begin > _MINUTE:
            return roadmap
        effort *= _MORE


@dataclass(eq=False)
class Roadmap:
    """The search along one path.

    Attributes:
        arm: the arm.
        tip: the path.
        obstacles: to keep clear of.
        margin: distance to keep in m.
        free: axes of the tip's poses left free.
        effort: how many times the usual number of configurations are looked at.
        reached: configurations (m, joints) of each sample that edges lead to.
        parents: index (m,) of each one's predecessor at the sample before.
    """

    arm: Arm
    tip: PoseTrajectory
    obstacles: tuple[Shape, ...]
    margin: float
    free: tuple[Literal["rz"], ...]
    effort: int = 1
    reached: list[Float64Array] = field(default_factory=list)
    parents: list[NDArray[np.int64]] = field(default_factory=list)

    def way(self) -> Float64Array | None:
        """A configuration for each sample, (n, joints); None if the edges end before the last."""
        self.reached = [_thinned(self._clear(self._settled(0.0, self._random())), self.effort)]
        self.parents = [np.full(len(self.reached[0]), -1)]
        for sample in range(1, len(self.tip)):
            if not len(self.reached[-1]):
                return None
            self._go_on(sample)
        if not self.arrived:
            return None
        at, rows = 0, []
        for nodes, parents in zip(self.reached[::-1], self.parents[::-1], strict=True):
            rows.append(nodes[at])
            at = int(parents[at])
        return np.array(rows[::-1])

    @property
    def arrived(self) -> bool:
        """Whether edges lead to the last sample."""
        return self.last == len(self.tip) - 1

    @property
    def last(self) -> int:
        """The last sample that edges lead to, -1 if there is no clear configuration at all."""
        return sum(1 for nodes in self.reached if len(nodes)) - 1

    def _go_on(self, sample: int) -> None:
        before = self.reached[-1]
        seeds = np.vstack([before, *self._beside(before)])
        nodes = self._settled(float(sample), seeds)
        nodes = np.vstack([nodes, self._settled(float(sample), self._random())])
        nodes = _thinned(self._clear(nodes), self.effort)
        parents = self._connected(sample, before, nodes)
        self.reached.append(nodes[parents >= 0])
        self.parents.append(parents[parents >= 0])

    def _random(self) -> Float64Array:
        rng = np.random.default_rng(len(self.reached))
        low, high = (np.clip(ends, -np.pi, np.pi) for ends in self._limits())
        return rng.uniform(low, high, (self.effort * _SEEDS, len(low)))

    def _limits(self) -> tuple[Float64Array, Float64Array]:
        return self.arm.limits.lower, self.arm.limits.upper

    def _beside(self, q: Float64Array) -> list[Float64Array]:
        """Steps in the joints' space that move the tip only as the task leaves it free."""
        jacobians = self.arm.jacobian(q)
        if self.free:  # the tool's own axis, pointing along it
            axis = rotations.to_matrix(self.arm.forward_kinematics(q)[1])[:, :, 2]
            along = np.einsum("mi,mij->mj", axis, jacobians[:, 3:])
            turns = jacobians[:, 3:] - axis[:, :, None] * along[:, None]
            jacobians = np.concatenate([jacobians[:, :3], turns], axis=1)
        directions = np.linalg.svd(jacobians)[2][:, -1]
        directions /= np.abs(directions).max(axis=1, keepdims=True)
        low, high = self._limits()
        return [np.clip(q + step * directions, low, high) for step in _BESIDE]

    def _settled(self, sample: float, seeds: Float64Array) -> Float64Array:
        """Those of the seeds that inverse kinematics brings to a sample, brought there."""
        found, success = self._brought(np.full(len(seeds), sample), seeds)
        return found[success]

    def _brought(
        self, samples: Float64Array, seeds: Float64Array
    ) -> tuple[Float64Array, NDArray[np.bool_]]:
        times = np.interp(samples, np.arange(len(self.tip)), self.tip.times)
        columns = [np.interp(times, self.tip.times, column) for column in self.tip.positions.T]
        found = self.arm.inverse_kinematics_batch(
            np.column_stack(columns),
            rotations.interpolate(self.tip.times, self.tip.orientations, times),
            q0=seeds,
            options=IkOptions(
                free=self.free,
                position_tolerance=_EXACT,
                orientation_tolerance=_EXACT,
                max_iterations=60,
                max_restarts=0,
            ),
        )
        return found.q, found.success

    def _clear(self, q: Float64Array) -> Float64Array:
        return q[self._are_clear(q)]

    def _are_clear(self, q: Float64Array) -> NDArray[np.bool_]:
        if not len(q):
            return np.zeros(0, dtype=bool)
        return np.asarray(self.arm.is_clear(q, Scene(self.obstacles, self.margin)))

    def _connected(
        self, sample: int, before: Float64Array, nodes: Float64Array
    ) -> NDArray[np.int64]:
        """The parent of each node, the nearest that an edge leads from; -1 for none."""
        parents = np.full(len(nodes), -1)
        if not len(nodes):
            return parents
        count = min(_PARENTS, len(before))
        away, nearest = KDTree(before).query(nodes, k=np.arange(1, count + 1), p=np.inf)
        for rank in range(count):
            asked = np.flatnonzero((parents < 0) & (away[:, rank] < _LEAP))
            holds = self._hold(sample, before[nearest[asked, rank]], nodes[asked])
            parents[asked[holds]] = nearest[asked[holds], rank]
        return parents

    def _hold(self, sample: int, a: Float64Array, b: Float64Array) -> NDArray[np.bool_]:
        """Whether places on the path between configurations of two samples are clear."""
        open_ = np.arange(len(a))
        for part in range(1, _PARTS):
            share = part / _PARTS
            straight = a[open_] + share * (b[open_] - a[open_])
            q, success = self._brought(np.full(len(open_), sample - 1 + share), straight)
            near = np.abs(q - straight).max(axis=1, initial=0.0) < _ASTRAY
            kept = np.flatnonzero(success & near)
            open_ = open_[kept[self._are_clear(q[kept])]]
        holds = np.zeros(len(a), dtype=bool)
        holds[open_] = True
        return holds


def _thinned(q: Float64Array, effort: int) -> Float64Array:
    """One configuration for each cell, the first."""
    cell = _CELL / effort
    while True:
        cells = np.round(q / cell).astype(np.int64)
        kept = np.sort(np.unique(cells, axis=0, return_index=True)[1])
        if len(kept) <= effort * _WIDEST:
            return q[kept]
        cell *= _COARSER
