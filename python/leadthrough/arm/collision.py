"""Collision of the whole arm with obstacles and with itself.

Every collision shape of every link and every attached object counts. Links that do not move are not
checked against obstacles: a base may stand on a table. Pairs of links that are neighbours, that
never come near each other or that always touch are left out; see `Arm.collision_pairs`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check, sanity
from leadthrough.arm.kinematics import joint_rows
from leadthrough.arm.robot_files import mesh_parts
from leadthrough.arm.tip_path import CollisionTest
from leadthrough.check import Float64Array, InvalidInput, InvalidRobot, ShortRepr
from leadthrough.drawing import Drawn, Line, Panel, palette
from leadthrough.motion import JointTrajectory, in_order
from leadthrough.shapes import Box, SceneLike, Shape, as_scene, compiled

_MIN_TOLERANCE = 1e-6  # m; distances are exact to 1e-7
# Steps of a check between two samples: more would take minutes.
_MAX_STEPS = 1e6
# An obstacle this many reaches away is not meant: it is in mm.
_IMPLAUSIBLE = 20.0

# Of the core: sample, two bodies, distance, two points.
_Nearest = tuple[float, int, int, float, Float64Array, Float64Array]


def collision_model(
    robot: core.Robot,
    chain: core.Chain,
    ends: tuple[str, str],
    mesh_folders: Sequence[str],
    attached: Sequence[Shape],
) -> core.CollisionModel:
    """The shapes of the robot and the pairs worth a check; some 10 ms to choose them."""
    meshes = [mesh_parts(*mesh, mesh_folders) for mesh in robot.meshes]
    model = core.CollisionModel(robot, chain, *ends, meshes, compiled(attached))
    if not model.bodies:
        raise InvalidRobot("robot", "no link has collision geometry, so nothing can be checked")
    return model


def check_motion(
    model: core.CollisionModel,
    trajectory: JointTrajectory | ArrayLike,
    scene: SceneLike,
    *,
    tolerance: float,
    threads: int,
) -> CollisionReport:
    """See `Arm.check`."""
    q, times = _configurations(trajectory, tuple(model.chain.joint_names))
    around = as_scene(scene)
    pairs = (against(model, around.shapes), core.itself(model))
    margins = (around.margin, around.self_collision_margin)
    exact = check.number(tolerance, "tolerance", at_least=_MIN_TOLERANCE)
    count = check.integer(threads, "threads", at_least=1, at_most=256)
    _require_short_steps(pairs, q, exact)
    _warn_of_degrees(model.chain, q)
    from_obstacles, from_itself = (
        _clearance(each, margin, times, core.check_motion(each, q, margin, exact, count))
        for each, margin in zip(pairs, margins, strict=True)
    )
    return CollisionReport(from_obstacles, from_itself, tolerance=exact)


def against(model: core.CollisionModel, shapes: Sequence[Shape]) -> core.CollisionScene:
    """Pairs of the arm's bodies and obstacles; warns of obstacles that are too far away."""
    _warn_of_far_obstacles(model.chain.reach, shapes)
    return core.against(model, compiled(shapes))


def _warn_of_far_obstacles(reach: float, shapes: Sequence[Shape]) -> None:
    """Warns of obstacles whose position or size does not go with an arm, as in mm."""
    for i, shape in enumerate(shapes):
        away = float(np.abs(shape.middle).max())
        size = 0.0 if isinstance(shape, Box) else shape.bounding_radius
        if max(away, size) > _IMPLAUSIBLE * reach > 0.0:
            what = f"lies {away:.4g} m from the arm's base" if away > size else f"is {size:.4g} m"
            sanity.warn(
                f"obstacles[{i}]: {what}, and the arm reaches {reach:.3g} m; give positions and "
                "sizes in m, not mm, in the arm's base frame"
            )


def nearest(
    chain: core.Chain, q: ArrayLike, pairs: core.CollisionScene, threads: int
) -> float | Float64Array:
    """Smallest distances of pairs, a number or (m,) for a batch."""
    batch, (rows,) = joint_rows(chain, q=q)
    count = check.integer(threads, "threads", at_least=1, at_most=256)
    distances = core.nearest_bodies(pairs, rows, count)[0]
    return distances if batch else float(distances[0])


def _configurations(
    trajectory: JointTrajectory | ArrayLike, joint_names: tuple[str, ...]
) -> tuple[Float64Array, Float64Array | None]:
    """Checked configurations (m, joints), m > 0, and their times where they have some."""
    if isinstance(trajectory, JointTrajectory):
        own = in_order(trajectory, joint_names, "trajectory")
        return own.positions, own.times
    q = check.array(trajectory, "trajectory", shape=("m", len(joint_names)))
    if len(q) == 0:
        raise InvalidInput("trajectory: expected at least one configuration, got none")
    return q, None


def _warn_of_degrees(chain: core.Chain, q: Float64Array) -> None:
    """Warns of configurations (m, joints) turns beyond the limits."""
    outside = np.maximum(chain.lower - q, q - chain.upper)
    if question := sanity.degrees(float(outside.max())):
        i, j = np.unravel_index(int(outside.argmax()), q.shape)
        sanity.warn(
            f"trajectory: {chain.joint_names[j]} is at {q[i, j]:.4g} rad, "
            f"{outside[i, j]:.4g} beyond its limits: {question}"
        )


def _require_short_steps(
    both: Iterable[core.CollisionScene], q: Float64Array, tolerance: float
) -> None:
    step = max(core.longest_step(pairs, q) for pairs in both)
    if not step <= tolerance * _MAX_STEPS:
        raise InvalidInput(
            f"trajectory: between two samples the arm may move by {step:.3g} m, too far to be "
            f"checked to {tolerance:g} m; take smaller steps or a larger tolerance"
        )


def _clearance(
    pairs: core.CollisionScene,
    margin: float,
    times: Float64Array | None,
    found: tuple[Float64Array, _Nearest | None, _Nearest | None],
) -> Clearance:
    distances, closest, first = found
    return Clearance(
        first=_closest_pair(pairs, times, first),
        closest=_closest_pair(pairs, times, closest),
        distances=distances,
        margin=margin,
    )


def _closest_pair(
    pairs: core.CollisionScene, times: Float64Array | None, found: _Nearest | None
) -> ClosestPair | None:
    if found is None or np.isinf(found[3]):
        return None
    sample, a, b, gap, on_a, on_b = found
    time = None if times is None else float(np.interp(sample, np.arange(len(times)), times))
    return ClosestPair(sample, time, (pairs.names[a], pairs.names[b]), gap, np.stack([on_a, on_b]))


@dataclass(frozen=True, eq=False)
class ClosestPair(ShortRepr):
    """Two bodies at their smallest distance.

    Attributes:
        sample: index of a sample; with a fraction, between it and the next.
        time: in s; None where the motion has no times.
        bodies: links by name, "attached", or "obstacle" with its index.
        distance: in m; the depth of the overlap, negative, where the bodies overlap.
        points: (2, 3) in m, one point on each body, in the base frame.
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
class Clearance(ShortRepr):
    """Distances of the arm to obstacles, or between its parts.

    Attributes:
        first: first place with something nearer than `margin`; None without any.
        closest: the nearest approach of the whole motion, between samples as well; None where
            nothing is checked.
        distances: (m,) at the samples in m, infinite where nothing is checked.
        margin: the distance to keep in m.
    """

    first: ClosestPair | None
    closest: ClosestPair | None
    distances: Float64Array
    margin: float

    @property
    def minimum_distance(self) -> float:
        """Distance of the closest pair in m; infinite if no pair is checked."""
        return np.inf if self.closest is None else self.closest.distance


@dataclass(frozen=True, eq=False)
class CollisionReport(Drawn):
    """Result of a collision check; a hit is reported, not raised.

    The two clearances are apart because parts of an arm are near each other by design.

    Attributes:
        obstacles: clearance from obstacles.
        itself: clearance between parts of the arm.
        tolerance: in m. Anything nearer than the closest approach, or hit before the first hit, is
            so by less than this.
    """

    obstacles: Clearance
    itself: Clearance
    tolerance: float

    @property
    def ok(self) -> bool:
        """Whether every distance is at least its margin."""
        return self.first is None

    @property
    def first(self) -> ClosestPair | None:
        """The first collision of both kinds; None without one."""
        hits = [hit for hit in (self.obstacles.first, self.itself.first) if hit is not None]
        return min(hits, key=lambda hit: hit.sample, default=None)

    @property
    def closest(self) -> ClosestPair | None:
        """The closest pair of both kinds; None if no pair is checked."""
        both = (self.obstacles, self.itself)
        return min(both, key=lambda clearance: clearance.minimum_distance).closest

    @property
    def minimum_distance(self) -> float:
        """Distance of the closest pair in m; infinite if no pair is checked."""
        return min(self.obstacles.minimum_distance, self.itself.minimum_distance)

    @property
    def distances(self) -> Float64Array:
        """The smaller distance (m,) of both kinds at the samples in m."""
        return np.minimum(self.obstacles.distances, self.itself.distances)

    def _repr_parts(self) -> list[str]:
        return [f"ok={self.ok}", str(self)]

    def _panels(self) -> list[Panel]:
        lines = []
        for name, each in (("obstacles", self.obstacles), ("itself", self.itself)):
            if each.closest is not None:
                samples = np.arange(len(each.distances), dtype=np.float64)
                lines.append(Line(samples, each.distances, name))
                margin = np.full(2, each.margin)
                ends = samples[[0, -1]]
                lines.append(Line(ends, margin, colour=palette.VERMILION, dashed=True))
        if not lines:
            raise InvalidInput("report: there was nothing to hit, so there is nothing to draw")
        return [Panel("distance in m, margins dashed", lines, "sample")]

    def __str__(self) -> str:
        if self.closest is None:
            return "clear: there is nothing to hit"
        if self.first is None:
            return f"clear by {self.closest}"
        return f"hit: {self.first}; nearest: {self.closest}"


@dataclass(frozen=True, eq=False)
class CollisionPairs(ShortRepr):
    """Pairs of bodies that are checked against each other, and reasons for leaving out others.

    Attributes:
        checked: pairs of names.
        left_out: reason by pair: "adjacent", neighbours along the chain; "never", not within 5 cm
            in 4000 configurations spread over the joints' ranges; "always", touching in all of
            them.
    """

    checked: tuple[tuple[str, str], ...]
    left_out: dict[tuple[str, str], str]


class CollisionQueries(ABC):
    """Distances and checks of a collision model at configurations and along motions."""

    @property
    @abstractmethod
    def _collision(self) -> core.CollisionModel:
        """The collision shapes and the pairs of them to check."""

    @overload
    def distance(self, q: Sequence[float], scene: SceneLike, *, threads: int = 1) -> float: ...
    @overload
    def distance(
        self, q: Sequence[Sequence[float]], scene: SceneLike, *, threads: int = 1
    ) -> Float64Array: ...
    @overload
    def distance(
        self, q: ArrayLike, scene: SceneLike, *, threads: int = 1
    ) -> float | Float64Array: ...
    def distance(self, q: ArrayLike, scene: SceneLike, *, threads: int = 1) -> float | Float64Array:
        """Minimum distance, m, between obstacles and the arm's moving links.

        If they overlap it is the depth of the overlap, negative; without obstacles it is
        infinite. The scene's margins are not used.
        """
        pairs = against(self._collision, as_scene(scene).shapes)
        return nearest(self._collision.chain, q, pairs, threads)

    @overload
    def self_distance(self, q: Sequence[float], *, threads: int = 1) -> float: ...
    @overload
    def self_distance(self, q: Sequence[Sequence[float]], *, threads: int = 1) -> Float64Array: ...
    @overload
    def self_distance(self, q: ArrayLike, *, threads: int = 1) -> float | Float64Array: ...
    def self_distance(self, q: ArrayLike, *, threads: int = 1) -> float | Float64Array:
        """Smallest distance in m between parts of the arm, or of the robot; see `distance`.

        `collision_pairs` lists the parts that are compared.
        """
        return nearest(self._collision.chain, q, core.itself(self._collision), threads)

    def _nearest_pairs(
        self, q: Float64Array, scene: SceneLike
    ) -> Iterator[tuple[Float64Array, list[tuple[str, str]], Float64Array]]:
        """Distances (m,), bodies and points (m, 6) of the nearest: with obstacles, of itself."""
        shapes = as_scene(scene).shapes
        both = [against(self._collision, shapes)] if shapes else []
        for pairs in (*both, core.itself(self._collision)):
            distances, bodies, points = core.nearest_bodies(pairs, np.ascontiguousarray(q), 1)
            yield distances, [(pairs.names[a], pairs.names[b]) for a, b in bodies], points

    def _planning_test(self, scene: SceneLike) -> CollisionTest:
        return CollisionTest.of(self._collision, scene)

    @overload
    def is_clear(self, q: Sequence[float] | JointTrajectory, scene: SceneLike = ...) -> bool: ...
    @overload
    def is_clear(self, q: ArrayLike, scene: SceneLike = ...) -> bool | NDArray[np.bool_]: ...
    def is_clear(
        self, q: JointTrajectory | ArrayLike, scene: SceneLike = ()
    ) -> bool | NDArray[np.bool_]:
        """Whether the whole arm keeps the margins of a scene; quicker than distances.

        A motion is certified between its samples too, where the joints move straight; within 0.1 mm
        of a margin it may count as too near.

        Args:
            q: one configuration (joints,), several (m, joints), or a motion.

        Returns:
            One answer, or (m,) for several configurations.
        """
        test = CollisionTest(self._collision, as_scene(scene))
        if isinstance(q, JointTrajectory):
            return test.clear_between(in_order(q, self._collision.chain.joint_names, "q").positions)
        batch, (rows,) = joint_rows(self._collision.chain, q=q)
        clear = test.clear_rows(rows)
        return np.array(clear) if batch else clear[0]

    def check(
        self,
        trajectory: JointTrajectory | ArrayLike,
        scene: SceneLike = (),
        *,
        tolerance: float = 1e-3,
        threads: int = 1,
    ) -> CollisionReport:
        """Whether the whole arm keeps the margins of a scene, between samples as well.

        Between samples the joints move straight, all in proportion. A hit is reported, never
        raised.

        Args:
            trajectory: joints, or configurations (m, joints), m > 0.
            tolerance: in m, >= 1e-6; a hit between samples that is deeper than this isn't missed.

        Raises:
            InvalidInput: if the joints are not the arm's, or two samples are too far apart for the
                tolerance.

        Source: Mirtich 1996.
        """
        return check_motion(
            self._collision, trajectory, scene, tolerance=tolerance, threads=threads
        )

    @property
    def collision_pairs(self) -> CollisionPairs:
        """The pairs of bodies that are checked, and why others are left out.

        Raises:
            InvalidRobot: if the robot has no collision geometry, or a mesh is missing or flat.
            MissingDependency: if a mesh's format needs a package that is not installed.
        """
        model = self._collision
        return CollisionPairs(tuple(model.pairs), {(a, b): why for a, b, why in model.left_out})
