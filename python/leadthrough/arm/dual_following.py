"""Joints of two arms along the motion of an object that both hold.

Each arm follows its grasp in the posture that it reaches first; if the arms are not clear, other
postures of either are paired, then joints that a search finds around the obstacles. Joints move
straight between two samples, and the error of the tips' relative pose grows with the square of the
step: the errors at the middles say how many samples to add.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import count, islice
from typing import NoReturn, TypeVar

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough.arm.arm import Arm
from leadthrough.arm.collision import check_motion
from leadthrough.arm.following import FollowOptions, follow, reachable_start
from leadthrough.arm.rigid_transforms import Transforms
from leadthrough.arm.tip_path import CollisionTest
from leadthrough.arm.tracking import guesses
from leadthrough.check import Float64Array, IkFailure
from leadthrough.motion import JointTrajectory, PoseTrajectory, columns_of
from leadthrough.shapes import Scene, Shape

SIDES = ("left", "right")
# Postures of an arm that are tried, near to the first and to others, and how far apart, rad.
_POSTURES, _RANDOM_POSTURES, _SEPARATION = 12, 24, 0.3
# Samples from one to the next at which most collisions are seen.
_COARSE = 8
_MAX_PARTS = 64  # of a step between two samples
# Rounds of added samples. The second is only needed by postures that move more.
_MAX_ROUNDS = 4
_ALLOWED = 0.8  # of the tolerance, at the middle between two samples
_CHECKED = 1e-3  # m, to which the motion of a refusal is checked

ShapeT = TypeVar("ShapeT", bound=Shape)
Grasp = Transforms | PoseTrajectory


@dataclass(frozen=True, eq=False)
class Side:
    """One of the arms, along the motion of its tip."""

    name: str
    arm: Arm
    tip: PoseTrajectory  # in the arm's base frame
    q0: Float64Array | None
    options: FollowOptions
    scene: Scene | None  # in the arm's base frame

    @cached_property
    def first(self) -> Float64Array:
        """The joints (n, joints) that the arm has without a scene."""
        try:
            q0 = reachable_start(self.arm, self.tip, self.q0, self.options)
            return self._follow(q0, self.options, None)
        except IkFailure as error:
            self._fail(error)

    def tracks(self) -> Iterator[Float64Array]:
        """Joints (n, joints) clear of the scene at some samples, the least effort first."""
        test = CollisionTest.of(self.arm._collision, self.scene or ())
        none = True
        for track in self._near_postures(test):
            if _is_clear(test, track):
                none = False
                yield track
        try:
            yield self._follow(self.q0, self.options, test)
        except IkFailure as error:
            if none:
                self._fail(error)

    def _near_postures(self, test: CollisionTest) -> Iterator[Float64Array]:
        """The first joints, then those that keep near to other postures of the first sample."""
        yield self.first
        postures = self._postures()
        for q, clear in zip(postures, test.clear_rows(postures), strict=True):
            if clear:
                with suppress(IkFailure):
                    yield self._follow(q, replace(self.options, posture=q), None)

    def _postures(self) -> Float64Array:
        """Configurations (m, joints) of the first sample, near the first joints or random ones."""
        pose = self.tip.positions[0], self.tip.orientations[0]
        solve = partial(self.arm.inverse_kinematics_all, *pose, separation=_SEPARATION)
        others = (solve(count=1, q0=q0).q for q0 in guesses(self.arm._chain)[:_RANDOM_POSTURES])
        return np.vstack([solve(count=_POSTURES, q0=self.first[0]).q, *others])

    def _fail(self, error: IkFailure) -> NoReturn:
        error.args = (f"{self.name} arm: {error}",)
        raise error from None

    def _follow(
        self, q0: Float64Array | None, options: FollowOptions, around: CollisionTest | None
    ) -> Float64Array:
        return follow(
            self.arm, self.tip, q0=q0, on_rate_limit="exceed_limits", options=options, around=around
        ).positions


@dataclass(frozen=True, eq=False)
class Carry:
    """Two arms that carry an object, in the base frame of the left one."""

    arms: tuple[Arm, Arm]
    placement: Transforms  # of the right base
    model: core.CollisionModel | None  # of both arms
    grasps: tuple[Grasp, Grasp]
    starts: tuple[Float64Array | None, Float64Array | None]  # of the searches
    options: tuple[FollowOptions, FollowOptions]
    scene: Scene | None  # None checks nothing
    tolerance: tuple[float, float]  # of the tips' relative pose between samples, m and rad

    def along(self, motion: PoseTrajectory) -> tuple[PoseTrajectory, Float64Array]:
        """The motion with the samples that the tolerance takes, and joints (n, joints) along it."""
        given, sides = motion.times, self._sides(motion)
        q = _stacked([side.first for side in sides])
        for _ in range(_MAX_ROUNDS):
            if (parts := self._parts(motion.times, q)).max(initial=1) > 1:
                motion = divided(motion, parts)
                sides = self._sides(motion)
            try:
                q = self._clear(motion, sides)
            except IkFailure as error:
                error.index = int(np.searchsorted(given, motion.times[error.index], "right")) - 1
                raise
            if (parts := self._parts(motion.times, q)).max(initial=1) == 1:
                return motion, q
        why = "the tips cannot keep their relative pose from there"
        raise _missed(motion, int(np.argmax(parts)), "jump", why, q)

    def _sides(self, motion: PoseTrajectory) -> list[Side]:
        at = Transforms(motion.positions, motion.orientations)
        to_bases = Transforms.identity(), self.placement.inverse()
        joints = (None, None) if motion.joints is None else motions_of(self.arms, motion.joints)
        sides = []
        for k, to_base in enumerate(to_bases):
            tip = to_base @ at @ _at(self.grasps[k], motion.times)
            path = PoseTrajectory(motion.times, tip.positions, tip.orientations, joints=joints[k])
            scene = self.scene
            if scene is not None:  # its obstacles at their present poses
                moved = tuple(shape_seen_from(shape, to_base) for shape in scene.shapes)
                scene = replace(scene, obstacles=moved)
            sides.append(Side(SIDES[k], self.arms[k], path, self.starts[k], self.options[k], scene))
        return sides

    def _parts(self, times: Float64Array, q: Float64Array) -> NDArray[np.int_]:
        """Number of parts (n - 1,) to cut each step into, by the error at its middle."""
        middles = 0.5 * (times[1:] + times[:-1])
        held = [_at(grasp, middles) for grasp in self.grasps]
        left, right = tips_of(self.arms, self.placement, 0.5 * (q[1:] + q[:-1]))
        errors = (left.inverse() @ right).distances(held[0].inverse() @ held[1])
        ratio = np.max([e / t for e, t in zip(errors, self.tolerance, strict=True)], axis=0)
        return np.asarray(np.clip(np.ceil(np.sqrt(ratio / _ALLOWED)), 1, _MAX_PARTS), dtype=int)

    def _clear(self, motion: PoseTrajectory, sides: list[Side]) -> Float64Array:
        """Joints (n, joints) of both arms that keep clear."""
        if self.scene is None or self.model is None:
            return _stacked([side.first for side in sides])
        test = CollisionTest.of(self.model, self.scene)
        tried: list[Float64Array] = []
        for q in _paired(*(side.tracks() for side in sides)):
            if _is_clear(test, q) and all(test.clear_rows(q)) and test.clear_between(q):
                return q
            tried = tried or [q]
        found = check_motion(self.model, tried[0], test.scene, tolerance=_CHECKED, threads=1)
        assert found.first is not None
        a, b = found.first.bodies
        why = f"{a} and {b} come {1e3 * found.first.distance:.1f} mm near, in other postures too"
        raise _missed(motion, int(found.first.sample), "blocked", why, tried[0])


def _at(grasp: Grasp, times: Float64Array) -> Transforms:
    """Poses of a tip in the object's frame at times (n,); one of a tip that does not move there."""
    return Transforms(*grasp.at(times)) if isinstance(grasp, PoseTrajectory) else grasp


def _paired(left: Iterator[Float64Array], right: Iterator[Float64Array]) -> Iterator[Float64Array]:
    """All pairs of joints of both arms, the early ones first; none is made before it is paired."""
    known: tuple[list[Float64Array], list[Float64Array]] = ([], [])
    for total in count():
        for tracks, more in zip(known, (left, right), strict=True):
            tracks.extend(islice(more, 1))
        if total > len(known[0]) + len(known[1]):
            return
        for i in range(max(0, total + 1 - len(known[1])), min(total + 1, len(known[0]))):
            yield _stacked([known[0][i], known[1][total - i]])


def motions_of(
    arms: tuple[Arm, Arm], joints: JointTrajectory
) -> tuple[JointTrajectory, JointTrajectory]:
    left, right = (arm.joint_names for arm in arms)
    every = range(len(left) + len(right))
    return (
        columns_of(joints, every[: len(left)], left),
        columns_of(joints, every[len(left) :], right),
    )


def tips_of(
    arms: tuple[Arm, Arm], placement: Transforms, q: Float64Array
) -> tuple[Transforms, Transforms]:
    """Poses of the left and the right tip at configurations (m, joints)."""
    left = len(arms[0].joint_names)
    parts = np.ascontiguousarray(q[:, :left]), np.ascontiguousarray(q[:, left:])
    tips = [Transforms(*arm.forward_kinematics(own)) for arm, own in zip(arms, parts, strict=True)]
    return tips[0], placement @ tips[1]


def divided(motion: PoseTrajectory, parts: NDArray[np.int_]) -> PoseTrajectory:
    """The motion with each step cut into equal parts, straight as before."""
    steps = np.repeat(np.diff(motion.times) / parts, parts)
    index = np.concatenate([np.arange(count) for count in parts])
    times = np.append(np.repeat(motion.times[:-1], parts) + index * steps, motion.times[-1])
    joints = motion.joints
    if joints is not None:
        joints = JointTrajectory(times, joints.at(times), joint_names=joints.joint_names)
    return PoseTrajectory(times, *motion.at(times), motion.events, joints)


def shape_seen_from(shape: ShapeT, T_frame_shape: Transforms) -> ShapeT:
    at = T_frame_shape @ Transforms.of((shape.position, shape.orientation), "shape")
    return shape.at(at.positions[0], at.orientations[0])


def _is_clear(test: CollisionTest, q: Float64Array) -> bool:
    return all(test.clear_rows(np.ascontiguousarray(q[::_COARSE])))


def _stacked(rows: list[Float64Array]) -> Float64Array:
    return np.ascontiguousarray(np.hstack(rows))


def _missed(motion: PoseTrajectory, i: int, status: str, why: str, q: Float64Array) -> IkFailure:
    message = f"both arms: sample {i} at {motion.times[i]:.6g} s: {status}, {why}"
    return IkFailure(message, index=i, status=status, residual=(0.0, 0.0), q=q[i])
