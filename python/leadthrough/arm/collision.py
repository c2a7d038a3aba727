"""Collision of the whole arm with obstacles and with itself.

Every collision shape of every link counts, and what is attached to the tip. What does not move is
not checked against obstacles: a base may stand on a table. Pairs of links that are neighbours, that
never come near each other or that always touch are left out; see `Arm.collision_pairs`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.arm.meshes import hull_vertices
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, InvalidRobot
from leadthrough.motion import JointTrajectory
from leadthrough.shapes import Capsule, Shape, Sphere, check_shapes

_COLUMNS = 11
_UNTURNED = (1.0, 0.0, 0.0, 0.0)
_FINEST_TOLERANCE = 1e-6  # m; distances are exact to 1e-7
# Steps of a check between two samples: more would take minutes.
_MOST_STEPS = 1e6

# Of the core: sample, two bodies, distance, two points.
_Found = tuple[float, int, int, float, Float64Array, Float64Array]


@dataclass(frozen=True, eq=False)
class Approach:
    """Two bodies where they are nearest.

    sample: index of a sample; with a fraction, between it and the next. time: s; None where the
    motion has no times. bodies: links by name, "attached", or "obstacle" with its index.
    distance: m, below zero the depth. points: (2, 3) on the two bodies, m, in the base frame.
    """

    sample: float
    time: float | None
    bodies: tuple[str, str]
    distance: float
    points: Float64Array

    def __str__(self) -> str:
        a, b = self.bodies
        when = f"sample {self.sample:g}" if self.time is None else f"{self.time:.3f} s"
        return f"{1e3 * self.distance:.1f} mm, {a} and {b} at {when}"


@dataclass(frozen=True, eq=False)
class Clearance:
    """How near the arm comes to one kind of thing: obstacles, or itself.

    first: where something comes nearer than `margin` for the first time, or None. closest: the
    nearest approach of the whole motion, between samples as well; None where nothing is checked.
    distances: (m,) at the samples, m, infinite where nothing is checked.
    """

    first: Approach | None
    closest: Approach | None
    distances: Float64Array
    margin: float

    @property
    def minimum_distance(self) -> float:
        """The distance of the closest approach, m, infinite where nothing is checked."""
        return np.inf if self.closest is None else self.closest.distance


@dataclass(frozen=True, eq=False)
class CollisionReport:
    """What a check found; a motion that hits something is a finding, not an error.

    obstacles, itself: the two kinds of clearance; parts of an arm are near each other by design.
    tolerance: m; what is nearer than the closest approach, or a hit before the first, is so by
    less than that.
    """

    obstacles: Clearance
    itself: Clearance
    tolerance: float

    @property
    def ok(self) -> bool:
        """Whether nothing comes nearer than its margin; what touches does not."""
        return self.first is None

    @property
    def first(self) -> Approach | None:
        """The first hit."""
        hits = [hit for hit in (self.obstacles.first, self.itself.first) if hit is not None]
        return min(hits, key=lambda hit: hit.sample, default=None)

    @property
    def closest(self) -> Approach | None:
        """The nearest approach of both kinds; None where nothing is checked."""
        both = (self.obstacles, self.itself)
        return min(both, key=lambda clearance: clearance.minimum_distance).closest

    @property
    def minimum_distance(self) -> float:
        """Its distance, m."""
        return min(self.obstacles.minimum_distance, self.itself.minimum_distance)

    @property
    def distances(self) -> Float64Array:
        """The smaller distance (m,) of both kinds at the samples, m."""
        return np.minimum(self.obstacles.distances, self.itself.distances)

    def __str__(self) -> str:
        if self.closest is None:
            return "clear: there is nothing to hit"
        if self.first is None:
            return f"clear by {self.closest}"
        return f"hit: {self.first}; nearest: {self.closest}"


@dataclass(frozen=True, eq=False)
class CollisionPairs:
    """Which bodies of an arm are checked against each other, and why the others are not.

    checked: pairs of names. left_out: reason by pair; "adjacent", neighbours along the chain;
    "never", not within 5 cm in 4000 configurations spread over the joints' ranges; "always",
    touching in all of them.
    """

    checked: tuple[tuple[str, str], ...]
    left_out: dict[tuple[str, str], str]


def collision_model(
    robot: _core.Robot,
    chain: _core.Chain,
    *,
    base: str,
    tip: str,
    attached: Sequence[Shape] = (),
    mesh_folders: Sequence[str] = (),
) -> _core.CollisionModel:
    """The shapes of a robot and the pairs worth a check; takes some 10 ms to choose them.

    attached: in the frame of the tip link. mesh_folders: where the files of meshes are looked for.
    Raises InvalidRobot, MissingDependency.
    """
    meshes = [hull_vertices(*mesh, mesh_folders) for mesh in robot.meshes]
    model = _core.CollisionModel(robot, chain, base, tip, meshes, _rows(attached))
    if not model.bodies:
        raise InvalidRobot("robot", "no link has collision geometry, so nothing can be checked")
    return model


def pairs(model: _core.CollisionModel) -> CollisionPairs:
    """See `Arm.collision_pairs`."""
    return CollisionPairs(tuple(model.pairs), {(a, b): why for a, b, why in model.left_out})


def distances(scene: _core.CollisionScene, q: Float64Array, *, threads: int = 1) -> Float64Array:
    """Smallest distance (m,) in a scene of each configuration (m, joints). Raises InvalidInput."""
    count = check.integer(threads, "threads", at_least=1, at_most=256)
    return _core.nearest_bodies(scene, q, count)[0]


def against(model: _core.CollisionModel, obstacles: Iterable[Shape]) -> _core.CollisionScene:
    """The arm among obstacles. Raises InvalidInput."""
    return _core.against(model, _rows(check_shapes(obstacles)))


def check_motion(
    model: _core.CollisionModel,
    q: Float64Array,
    obstacles: Iterable[Shape],
    *,
    times: Float64Array | None = None,
    margin: float = 0.0,
    self_margin: float = 0.0,
    tolerance: float = 1e-3,
    threads: int = 1,
) -> CollisionReport:
    """See `Arm.check`. q: (m, joints), m > 0. times: (m,) s. Source: Mirtich 1996."""
    if len(q) == 0:
        raise InvalidInput("trajectory: expected at least one configuration, got none")
    exact = check.number(tolerance, "tolerance", at_least=_FINEST_TOLERANCE)
    count = check.integer(threads, "threads", at_least=1, at_most=256)
    scenes = (against(model, obstacles), _core.itself(model))
    step = max(_core.longest_step(scene, q) for scene in scenes)
    if not step <= exact * _MOST_STEPS:
        raise InvalidInput(
            f"trajectory: between two samples the arm may move by {step:.3g} m, too far to be "
            f"checked to {exact:g} m; take smaller steps or a larger tolerance"
        )

    def clearance(scene: _core.CollisionScene, wanted: float, name: str) -> Clearance:
        least = check.number(wanted, name, at_least=0.0)
        found, closest, first = _core.check_motion(scene, q, least, exact, count)
        return Clearance(
            first=_approach(scene, times, first),
            closest=_approach(scene, times, closest),
            distances=found,
            margin=least,
        )

    return CollisionReport(
        clearance(scenes[0], margin, "margin"),
        clearance(scenes[1], self_margin, "self_margin"),
        tolerance=exact,
    )


def configurations(trajectory: Any, joint_names: tuple[str, ...]) -> Any:
    """Joint positions of a trajectory, and its times or None; arrays pass as they are.

    Raises InvalidInput where its joints are others than the arm's.
    """
    if not isinstance(trajectory, JointTrajectory):
        return trajectory, None
    if trajectory.joint_names and trajectory.joint_names != joint_names:
        raise InvalidInput(
            f"trajectory: expected the joints {joint_names}, got {trajectory.joint_names}"
        )
    return trajectory.positions, trajectory.times


def _approach(
    scene: _core.CollisionScene, times: Float64Array | None, found: _Found | None
) -> Approach | None:
    if found is None or np.isinf(found[3]):
        return None
    sample, a, b, gap, on_a, on_b = found
    time = None if times is None else float(np.interp(sample, np.arange(len(times)), times))
    return Approach(sample, time, (scene.names[a], scene.names[b]), gap, np.stack([on_a, on_b]))


def _rows(shapes: Sequence[Shape]) -> Float64Array:
    """A row a shape, as the core takes them: kind, three sizes, position, orientation."""
    rows = np.zeros((len(shapes), _COLUMNS))
    for row, shape in zip(rows, shapes, strict=True):
        if isinstance(shape, Sphere):
            row[:4], row[7:] = (0, shape.radius, 0, 0), _UNTURNED
        elif isinstance(shape, Capsule):
            row[:4], row[7:] = (1, shape.radius, shape.length, 0), shape.orientation
        else:
            row[:4], row[7:] = (2, *shape.size), shape.orientation
        row[4:7] = shape.position
    return rows
