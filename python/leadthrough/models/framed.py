"""Any model in the frame of its task: demonstrated in one pose of an object, followed in another.

The demonstrations are seen from a frame that is given with each of them, at an object or a table.
The skill that is learned there is followed in the frame where the object is now. Queries, with
start, goal and obstacles, are in the base frame. For several frames at once: `TaskGMR`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from inspect import signature
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput, ShortRepr, UnsupportedQuery
from leadthrough.models import protocol
from leadthrough.models.archive import Arrays, SteppedSkill, archived, from_archived, prefixed
from leadthrough.models.protocol import Demonstrations, Model, Outliers, Skill, motions_of
from leadthrough.models.queries import CheckedQuery, Via, checked_limits
from leadthrough.motion import JointTrajectory, Motion, MotionT, MotionT_co, PoseTrajectory, Target
from leadthrough.shapes import Shape, check_shapes

# Largest entry of axes.T @ axes - identity that passes for rounding.
_ORTHONORMAL = 1e-6


@dataclass(frozen=True, eq=False)
class Frame(ShortRepr):
    """A frame of reference in the task: at a start, a goal or an object.

    Attributes:
        origin: origin (d,) in the base frame, m; for joints a configuration, rad.
        axes: orthonormal axes (d, d) as columns, by default those of the base frame. For poses
            (3, 3) and right-handed.
    """

    origin: Float64Array
    axes: Float64Array

    def __init__(self, origin: ArrayLike, axes: ArrayLike | None = None) -> None:
        own_origin = check.frozen(origin, "origin", shape=("d",))
        size = len(own_origin)
        if size == 0:
            raise check.refused("origin", "at least one number", "none")
        given = np.eye(size) if axes is None else axes
        own_axes = check.frozen(given, "axes", shape=(size, size))
        off = float(np.abs(own_axes.T @ own_axes - np.eye(size)).max())
        if off > _ORTHONORMAL:
            raise check.refused("axes", "orthonormal columns", f"axes.T @ axes off by {off:.3g}")
        vars(self).update(origin=own_origin, axes=own_axes)

    @staticmethod
    def of_pose(position: ArrayLike, orientation: ArrayLike) -> Frame:
        """The frame of a tool.

        Args:
            position: position (3,) of the tool in the base frame, m.
            orientation: orientation (4,) of the tool, w, x, y, z.
        """
        given = check.array(orientation, "orientation", shape=(4,))
        return Frame(position, rotations.to_matrix(given[None])[0])

    @staticmethod
    def of_sample(motion: Motion, row: int) -> Frame:
        """The frame at a sample of a motion; of poses with the tool's axes there.

        Args:
            motion: a motion in the base frame.
            row: index of the sample.
        """
        if isinstance(motion, PoseTrajectory):
            return Frame.of_pose(motion.positions[row], motion.orientations[row])
        return Frame(motion.positions[row])

    def local(self, motion: Motion) -> Motion:
        """A motion seen from this frame, without events and derivatives.

        Args:
            motion: the motion in the base frame.
        """
        positions = np.asarray((motion.positions - self.origin) @ self.axes)
        if not isinstance(motion, PoseTrajectory):
            return type(motion)(motion.times, positions)
        back = rotations.inverse(self.orientations(len(motion.times)))
        orientations = rotations.compose(back, motion.orientations)
        return PoseTrajectory(motion.times, positions, rotations.align_signs(orientations))

    def base(self, motion: MotionT) -> MotionT:
        """A motion that is seen from this frame, in the base frame.

        Args:
            motion: the motion in this frame; velocities of joints are rotated with it.
        """
        positions = motion.positions @ self.axes.T + self.origin
        if isinstance(motion, PoseTrajectory):
            orientations = rotations.compose(
                self.orientations(len(motion.times)), motion.orientations
            )
            orientations = rotations.align_signs(orientations)
            return replace(motion, positions=positions, orientations=orientations)
        if isinstance(motion, JointTrajectory):
            rates = [motion.velocities, motion.accelerations]
            velocities, accelerations = (None if r is None else r @ self.axes.T for r in rates)
            return replace(
                motion, positions=positions, velocities=velocities, accelerations=accelerations
            )
        return replace(motion, positions=positions)

    def orientations(self, count: int) -> Float64Array:
        """The frame's orientation, repeated.

        Args:
            count: number of rows.

        Returns:
            Orientations (count, 4), w, x, y, z.
        """
        return np.repeat(rotations.from_matrix(self.axes[None]), count, axis=0)


def checked_frames(
    frames: Sequence[Sequence[Frame]], count: int, size: int, *, poses: bool
) -> list[tuple[Frame, ...]]:
    if not isinstance(frames, Sequence) or len(frames) != count:
        got = len(frames) if isinstance(frames, Sequence) else type(frames).__name__
        raise check.refused("frames", f"one sequence of frames per demonstration, {count}", got)
    given = [tuple(each) for each in frames]
    for frame in (frame for each in given for frame in each):
        if not isinstance(frame, Frame) or len(frame.origin) != size:
            got = len(frame.origin) if isinstance(frame, Frame) else type(frame).__name__
            raise InvalidInput(f"frames: expected frames of {size} dimensions, got {got}")
        if poses and np.linalg.det(frame.axes) < 0.0:
            raise InvalidInput("frames: expected right-handed axes for poses")
    if len({len(each) for each in given}) != 1 or not given[0]:
        numbers = sorted({len(each) for each in given})
        raise InvalidInput(
            "frames: expected the same number of frames for every demonstration, at least one, "
            f"got {', '.join(map(str, numbers))}"
        )
    return given


# Largest difference of an axis from an axis of the base frame that passes for rounding.
_ALIGNED = 1e-9


@dataclass(frozen=True)
class Framed(protocol.Unfitted):
    """A model that learns in the frame of the task.

    Attributes:
        model: any model, such as `DMP()`.
    """

    model: Model

    def fit(
        self,
        demonstrations: Demonstrations[MotionT],
        *,
        frames: Sequence[Sequence[Frame]] | None = None,
        outliers: Outliers = "refuse",
    ) -> FramedSkill[MotionT]:
        """A skill from demonstrations and their frames; it is in the frame of the first one.

        Args:
            demonstrations: those that the model learns from, in the base frame.
            frames: one for each demonstration, in a sequence of its own as for `TaskGMR`. Right-
                handed for poses. By default that of its last sample.
            outliers: treatment of one that contradicts all others, seen from the frames, as for
                `learn`: "refuse", "drop", "keep".

        Raises:
            InvalidInput: if the frames do not fit the demonstrations, or for motions that the model
                does not learn.
            FitError: as the model raises it, and for one that contradicts all others.
        """
        motions = motions_of(demonstrations)
        if frames is None:
            frames = [[Frame.of_sample(motion, -1)] for motion in motions]
        poses = isinstance(motions[0], PoseTrajectory)
        given = _one_each(frames, len(motions), motions[0].positions.shape[1], poses=poses)
        back = [Frame(-frame.origin @ frame.axes, frame.axes.T) for frame in given]
        seen = [frame.base(motion) for frame, motion in zip(back, motions, strict=True)]
        seen = motions_of(seen, outliers=outliers)
        # Of the demonstrated type.
        learned = cast(Skill[MotionT], protocol.fit_all(self.model, seen))
        return FramedSkill(Framed(learned.model), learned, given[0], poses)


@dataclass(frozen=True, eq=False)
class FramedSkill(SteppedSkill[MotionT_co]):
    """A skill in the frame of its task; made by `Framed.fit`.

    Queries are in the base frame, and so are motions; parts left out are as demonstrated, seen from
    the frame. Limits need a frame whose axes are those of the base frame, in any order.

    Attributes:
        model: the settings that it was fitted with.
        skill: learned from the demonstrations as seen from the frame.
        frame: the current frame, in the base frame.
        poses: whether its motions are poses.
    """

    model: Framed
    skill: Skill[MotionT_co]
    frame: Frame
    poses: bool

    kind: ClassVar[str] = "framed"
    _own_motion: ClassVar[None] = None  # the skill inside compares queries with its own

    @property
    def supports(self) -> frozenset[str]:
        return self.skill.supports

    def at(self, frames: Sequence[Frame]) -> FramedSkill[MotionT_co]:
        """The skill in a new situation.

        Args:
            frames: the frame of the situation, one in a sequence as for `TaskGMR`.
        """
        (frame,) = _one_each([frames], 1, len(self.frame.origin), poses=self.poses)
        return replace(self, frame=frame)

    def _answer(self, query: CheckedQuery) -> MotionT_co:
        return self.frame.base(self.skill.generate(**self._seen(query).given()))

    def _begin(self, query: CheckedQuery) -> FramedState:
        skill = self._stepped()
        seen = self._seen(query).given()
        del seen["dt"]
        return FramedState(skill.begin(**seen), self.frame)

    def step(
        self,
        state: Any,
        dt: float,
        *,
        goal: Target | None = None,
        coupling: ArrayLike | None = None,
        lag: float = 0.0,
        measured: Target | None = None,
        obstacles: Sequence[Shape] = (),
        limits: tuple[ArrayLike, ArrayLike] | None = None,
    ) -> Any:
        """The state dt s later, or the position to which a policy leads within dt.

        The frame may have moved since the last step, as by `at`: the motion goes on in it.

        Args:
            state: a FramedState; of a skill with a policy a position as for `policy`, and what
                comes back has its form.
            dt: s, > 0.
            goal: in the base frame, as all that follows: arguments of the skill inside. A coupling
                of poses (6,) has an angular part.

        Raises:
            UnsupportedQuery: for a skill that does not go on step by step, for an argument that it
                does not take, and for limits as in `generate`.
        """
        if isinstance(self.skill, protocol.Guided):
            return self._led(
                state,
                dt,
                goal=self._local(goal, "goal"),
                coupling=coupling,
                lag=lag or None,
                measured=measured,
                obstacles=obstacles or None,
                limits=limits,
            )
        push = None
        if coupling is not None:
            width = len(self.frame.origin)
            given = check.array(coupling, "coupling", shape=("n",))
            if len(given) not in ((width, 2 * width) if self.poses else (width,)):
                raise InvalidInput(f"coupling: expected shape ({width},), got {given.shape}")
            push = (given.reshape(-1, width) @ self.frame.axes).ravel()
        after = self._stepped().step(
            state.inside,
            dt,
            goal=self._local(goal, "goal"),
            coupling=push,
            lag=lag,
            measured=self._local(measured, "measured"),
            obstacles=self._local_shapes(obstacles),
            limits=self._limits(limits),
        )
        return FramedState(after, self.frame)

    def condition(
        self, time: float, position: Target, *, covariance: ArrayLike | None = None
    ) -> FramedSkill[MotionT_co]:
        """A skill whose motions pass a via point of the base frame; call it again for more.

        The via point moves with the frame from then on.

        Args:
            time: of the via point, s, in [0, duration].
            position: (d,), or of poses also (position (3,), orientation (4,)).
            covariance: covariance (d, d) of the position, not of poses; by default the motion
                passes through it exactly.

        Raises:
            InvalidInput: as the skill inside.
            UnsupportedQuery: for a skill that cannot be conditioned, and a covariance of poses.
        """
        if not isinstance(self.skill, protocol.Conditioned):
            raise UnsupportedQuery(
                f"condition: a skill of kind {self.skill.kind!r} cannot be conditioned; give via "
                "points where the skill takes them; in Python, fit Framed(ProMP())"
            )
        if covariance is not None and self.poses:
            raise UnsupportedQuery(
                "covariance: expected none for poses; condition the skill inside in its own frame; "
                "in Python, skill.skill.condition(...)"
            )
        seen = cast(Target, self._local(position, "position"))
        uncertain = None
        if covariance is not None:
            axes = self.frame.axes
            given = check.array(covariance, "covariance", shape=axes.shape)
            uncertain = np.asarray(axes.T @ given @ axes)
        made = self.skill.condition(check.number(time, "time"), seen, covariance=uncertain)
        return replace(self, skill=cast(Skill[MotionT_co], made))

    def policy(self, position: ArrayLike | Target) -> Float64Array:
        """The velocity (d,) that leads from a position to the goal, both in the base frame.

        Args:
            position: (d,), or rows (n, d); of poses as the skill inside takes them.

        Raises:
            UnsupportedQuery: for a skill without a policy.
            NoPath: far outside the demonstrations.
        """
        if not isinstance(self.skill, protocol.Guided):
            raise UnsupportedQuery(
                f"policy: a skill of kind {self.skill.kind!r} has none; in Python, fit "
                "Framed(FastMarching())"
            )
        seen: Any = self._local(position, "position")
        velocity = self.skill.policy(seen)
        parts = velocity.reshape(-1, len(self.frame.origin)) @ self.frame.axes.T
        return np.asarray(parts.reshape(velocity.shape))

    def _led(self, position: Any, dt: float, **others: Any) -> Any:  # Any: each has its own check
        """The position, in the base frame, to which the policy of the skill inside leads."""
        skill: Any = self.skill
        asked = {name: value for name, value in others.items() if value is not None}
        for name in asked.keys() - signature(skill.step).parameters:
            raise UnsupportedQuery(f"{name}: step of a skill of kind {skill.kind!r} takes none")
        after = skill.step(self._local(position, "position"), dt, **asked)
        if not isinstance(after, tuple):
            return after @ self.frame.axes.T + self.frame.origin
        turns = after[1].reshape(-1, 4)
        turns = rotations.compose(self.frame.orientations(len(turns)), turns)
        return after[0] @ self.frame.axes.T + self.frame.origin, turns.reshape(after[1].shape)

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        settings, arrays = archived(self.skill)
        inside = {f"skill_{name}": value for name, value in arrays.items()}
        frame = {"origin": self.frame.origin, "axes": self.frame.axes}
        return {"kind": self.skill.kind, "skill": settings, "poses": self.poses}, inside | frame

    def _stepped(self) -> Any:  # Any: a SteppedSkill, whose `step` a derived class has
        """The skill, which goes on step by step. Raises UnsupportedQuery."""
        if not isinstance(self.skill, SteppedSkill) or "via" not in self.skill.supports:
            raise UnsupportedQuery(
                f"step: a skill of kind {self.skill.kind!r} does not go on step by step from start "
                "to goal; in Python, fit Framed(DMP())"
            )
        return self.skill

    def _seen(self, query: CheckedQuery) -> CheckedQuery:
        return replace(
            query,
            start=self._local(query.start, "start"),
            goal=self._local(query.goal, "goal"),
            obstacles=self._local_shapes(query.obstacles),
            limits=self._limits(query.limits),
            via=self._via(query.via),
            start_velocity=self._velocity(query.start_velocity, "start_velocity"),
            final_velocity=self._velocity(query.final_velocity, "final_velocity"),
        )

    def _require(self, part: str, advice: str = "") -> None:
        """Refuses a part of a query that the skill inside does not take."""
        if part not in self.supports:
            raise UnsupportedQuery(
                f"{part}: a skill of kind {self.skill.kind!r} takes none; it takes "
                f"{', '.join(sorted(self.supports))}{advice}"
            )

    def _via(self, via: Via) -> Via:
        if len(via) == 0:
            return ()
        if not all(isinstance(pair, tuple | list) and len(pair) == 2 for pair in via):
            raise InvalidInput(f"via: expected pairs (phase, point), got {via!r}")
        points = [check.array(point, "via", shape=self.frame.origin.shape) for _, point in via]
        self._require("via")
        seen = [(point - self.frame.origin) @ self.frame.axes for point in points]
        return [(pair[0], point) for pair, point in zip(via, seen, strict=True)]

    def _velocity(self, velocity: ArrayLike | None, name: str) -> Float64Array | None:
        if velocity is None:
            return None
        given = check.array(velocity, name, shape=self.frame.origin.shape)
        self._require(name)
        return np.asarray(given @ self.frame.axes)

    def _limits(
        self, limits: tuple[ArrayLike, ArrayLike] | None
    ) -> tuple[Float64Array, Float64Array] | None:
        """Limits of each column, where the frame's axes are the base's in any order, or None."""
        if limits is None:
            return None
        self._require("limits", "; in Python, fit Framed(DMP())")
        origin, axes = self.frame.origin, self.frame.axes
        corners = checked_limits(limits, origin.shape)
        if np.abs(np.abs(axes).max(axis=0) - 1.0).max() > _ALIGNED:
            raise UnsupportedQuery(
                "limits: base-frame limits are not axis-aligned in a rotated task frame; give "
                "walls as obstacles, or ask the skill inside for limits in its own frame; in "
                "Python, skill.skill.generate(limits=...)"
            )
        rotated = (corners - origin) @ np.round(axes)
        return rotated.min(axis=0), rotated.max(axis=0)

    def _local_shapes(self, obstacles: Sequence[Shape]) -> list[Shape]:
        """Shapes seen from the frame; one of two dimensions lies in the plane z = 0."""
        size = len(self.frame.origin)
        origin, axes = np.zeros(3), np.eye(3)
        origin[:size], axes[:size, :size] = self.frame.origin, self.frame.axes
        back = rotations.inverse(rotations.from_matrix(axes[None]))
        return [
            shape.at(
                (np.asarray(shape.position) - origin) @ axes,
                rotations.compose(back, shape.orientation[None])[0],
            )
            for shape in check_shapes(obstacles)
        ]

    def _local(self, place: Any, name: str) -> Target | None:
        """A place of the base frame, or rows, as seen from the frame; None for None."""
        if place is None:
            return None
        is_pose = self.poses and isinstance(place, tuple | list) and len(place) == 2
        d = len(self.frame.origin)
        given = place[0] if is_pose else place
        position = check.array_of_rank(given, name, shapes=((d,), ("n", d)))
        seen: Float64Array = (position - self.frame.origin) @ self.frame.axes
        if not is_pose:
            return seen
        q = check.quaternions(place[1], name, shape=(*position.shape[:-1], 4))
        turns = q.reshape(-1, 4)
        back = rotations.inverse(self.frame.orientations(len(turns)))
        return seen, rotations.compose(back, turns).reshape(q.shape)


@dataclass(frozen=True, eq=False)
class FramedState:
    """A state in the base frame; made by `FramedSkill.begin` and `FramedSkill.step`.

    Attributes:
        inside: the state as the skill in the frame has it.
        frame: of the task, in the base frame.
    """

    inside: Any
    frame: Frame

    @property
    def phase(self) -> float:
        """From 0 at the start on; 1 is the end."""
        return float(self.inside.phase)

    @property
    def duration(self) -> float:
        """Of the whole motion, s."""
        return float(self.inside.duration)

    @property
    def position(self) -> Float64Array:
        """Of shape (d,)."""
        return np.asarray(self.inside.position @ self.frame.axes.T + self.frame.origin)

    @property
    def velocity(self) -> Float64Array:
        """Of shape (d,), per second."""
        return np.asarray(self.inside.velocity @ self.frame.axes.T)

    @property
    def orientation(self) -> Float64Array:
        """Orientation (4,) of a pose, w, x, y, z."""
        own = self._of_pose("orientation")
        return np.asarray(rotations.compose(self.frame.orientations(1), own[None])[0])

    @property
    def angular_velocity(self) -> Float64Array:
        """Angular velocity (3,) of a pose, rad/s."""
        return np.asarray(self._of_pose("angular_velocity") @ self.frame.axes.T)

    def _of_pose(self, name: str) -> Float64Array:
        if not hasattr(self.inside, name):
            raise UnsupportedQuery(f"{name}: the motion is not one of poses; use position")
        return np.asarray(getattr(self.inside, name))


def from_archive(settings: dict[str, Any], arrays: Arrays) -> FramedSkill:
    skill: Any = from_archived(settings["kind"], settings["skill"], prefixed(arrays, "skill_"))
    frame = Frame(arrays["origin"], arrays["axes"])
    return FramedSkill(Framed(skill.model), skill, frame, bool(settings["poses"]))


def _one_each(
    frames: Sequence[Sequence[Frame]], count: int, size: int, *, poses: bool
) -> list[Frame]:
    given = checked_frames(frames, count, size, poses=poses)
    if len(given[0]) != 1:
        raise InvalidInput(f"frames: expected a sequence of one Frame, got {len(given[0])}")
    return [frame for (frame,) in given]
