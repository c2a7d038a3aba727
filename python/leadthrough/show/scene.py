"""A 3D scene of a moving arm: surfaces in layers, and the poses of the arm's links over time.

It knows no renderer: the HTML page and the live view draw the same scene.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import cycle

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.arm import Arm
from leadthrough.arm.link_poses import link_poses
from leadthrough.check import Float64Array
from leadthrough.drawing import palette
from leadthrough.drawing.palette import Colour
from leadthrough.errors import InvalidInput
from leadthrough.models.protocol import Distributed, Skill
from leadthrough.motion import Demonstration, JointTrajectory, Motion
from leadthrough.repr import ShortRepr
from leadthrough.shapes import Shape, check_shapes
from leadthrough.shapes.surface import Surface, merged, sphere
from leadthrough.show import tubes
from leadthrough.show.urdf_geometry import Part, parts_by_link

ARM, DEMONSTRATIONS, PATH, SPREAD, OBSTACLES, GOAL = (
    "arm", "demonstrations", "path", "uncertainty", "obstacles", "goal",
)  # fmt: skip
# Layers whose surfaces have no creases.
SMOOTH = frozenset({DEMONSTRATIONS, PATH, SPREAD, GOAL})

# Radius of the tubes around paths, m: thin enough that drawings of a hand's size stay legible.
_PATH_RADIUS = 0.004
_PATH_FRACTION = 0.01  # of the path's extent
_DEMONSTRATION_FRACTION = 0.5  # of a path's radius
_GOAL_RADIUS = 0.014
_PATH_POINTS = 200
_DEMONSTRATION_POINTS = 100
_SPREAD_POINTS = 80
# A screen shows no more than 60 frames per second; a long motion is shown with fewer of them.
_FRAME_RATE = 60.0
_MOST_FRAMES = 1200
# Without any geometry an arm is drawn as rods from joint to joint.
_ROD_RADIUS = 0.02


@dataclass(frozen=True, eq=False)
class Item(ShortRepr):
    """One surface."""

    name: str  # unique in its layer
    layer: str  # one of the layers above
    mesh: Surface  # in the frame of its link, or of the arm's base
    colour: Colour  # red, green, blue in [0, 1]
    opacity: float = 1.0  # in [0, 1]
    link: int | None = None  # index of the link that carries it; None if it stands still


@dataclass(frozen=True, eq=False)
class Animation(ShortRepr):
    """Surfaces and the motion of the links that carry some of them."""

    links: tuple[str, ...]  # their names
    times: Float64Array  # (n,), s, from 0. Between them, poses are interpolated
    positions: Float64Array  # of the links in the frame of the arm's base, (n, links, 3), m
    orientations: Float64Array  # of the links in that frame, (n, links, 4), w, x, y, z
    items: tuple[Item, ...] = field(repr=False)  # the surfaces
    remarks: tuple[str, ...] = ()  # on what cannot be shown, such as a mesh that is not there

    def with_motion(self, arm: Arm, joints: JointTrajectory) -> Animation:
        """The same surfaces with another motion of the arm."""
        shown = frames(arm, joints)
        _, positions, orientations = _links(arm, shown.positions)
        times = shown.times - shown.times[0]
        return replace(self, times=times, positions=positions, orientations=orientations)

    def ball(self) -> tuple[Float64Array, float]:
        """Centre (3,) and radius, m, of a ball around all surfaces and their motion."""
        still = [item.mesh.vertices for item in self.items if item.link is None]
        frames = {0, len(self.times) // 2, len(self.times) - 1}
        moving = [self._at(item, frame) for item in self.items for frame in frames]
        points = np.concatenate([self.positions.reshape(-1, 3), *still, *moving])
        lower, upper = points.min(axis=0), points.max(axis=0)
        return 0.5 * (lower + upper), max(0.5 * float(np.linalg.norm(upper - lower)), 0.1)

    def _at(self, item: Item, frame: int) -> Float64Array:
        """The corners (8, 3) of the box around a moving surface at one sample."""
        if item.link is None:
            return np.zeros((0, 3))
        reach = np.stack([item.mesh.vertices.min(axis=0), item.mesh.vertices.max(axis=0)])
        corners = np.stack(np.meshgrid(*reach.T), axis=-1).reshape(-1, 3)
        turned = rotations.to_matrix(self.orientations[frame, item.link][None])[0]
        return np.asarray(corners @ turned.T + self.positions[frame, item.link])

    def poses_at(self, time: float) -> tuple[Float64Array, Float64Array]:
        """Positions (links, 3) and orientations (links, 4) at a time, s; held beyond the ends."""
        last = len(self.times) - 1
        i = int(np.clip(np.searchsorted(self.times, time) - 1, 0, max(last - 1, 0)))
        j = min(i + 1, last)
        span = self.times[j] - self.times[i]
        passed = float(np.clip((time - self.times[i]) / span, 0.0, 1.0)) if span > 0.0 else 0.0
        position = (1.0 - passed) * self.positions[i] + passed * self.positions[j]
        turned = (1.0 - passed) * self.orientations[i] + passed * self.orientations[j]
        return position, turned / np.linalg.norm(turned, axis=1, keepdims=True)


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
    shown = frames(arm, joints)
    links, positions, orientations = _links(arm, shown.positions)
    if path is None and joints is not None:
        path, _ = arm.forward_kinematics(shown.positions)
    parts, remarks = parts_by_link(arm.document, arm.mesh_folders)
    items = [*arm_items(arm, links, parts), *demonstration_items(arm, demonstrations)]
    if path is not None:
        items.append(path_item(check.array(path, "path", shape=("n", 3))))
    items += spread_items(arm, skill)
    items += [obstacle_item(shape, i) for i, shape in enumerate(check_shapes(obstacles))]
    if goal is not None:
        items.append(goal_item(check.array(goal, "goal", shape=(3,))))
    times = shown.times - shown.times[0]
    return Animation(links, times, positions, orientations, tuple(items), remarks)


def frames(arm: Arm, joints: JointTrajectory | None) -> JointTrajectory:
    """A motion at no more samples than a screen shows."""
    if joints is None:
        return JointTrajectory(np.zeros(1), _middle(arm)[None], joint_names=arm.joint_names)
    if not isinstance(joints, JointTrajectory):
        raise InvalidInput(f"joints: expected a JointTrajectory, got {type(joints).__name__}")
    names, count = joints.joint_names, joints.positions.shape[1]
    if (names and names != arm.joint_names) or count != len(arm.joint_names):
        raise InvalidInput(
            f"joints: expected {', '.join(arm.joint_names)}, "
            f"got {', '.join(names) or f'{count} without names'}"
        )
    wanted = min(int(joints.duration * _FRAME_RATE) + 2, _MOST_FRAMES)
    if len(joints.times) <= wanted:
        return joints
    times = np.linspace(joints.times[0], joints.times[-1], wanted)
    columns = [np.interp(times, joints.times, column) for column in joints.positions.T]
    return JointTrajectory(times, np.column_stack(columns), joint_names=names)


def tip_path(arm: Arm, motion: Motion) -> Float64Array:
    """The tip's path (n, 3) along a motion; a two-dimensional drawing lies at z = 0."""
    if isinstance(motion, JointTrajectory):
        return arm.forward_kinematics(motion.positions)[0]
    width = motion.positions.shape[1]
    if width not in (2, 3):
        raise InvalidInput(f"motion: expected points in 2-D or 3-D, got {width}-D")
    return np.pad(motion.positions, ((0, 0), (0, 3 - width)))


def arm_items(
    arm: Arm, links: Sequence[str], parts: Mapping[str, Sequence[Part]]
) -> Iterator[Item]:
    """The arm's surfaces; links without a colour of their own get one of two in turn."""
    parts = parts or _rods(arm)
    colours = cycle((palette.rgb(palette.SHELL), palette.rgb(palette.JOINT)))
    for (link, own), usual in zip(parts.items(), colours, strict=False):
        by_colour: dict[Colour, list[Surface]] = {}
        for part in own:
            by_colour.setdefault(part.colour or usual, []).append(part.mesh)
        for i, (colour, meshes) in enumerate(by_colour.items()):
            name = f"{link} {i}" if i else link
            yield Item(name, ARM, merged(meshes), colour, link=links.index(link))
    for i, shape in enumerate(arm.attached):
        mesh = shape.placed_surface()
        yield Item(f"attached {i}", ARM, mesh, palette.rgb(palette.TOOL), link=links.index(arm.tip))


def demonstration_items(arm: Arm, demonstrations: Iterable[Demonstration]) -> Iterator[Item]:
    """A thin tube for each demonstration."""
    for i, demonstration in enumerate(demonstrations):
        if not isinstance(demonstration, Demonstration):
            got = type(demonstration).__name__
            raise InvalidInput(f"demonstrations[{i}]: expected a Demonstration, got {got}")
        points = tubes.thinned(tip_path(arm, demonstration.motion), _DEMONSTRATION_POINTS)
        mesh = tubes.tube(points, _DEMONSTRATION_FRACTION * _radius(points), sides=6)
        name = demonstration.name or f"demonstration {i + 1}"
        yield Item(name, DEMONSTRATIONS, mesh, palette.rgb(palette.DEMONSTRATION))


def path_item(path: Float64Array) -> Item:
    """The planned path (n, 3)."""
    mesh = tubes.tube(tubes.thinned(path, _PATH_POINTS), _radius(path))
    return Item("path", PATH, mesh, palette.rgb(palette.PATH))


def spread_items(arm: Arm, skill: Skill | None) -> Iterator[Item]:
    """The tube of two standard deviations about a skill's mean path, if it has one."""
    distribution = distribution_of(arm, skill)
    if distribution is not None:
        mesh = tubes.uncertainty_tube(*distribution)
        yield Item("two standard deviations", SPREAD, mesh, palette.rgb(palette.SKY), opacity=0.35)


def distribution_of(arm: Arm, skill: Skill | None) -> tuple[Float64Array, Float64Array] | None:
    """Mean (n, 3), m, and covariance (n, 3, 3) of the tip's position; None if there is none."""
    if not isinstance(skill, Distributed):
        return None
    mean, covariance = skill.distribution(np.linspace(0.0, skill.duration, _SPREAD_POINTS))
    if skill.chart.kind == "joints":
        jacobian = arm.jacobian(mean)[:, :3]
        covariance = jacobian @ covariance @ jacobian.transpose(0, 2, 1)
        return arm.forward_kinematics(mean)[0], covariance
    return (mean[:, :3], covariance[:, :3, :3]) if skill.chart.size == 3 else None


def obstacle_item(shape: Shape, index: int) -> Item:
    """An obstacle at its own pose."""
    colour = palette.rgb(palette.OBSTACLE)
    return Item(f"obstacle {index}", OBSTACLES, shape.placed_surface(), colour, opacity=0.85)


def goal_item(goal: Float64Array) -> Item:
    """A ball at the goal (3,)."""
    mesh = sphere(_GOAL_RADIUS).moved(goal)
    return Item("goal", GOAL, mesh, palette.rgb(palette.GOAL))


def _radius(path: Float64Array) -> float:
    extent = float(np.ptp(path, axis=0).max())
    return min(_PATH_RADIUS, _PATH_FRACTION * extent) or _PATH_RADIUS


def _links(arm: Arm, q: Float64Array) -> tuple[tuple[str, ...], Float64Array, Float64Array]:
    poses = link_poses(arm, q)
    positions = np.stack([position for _, position in poses.values()], axis=1)
    matrices = np.concatenate([matrix for matrix, _ in poses.values()])
    turned = rotations.from_matrix(matrices).reshape(len(poses), len(q), 4)
    return tuple(poses), positions, np.stack([*map(rotations.align_signs, turned)], axis=1)


def _middle(arm: Arm) -> Float64Array:
    low, high = arm.limits.lower, arm.limits.upper
    bounded = np.isfinite(low) & np.isfinite(high)
    return 0.5 * (np.where(bounded, low, 0.0) + np.where(bounded, high, 0.0))


def _rods(arm: Arm) -> dict[str, list[Part]]:
    """A capsule from each link's frame to its children's."""
    rods: dict[str, list[Part]] = {}
    for joint in arm.robot.tree:
        length = float(np.linalg.norm(joint.position))
        mesh = sphere(1.5 * _ROD_RADIUS)
        if length > 0.0:
            mesh = tubes.tube(np.linspace(0.0, 1.0, 2)[:, None] * joint.position, _ROD_RADIUS)
        rods.setdefault(arm.robot.links[joint.parent], []).append(Part(mesh))
    return rods
