"""Collision of the whole arm against Pinocchio with coal, on the same shapes, robot by robot.

The peer computes the distance of every pair of shapes with computeDistances and takes the smallest.
Both check the same pairs of bodies in the same random configurations.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import coal
import numpy as np
import pinocchio as pin
from frame import Benchmark
from judge import Judge, random_configurations, urdf_of

import leadthrough as lt

TOLERANCE = 1e-5  # m; coal's own is 1e-6
CELL = 0.01  # m
MARGIN = 0.005  # m, to obstacles
EDGE, LOOKED = 0.67, 0.01  # rad
Distances = Callable[[Any], Any]


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows for every robot."""
    count = 200 if quick else 1000
    boxes = _boxes()
    for name in ("panda",) if quick else ("panda", "ur3", "tiago"):
        arm = lt.Arm.load(name)
        q = random_configurations(arm, count, seed=1)
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
    yield _edges(40 if quick else 400)
    yield _to_points(20 if quick else 200)


def _edges(count: int) -> Benchmark:
    """A clear motion of straight edges: certified by us, looked at every 0.01 rad by the peer."""
    arm, boxes = lt.Arm.load("panda"), _boxes()
    scene, joints = lt.Scene(boxes, MARGIN), len(arm.joint_names)
    rng = np.random.default_rng(4)
    q = next(q for q in random_configurations(arm, 100, seed=1) if arm.is_clear(q, scene))
    path = [q]
    while len(path) <= count:
        step = rng.normal(size=joints)
        end = path[-1] + EDGE * step / np.linalg.norm(step)
        inside = ((end >= arm.limits.lower) & (end <= arm.limits.upper)).all()
        if inside and arm.is_clear(lt.JointTrajectory([0.0, 1.0], [path[-1], end]), scene):
            path.append(end)
    motion = lt.JointTrajectory(np.arange(len(path)), path)
    fine = np.linspace(0.0, count, int(count * EDGE / LOOKED) + 1)
    looked = np.column_stack([np.interp(fine, motion.times, x) for x in motion.positions.T])
    collides = Peer("panda", arm).collides(boxes)
    return Benchmark(
        f"panda: {count} edges of {EDGE} rad certified clear of 5 boxes and of itself",
        ours=lambda: arm.is_clear(motion, scene),
        peer=lambda: collides(looked),
        peer_name="coal, every 0.01 rad",
        error=lambda clear, touching: float(not clear or touching),
        tolerance=0.0,
    )


def _to_points(count: int) -> Benchmark:
    """Ten thousand points against an octree, whose cubes of 1 cm the balls just fit into."""
    arm = lt.Arm.load("panda")
    q = random_configurations(arm, count, seed=1)
    # Each in the middle of a cube: a wall, and what lies on a table.
    cells = np.random.default_rng(3).integers((-60, -60, 0), (60, 60, 80), (10_000, 3))
    cells[::2, 0], cells[1::2, 2] = 55, cells[1::2, 2] // 16
    points = CELL * (np.unique(cells, axis=0) + 0.5)
    cloud, peer = lt.PointCloud(points, 0.5 * CELL), Peer("panda", arm).to_points(points)
    return Benchmark(
        f"panda: distance to {len(points)} points, {count} configurations",
        ours=lambda: arm.distance(q, [cloud]),
        peer=lambda: peer(q),
        peer_name="coal's octree",
        error=_error,
        tolerance=0.5 * (np.sqrt(3.0) - 1.0) * CELL + TOLERANCE,  # from a ball to a cube's corner
    )


class Peer:
    """Pinocchio's geometry of a robot, with the pairs of bodies that our arm checks."""

    def __init__(self, name: str, arm: lt.Arm) -> None:
        self.urdf = urdf_of(name)
        self.judge = Judge(arm, self.urdf)
        self.arm = arm

    def to_itself(self) -> Distances:
        """The function of joint positions (m, n) that returns the distances (m,) to itself."""
        geometry = self._geometry()
        shapes = _by_link(geometry)
        for a, b in self.arm.collision_pairs.checked:
            _add_pairs(geometry, shapes[a], shapes[b])
        return self._least(geometry)

    def to_boxes(self, boxes: list[lt.Box]) -> Distances:
        """The function of joint positions (m, n) that returns the distances (m,) to boxes."""
        geometry = self._geometry()
        moving = [i for i, shape in enumerate(geometry.geometryObjects) if shape.parentJoint > 0]
        self._add_boxes(geometry, moving, boxes)
        return self._least(geometry)

    def collides(self, boxes: list[lt.Box]) -> Callable[[Any], bool]:
        """The function of joint positions (m, n): whether boxes or the arm come within the margin.

        It stops at the first pair that does.
        """
        geometry = self._geometry()
        shapes = _by_link(geometry)
        moving = [i for i, shape in enumerate(geometry.geometryObjects) if shape.parentJoint > 0]
        for a, b in self.arm.collision_pairs.checked:
            _add_pairs(geometry, shapes[a], shapes[b])
        own = len(geometry.collisionPairs)
        self._add_boxes(geometry, moving, boxes)
        data = geometry.createData()
        for request in list(data.collisionRequests)[own:]:
            request.security_margin = MARGIN
        model, model_data = self.judge.model, self.judge.data

        def collides(q: Any) -> bool:
            places = map(self.judge.configuration, q)
            return any(
                pin.computeCollisions(model, model_data, geometry, data, full, True)
                for full in places
            )

        return collides

    def to_points(self, points: np.ndarray) -> Distances:
        """The function of joint positions (m, n) that returns the distances (m,) to cubes."""
        geometry = self._geometry()
        moving = [i for i, shape in enumerate(geometry.geometryObjects) if shape.parentJoint > 0]
        cubes = coal.makeOctree(points, CELL)
        shape = pin.GeometryObject("cubes", 0, pin.SE3.Identity(), cubes)
        _add_pairs(geometry, moving, [geometry.addGeometryObject(shape)])
        return self._least(geometry)

    @staticmethod
    def _add_boxes(geometry: Any, moving: list[int], boxes: list[lt.Box]) -> None:
        for i, box in enumerate(boxes):
            w, x, y, z = box.orientation
            pose = pin.SE3(pin.Quaternion(w, x, y, z).matrix(), np.array(box.position))
            shape = pin.GeometryObject(f"box {i}", 0, pose, coal.Box(*box.size))
            _add_pairs(geometry, moving, [geometry.addGeometryObject(shape)])

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
    """The largest difference where nothing overlaps; coal's depth is not always the smallest."""
    apart = (ours > TOLERANCE) | (peers > TOLERANCE)
    return float(np.abs(ours - peers)[apart].max())


def _boxes() -> list[lt.Box]:
    """Five boxes around the arm, away from its first links."""
    rng = np.random.default_rng(2)
    turns = rng.normal(size=(5, 4))
    turns /= np.linalg.norm(turns, axis=1)[:, None]
    around = 0.4 * np.pi * np.arange(5)
    places = np.column_stack([0.6 * np.cos(around), 0.6 * np.sin(around), rng.uniform(0, 0.8, 5)])
    return [
        lt.Box(rng.uniform(0.05, 0.3, 3), place, turn)
        for place, turn in zip(places, turns, strict=True)
    ]
