"""Animation of an arm along a motion, with its demonstrations, paths and obstacles.

With it come figures along the motion that a page states and draws: joints, the tip, nearest pairs.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import cycle
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.arm import Arm, link_geometry
from leadthrough.check import Float64Array, InvalidInput, InvalidRobot, MissingDependency
from leadthrough.drawing import palette
from leadthrough.models.protocol import Distributed, Skill
from leadthrough.motion import Demonstration, JointTrajectory, Motion
from leadthrough.shapes import SceneLike, Shape, check_shapes
from leadthrough.shapes.surface import Surface, merged, sphere
from leadthrough.show import animation
from leadthrough.show.animation import Animation, Item, Layer, sampled, thinned, tube

# Radius of the tubes around paths, m: thin enough that drawings of a hand's size stay legible.
_PATH_RADIUS = 0.004
_PATH_FRACTION = 0.01  # of the path's extent
_DEMONSTRATION_FRACTION = 0.5  # of a path's radius
_GOAL_RADIUS, _MARK_RADIUS = 0.014, 0.009
_PATH_POINTS = 200
_DEMONSTRATION_POINTS = 100
_SPREAD_POINTS = 80
# Without any geometry an arm is drawn as rods from joint to joint.
_ROD_RADIUS = 0.02
_COMPARED_POINTS = 2000  # of a path that the tip is compared with
_LEAST = 1e-9  # rad/s (m/s), for limits of zero


def arm_scene(
    arm: Arm,
    joints: JointTrajectory | None,
    *,
    demonstrations: Iterable[Demonstration] = (),
    path: ArrayLike | None = None,
    skill: Skill | None = None,
    obstacles: Iterable[Shape] = (),
    goal: ArrayLike | None = None,
) -> Animation:
    """The scene of an arm on a motion of its joints, with what the motion was made from."""
    moving = arm_motion(arm, joints)
    links = moving.links
    if path is None and joints is not None:
        path, _ = arm.forward_kinematics(sampled(arm, joints).positions)
    parts, remarks = link_geometry.surfaces(arm.robot, arm.mesh_folders)
    items = [*arm_items(arm, links, parts), *demonstration_items(arm, demonstrations)]
    if path is not None:
        points = check.array(path, "path", shape=("n", 3))
        items += [path_item(points), start_item(points)]
    items += spread_items(arm, skill)
    items += [obstacle_item(shape, i) for i, shape in enumerate(check_shapes(obstacles))]
    if goal is not None:
        items.append(goal_item(check.array(goal, "goal", shape=(3,))))
    return replace(moving, items=tuple(items), remarks=remarks)


def arm_motion(arm: Arm, joints: JointTrajectory | None) -> Animation:
    """The motion of the links, without surfaces."""
    frames = sampled(arm, joints)
    links, positions, orientations = animation.link_motion(arm, frames.positions)
    times = frames.times - frames.times[0]
    tip = links.index(arm.tip) if arm.tip in links else None
    return Animation(links, times, positions, orientations, (), tip=tip)


def tip_path(arm: Arm, motion: Motion) -> Float64Array:
    """The tip's path (n, 3) along a motion; a two-dimensional drawing lies at z = 0."""
    if isinstance(motion, JointTrajectory):
        return arm.forward_kinematics(arm.joints_of(motion).positions)[0]
    width = motion.positions.shape[1]
    if width not in (2, 3):
        raise InvalidInput(f"motion: expected points in 2-D or 3-D, got {width}-D")
    return np.pad(motion.positions, ((0, 0), (0, 3 - width)))


def arm_items(
    arm: Arm, links: Sequence[str], parts: Mapping[str, Sequence[link_geometry.LinkSurface]]
) -> Iterator[Item]:
    """The arm's surfaces; links without a colour of their own get one of two in turn."""
    parts = parts or _rods(arm)
    colours = cycle((palette.rgb(palette.SHELL), palette.rgb(palette.JOINT)))
    for (link, own), default in zip(parts.items(), colours, strict=False):
        by_colour: dict[palette.Colour, list[Surface]] = {}
        for part in own:
            by_colour.setdefault(part.colour or default, []).append(part.surface)
        for i, (colour, meshes) in enumerate(by_colour.items()):
            name = f"{link} {i}" if i else link
            yield Item(name, Layer.ARM, merged(meshes), colour, link=links.index(link))
    for i, shape in enumerate(arm.attached):
        mesh = shape.placed_surface()
        yield Item(
            f"attached {i}", Layer.ARM, mesh, palette.rgb(palette.TOOL), link=links.index(arm.tip)
        )


def demonstration_items(arm: Arm, demonstrations: Iterable[Demonstration]) -> Iterator[Item]:
    """A thin tube for each demonstration."""
    for i, demonstration in enumerate(demonstrations):
        check.instance(demonstration, f"demonstrations[{i}]", Demonstration)
        points = thinned(tip_path(arm, demonstration.motion), _DEMONSTRATION_POINTS)
        mesh = tube(points, _DEMONSTRATION_FRACTION * _radius(points), sides=6)
        name = demonstration.name or f"demonstration {i + 1}"
        yield Item(name, Layer.DEMONSTRATIONS, mesh, palette.rgb(palette.DEMONSTRATION))


def path_item(path: Float64Array) -> Item:
    """The planned path (n, 3)."""
    mesh = tube(thinned(path, _PATH_POINTS), _radius(path))
    return Item("path", Layer.PATH, mesh, palette.rgb(palette.PATH))


def spread_items(arm: Arm, skill: Skill | None) -> Iterator[Item]:
    """The tube of two standard deviations about a skill's mean path, if it has one."""
    distribution = distribution_of(arm, skill)
    if distribution is not None:
        mesh = animation.uncertainty_tube(*distribution)
        yield Item(
            "two standard deviations", Layer.SPREAD, mesh, palette.rgb(palette.SKY), opacity=0.35
        )


def distribution_of(arm: Arm, skill: Skill | None) -> tuple[Float64Array, Float64Array] | None:
    """Mean (n, 3), m, and covariance (n, 3, 3) of the tip's position; None if there is none."""
    if not isinstance(skill, Distributed):
        return None
    mean, covariance = skill.distribution(np.linspace(0.0, skill.duration, _SPREAD_POINTS))
    if skill.coordinates.kind == "joints":
        jacobian = arm.jacobian(mean)[:, :3]
        covariance = jacobian @ covariance @ jacobian.transpose(0, 2, 1)
        return arm.forward_kinematics(mean)[0], covariance
    return (mean[:, :3], covariance[:, :3, :3]) if skill.coordinates.size == 3 else None


def obstacle_item(shape: Shape, index: int) -> Item:
    colour = palette.rgb(palette.OBSTACLE)
    return Item(f"obstacle {index}", Layer.OBSTACLES, shape.placed_surface(), colour, opacity=0.85)


def goal_item(goal: Float64Array) -> Item:
    """A ball at the goal (3,)."""
    mesh = sphere(_GOAL_RADIUS).moved(goal)
    return Item("goal", Layer.GOAL, mesh, palette.rgb(palette.GOAL))


def start_item(path: Float64Array) -> Item:
    """A small ball where a path (n, 3) begins."""
    mesh = sphere(_MARK_RADIUS).moved(path[0])
    return Item("start", Layer.START, mesh, palette.rgb(palette.PATH))


def mode_items(paths: Iterable[Float64Array]) -> Iterator[Item]:
    """Paths (m, 3) by the modes of a skill that are not taken."""
    for i, path in enumerate(paths):
        mesh = tube(thinned(path, _PATH_POINTS), _DEMONSTRATION_FRACTION * _radius(path))
        yield Item(f"other mode {i + 1}", Layer.MODES, mesh, palette.rgb(palette.AMBER))


def via_items(points: Iterable[Float64Array]) -> Iterator[Item]:
    """Small balls at points (3,) that the path was moved to."""
    for i, point in enumerate(points):
        mesh = sphere(_MARK_RADIUS).moved(point)
        yield Item(f"via point {i + 1}", Layer.VIA, mesh, palette.rgb(palette.PINK))


def _radius(path: Float64Array) -> float:
    extent = float(np.ptp(path, axis=0).max())
    return min(_PATH_RADIUS, _PATH_FRACTION * extent) or _PATH_RADIUS


def _rods(arm: Arm) -> dict[str, list[link_geometry.LinkSurface]]:
    """A capsule from each link's frame to its children's."""
    rods: dict[str, list[link_geometry.LinkSurface]] = {}
    for joint in arm.robot.tree:
        length = float(np.linalg.norm(joint.position))
        mesh = sphere(1.5 * _ROD_RADIUS)
        if length > 0.0:
            mesh = tube(np.linspace(0.0, 1.0, 2)[:, None] * joint.position, _ROD_RADIUS)
        rods.setdefault(arm.robot.links[joint.parent], []).append(link_geometry.LinkSurface(mesh))
    return rods


def readouts(
    arm: Arm, motion: JointTrajectory | None, scene: SceneLike, wanted: Float64Array | None = None
) -> dict[str, Any] | None:
    """Figures at samples that a page draws; the tip's errors are from a `wanted` path (m, 3)."""
    if motion is None or len(motion.times) < 2:
        return None
    drawn = sampled(arm, motion)
    times, q = drawn.times - drawn.times[0], drawn.positions
    rates = np.gradient(q, times, axis=0)
    limits = arm.limits
    shares = np.abs(rates) / np.maximum(limits.velocity, _LEAST)
    tips = arm.forward_kinematics(q)[0]
    return {
        "times": times.round(4).tolist(),
        "joint": shares.argmax(axis=1).tolist(),
        "share": shares.max(axis=1).round(3).tolist(),
        "speed": np.linalg.norm(np.gradient(tips, times, axis=0), axis=1).round(3).tolist(),
        "error": None
        if wanted is None
        else _distances(tips, thinned(wanted, _COMPARED_POINTS)).round(6).tolist(),
        "names": list(arm.joint_names),
        "positions": q.T.round(3).tolist(),
        "velocities": rates.T.round(3).tolist(),
        "limits": [
            [float(limit) if np.isfinite(limit) else None for limit in each]
            for each in (limits.lower, limits.upper, limits.velocity)
        ],
        "pairs": _pairs(arm, q, scene),
    }


def _distances(points: Float64Array, path: Float64Array) -> Float64Array:
    """Distances (n,) of points (n, 3) from the straight pieces of a path (m, 3)."""
    along = np.diff(path, axis=0, append=path[-1:])
    squares = np.maximum((along**2).sum(axis=1), np.finfo(np.float64).tiny)
    away = points[:, None] - path
    parts = np.clip(np.einsum("nmi,mi->nm", away, along) / squares, 0.0, 1.0)
    return np.asarray(np.linalg.norm(away - parts[..., None] * along, axis=2).min(axis=1))


def _pairs(arm: Arm, q: Float64Array, scene: SceneLike) -> list[dict[str, Any]]:
    """The nearest obstacle and link, and the nearest links, at configurations (n, joints)."""
    try:
        found = list(arm._nearest_pairs(q, scene))
    except (InvalidRobot, MissingDependency):  # there is no geometry to compare
        return []
    return [
        {
            "distance": distances.round(4).tolist(),
            "bodies": [" and ".join(names) for names in bodies],
            "points": points.round(3).tolist(),
        }
        for distances, bodies, points in found
        if np.isfinite(distances).all()
    ]
