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
from leadthrough.shapes import Box, Capsule, Shape, Sphere

_COLUMNS = 11
_UNTURNED = (1.0, 0.0, 0.0, 0.0)
_FINEST_TOLERANCE = 1e-6  # m; distances are exact to 1e-7
# Steps of a check between two samples: more would take minutes.
_MOST_STEPS = 1e6


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


@dataclass(frozen=True, eq=False)
class CollisionReport:
    """What a check found; a motion that hits something is a finding, not an error.

    ok: nothing comes nearer than `margin`. first: where something does for the first time, or None.
    closest: the nearest approach of the whole motion, between samples as well; None where there is
    nothing to check. minimum_distance: its distance, m, infinite where there is nothing; what is
    still nearer, or a hit before the first, is so by less than `tolerance`, m.
    distances: (m,) at the samples, m.
    """

    ok: bool
    first: Approach | None
    closest: Approach | None
    minimum_distance: float
    distances: Float64Array
    margin: float
    tolerance: float

    def __str__(self) -> str:
        if self.closest is None:
            return "clear: there is nothing to hit"
        if self.first is None:
            return f"clear by {_text(self.closest)}"
        return f"hit: {_text(self.first)}; nearest: {_text(self.closest)}"


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


def distance(
    model: _core.CollisionModel, q: Float64Array, obstacles: Iterable[Shape], *, threads: int = 1
) -> Float64Array:
    """Smallest distance (m,) of each configuration (m, joints). Raises InvalidInput."""
    count = check.integer(threads, "threads", at_least=1, at_most=256)
    return _core.nearest_bodies(model, _rows(_shapes(obstacles)), q, count)[0]


def check_motion(
    model: _core.CollisionModel,
    q: Float64Array,
    obstacles: Iterable[Shape],
    *,
    times: Float64Array | None = None,
    margin: float = 0.0,
    tolerance: float = 1e-3,
    threads: int = 1,
) -> CollisionReport:
    """See `Arm.check`. q: (m, joints), m > 0. times: (m,) s. Source: Mirtich 1996."""
    rows = _rows(_shapes(obstacles))
    least = check.number(margin, "margin", at_least=0.0)
    exact = check.number(tolerance, "tolerance", at_least=_FINEST_TOLERANCE)
    count = check.integer(threads, "threads", at_least=1, at_most=256)
    if len(q) == 0:
        raise InvalidInput("trajectory: expected at least one configuration, got none")
    step = _core.longest_step(model, rows, q)
    if not step <= exact * _MOST_STEPS:
        raise InvalidInput(
            f"trajectory: between two samples the arm may move by {step:.3g} m, too far to be "
            f"checked to {exact:g} m; take smaller steps or a larger tolerance"
        )
    distances, closest, first = _core.check_motion(model, rows, q, least, exact, count)
    return CollisionReport(
        ok=first is None,
        first=None if first is None else _approach(model, times, *first),
        closest=_approach(model, times, *closest) if np.isfinite(closest[3]) else None,
        minimum_distance=closest[3],
        distances=distances,
        margin=least,
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
    model: _core.CollisionModel,
    times: Float64Array | None,
    sample: float,
    a: int,
    b: int,
    gap: float,
    on_a: Float64Array,
    on_b: Float64Array,
) -> Approach:
    time = None if times is None else float(np.interp(sample, np.arange(len(times)), times))
    names = (_name(model, a), _name(model, b))
    return Approach(sample, time, names, gap, np.stack([on_a, on_b]))


def _name(model: _core.CollisionModel, body: int) -> str:
    own = model.bodies
    return own[body] if body < len(own) else f"obstacle {body - len(own)}"


def _shapes(obstacles: Iterable[Shape]) -> tuple[Shape, ...]:
    if not isinstance(obstacles, Iterable):
        raise InvalidInput(f"obstacles: expected a sequence, got {type(obstacles).__name__}")
    shapes = tuple(obstacles)
    for shape in shapes:
        if not isinstance(shape, Box | Sphere | Capsule):
            raise InvalidInput(
                f"obstacles: expected Box, Sphere or Capsule, got {type(shape).__name__}"
            )
    return shapes


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


def _text(approach: Approach) -> str:
    a, b = approach.bodies
    when = f"sample {approach.sample:g}" if approach.time is None else f"{approach.time:.3f} s"
    return f"{1e3 * approach.distance:.1f} mm, {a} and {b} at {when}"
