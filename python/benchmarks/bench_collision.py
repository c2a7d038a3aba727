"""Collision of the whole arm against Pinocchio with coal, on the same shapes, robot by robot.

The peer measures every pair of shapes, as its computeDistances does, and its answer is the least.
Both are asked for the same pairs of bodies, in the same random configurations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from bench_arm import Judge
from frame import Benchmark

import leadthrough as lt
from leadthrough.arm.robots import find_robot

TOLERANCE = 1e-5  # m; coal's own is 1e-6
Distances = Callable[[Any], Any]


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows of every robot."""
    count = 200 if quick else 1000
    boxes = _boxes()
    for name in ("panda",) if quick else ("panda", "ur3", "tiago"):
        arm = lt.Arm.load(name)
        q = _configurations(arm, count)
        peers = Peer(name, arm)
        ways = {
            "5 boxes": (lambda q, arm=arm: arm.distance(q, boxes), peers.to_boxes(boxes)),
            "itself": (arm.self_distance, peers.to_itself()),
        }
        for what, (ours, peer) in ways.items():
            yield Benchmark(
                f"{name}: distance to {what}, {count} configurations",
                ours=lambda ours=ours, q=q: ours(q),
                peer=lambda peer=peer, q=q: peer(q),
                peer_name="coal",
                error=_error,
                tolerance=TOLERANCE,
            )


class Peer:
    """Pinocchio's geometry of a robot, with the pairs of bodies that ours checks."""

    def __init__(self, name: str, arm: lt.Arm) -> None:
        self.urdf = find_robot(name) / f"{name}.urdf"
        self.judge = Judge(arm, self.urdf)
        self.arm = arm

    def to_itself(self) -> Distances:
        geometry = self._geometry()
        shapes = _by_link(geometry)
        for a, b in self.arm.collision_pairs.checked:
            _add_pairs(geometry, shapes[a], shapes[b])
        return self._least(geometry)

    def to_boxes(self, boxes: list[lt.Box]) -> Distances:
        geometry = self._geometry()
        moving = [i for i, shape in enumerate(geometry.geometryObjects) if shape.parentJoint > 0]
        for i, box in enumerate(boxes):
            w, x, y, z = box.orientation
            pose = pin.SE3(pin.Quaternion(w, x, y, z).matrix(), np.array(box.position))
            shape = pin.GeometryObject(f"box {i}", 0, pose, coal.Box(*box.size))
            _add_pairs(geometry, moving, [geometry.addGeometryObject(shape)])
        return self._least(geometry)

    def _geometry(self) -> Any:
        return pin.buildGeomFromUrdf(self.judge.model, str(self.urdf), pin.GeometryType.COLLISION)

    def _least(self, geometry: Any) -> Distances:
        data = geometry.createData()
        model, model_data = self.judge.model, self.judge.data

        def least(q: Any) -> Any:
            found = np.empty(len(q))
            for i, row in enumerate(q):
                full = self.judge.configuration(row)
                nearest = pin.computeDistances(model, model_data, geometry, data, full)
                found[i] = data.distanceResults[nearest].min_distance
            return found

        return least


def _by_link(geometry: Any) -> dict[str, list[int]]:
    shapes: dict[str, list[int]] = {}
    for i, shape in enumerate(geometry.geometryObjects):
        shapes.setdefault(shape.name.rpartition("_")[0], []).append(i)
    return shapes


def _add_pairs(geometry: Any, first: list[int], second: list[int]) -> None:
    for a in first:
        for b in second:
            geometry.addCollisionPair(pin.CollisionPair(a, b))


def _error(ours: Any, peers: Any) -> float:
    """Of the distances where nothing overlaps; coal's depth is not always the least."""
    apart = (ours > TOLERANCE) | (peers > TOLERANCE)
    return float(np.abs(ours - peers)[apart].max())


def _configurations(arm: lt.Arm, count: int) -> Any:
    lower = np.maximum(arm.limits.lower, -np.pi)
    upper = np.minimum(arm.limits.upper, np.pi)
    return np.random.default_rng(1).uniform(lower, upper, (count, len(lower)))


def _boxes() -> list[lt.Box]:
    """Around the arm, out of the way of its first links."""
    rng = np.random.default_rng(2)
    turns = rng.normal(size=(5, 4))
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    around = 0.4 * np.pi * np.arange(5)
    places = np.column_stack([0.6 * np.cos(around), 0.6 * np.sin(around), rng.uniform(0, 0.8, 5)])
    return [
        lt.Box(rng.uniform(0.05, 0.3, 3), place, turn)
        for place, turn in zip(places, turns, strict=True)
    ]
