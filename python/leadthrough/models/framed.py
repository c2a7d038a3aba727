"""Any model in the frame of its task: shown in one place, followed in another, turned or moved.

The demonstrations are seen from a frame that is given with each of them, at an object or a table.
The skill that is learned there is followed in the frame where the object is now. What a query says,
start, goal and obstacles, is in the base frame. For several frames at once: `TaskGMR`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Generic, TypedDict, cast

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.models.archive import Archived, Arrays
from leadthrough.models.demonstrated import Demonstrations, motions_of
from leadthrough.models.frame import Frame
from leadthrough.models.framed_state import FramedState
from leadthrough.models.parameters import Parameter
from leadthrough.models.place import Place
from leadthrough.models.protocol import Guided, Model, Skill, Stepped
from leadthrough.models.unfitted import Unfitted
from leadthrough.motion import Motion, MotionT, MotionT_co, PoseTrajectory
from leadthrough.shapes import Shape, check_shapes

Via = Sequence[tuple[float, ArrayLike]]


class _Beyond(TypedDict, total=False):
    """Parts of a query that only some skills take."""

    via: Via
    start_velocity: ArrayLike
    final_velocity: ArrayLike


@dataclass(frozen=True)
class Framed(Unfitted):
    """A model that learns in the frame of the task.

    Attributes:
        model: any model, such as `PoseDMP()`.
    """

    model: Model

    def fit(
        self,
        demonstrations: Demonstrations[MotionT],
        *,
        frames: Sequence[Sequence[Frame]] | None = None,
    ) -> FramedSkill[MotionT]:
        """A skill from demonstrations and their frames; it is in the frame of the first one.

        Args:
            demonstrations: those that the model learns from, in the base frame.
            frames: one for each demonstration, in a sequence of its own as for `TaskGMR`. Right-
                handed for poses. By default that of its last sample.

        Raises:
            InvalidInput: if the frames do not fit the demonstrations, or for motions that the model
                does not learn.
            FitError: as the model raises it.
        """
        motions = motions_of(demonstrations)
        if frames is None:
            frames = [[Frame.of_sample(motion, -1)] for motion in motions]
        if not isinstance(frames, Sequence) or len(frames) != len(motions):
            raise InvalidInput(f"frames: expected one per demonstration, {len(motions)} in all")
        poses = isinstance(motions[0], PoseTrajectory)
        given = [_the_frame(each, len(motions[0].positions[0]), poses) for each in frames]
        seen = [_seen(frame, motion) for frame, motion in zip(given, motions, strict=True)]
        learned = cast(Skill[MotionT], self.model.fit(seen))  # of the type that was shown
        return FramedSkill(self, learned, given[0], poses)


@dataclass(frozen=True, eq=False)
class FramedSkill(Archived, Generic[MotionT_co]):
    """A skill in the frame of its task; made by `Framed.fit`.

    Attributes:
        model: the settings that it was fitted with.
        skill: what was learned, seen from the frame.
        frame: where the frame is now, in the base frame.
        poses: whether its motions are poses.
    """

    model: Framed
    skill: Skill[MotionT_co]
    frame: Frame
    poses: bool

    kind: ClassVar[str] = "framed"

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours."""
        return self.skill.supports

    def at(self, frames: Sequence[Frame]) -> FramedSkill[MotionT_co]:
        """The skill in a new situation.

        Args:
            frames: the frame of the situation, one in a sequence as for `TaskGMR`.

        Raises:
            InvalidInput: if it is not one frame, or of other dimensions.
        """
        return replace(self, frame=_the_frame(frames, len(self.frame.origin), self.poses))

    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
        via: Via = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
    ) -> MotionT_co:
        """A motion in the base frame; what is left out is as shown, seen from the frame.

        Args:
            start: in the base frame.
            goal: in the base frame.
            duration: s, > 0.
            dt: s, > 0, upper bound of the sampling step.
            obstacles: shapes to keep clear of, in the base frame.
            via: (fraction of the duration in (0, 1), point (d,) in the base frame), in order.
            start_velocity: (d,) per second, in the base frame.
            final_velocity: as start_velocity.

        Raises:
            InvalidInput: if an argument is wrong.
            UnsupportedQuery: for a part that is not among `supports`.
            NoPath: where obstacles leave no way.
        """
        start, goal = self._local(start, "start"), self._local(goal, "goal")
        shapes = self._local_shapes(obstacles)
        beyond = self._beyond(via, start_velocity, final_velocity)
        if not beyond:
            made = self.skill.generate(
                start=start, goal=goal, duration=duration, dt=dt, obstacles=shapes
            )
            return self.frame.base(made)
        stepped = self._stepped()
        moved = stepped.generate(
            start=start, goal=goal, duration=duration, dt=dt, obstacles=shapes, **beyond
        )
        return cast(MotionT_co, self.frame.base(moved))  # of the type that was shown

    def begin(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        via: Via = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
    ) -> FramedState:
        """The state at the start, for `step`.

        Args:
            start: as in `generate`.
            goal: as in `generate`.
            duration: as in `generate`.
            via: as in `generate`.
            start_velocity: as in `generate`.
            final_velocity: as in `generate`.

        Raises:
            InvalidInput: if an argument is wrong.
            UnsupportedQuery: for a part that is not among `supports`, and for a skill that does not
                go on step by step.
        """
        state = self._stepped().begin(
            start=self._local(start, "start"),
            goal=self._local(goal, "goal"),
            duration=duration,
            **self._beyond(via, start_velocity, final_velocity),
        )
        return FramedState(state, self.frame)

    def step(
        self,
        state: FramedState,
        dt: float,
        *,
        goal: Place | None = None,
        coupling: ArrayLike | None = None,
        lag: float = 0.0,
        measured: Place | None = None,
        obstacles: Sequence[Shape] = (),
    ) -> FramedState:
        """The state dt s later.

        The frame may have moved since the last step, as by `at`: the motion goes on in it.

        Args:
            state: from `begin` or the last step.
            dt: s, > 0.
            goal: moves the goal, in the base frame.
            coupling: (d,) acceleration in the base frame, or of poses (6,) with an angular one.
            lag: >= 0; this step runs 1 / (1 + lag) as fast.
            measured: in the base frame, where the motion goes on from.
            obstacles: to keep clear of in this step, in the base frame.

        Raises:
            InvalidInput: if an argument is wrong.
            UnsupportedQuery: for a skill that does not go on step by step.
        """
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
        )
        return FramedState(after, self.frame)

    def policy(self, position: ArrayLike) -> Float64Array:
        """The velocity (d,) that leads from a position to the goal, both in the base frame.

        Args:
            position: (d,).

        Raises:
            InvalidInput: if the position is of another shape.
            UnsupportedQuery: for a skill without a policy.
            NoPath: far outside the demonstrations.
        """
        if not isinstance(self.skill, Guided):
            raise UnsupportedQuery(
                f"policy: a skill of kind {self.skill.kind!r} has none; in Python, fit "
                "Framed(FastMarching())"
            )
        seen = (self._point(position, "position") - self.frame.origin) @ self.frame.axes
        return np.asarray(self.skill.policy(seen) @ self.frame.axes.T)

    def parameters(
        self,
        demonstrations: Demonstrations[Motion] = (),  # noqa: ARG002 (there is no new fit)
    ) -> Sequence[Parameter[MotionT_co]]:
        """None: the demonstrations do not tell where their frames were.

        Args:
            demonstrations: those that it was fitted to.
        """
        return []

    # Any: settings are whatever JSON holds.
    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        """Settings and arrays that `from_archive` puts together again."""
        settings, arrays = self.skill.to_archive()
        inside = {f"skill_{name}": value for name, value in arrays.items()}
        frame = {"origin": self.frame.origin, "axes": self.frame.axes}
        return {"kind": self.skill.kind, "skill": settings, "poses": self.poses}, inside | frame

    def _stepped(self) -> Stepped:
        """The skill, which goes on step by step. Raises UnsupportedQuery."""
        if not isinstance(self.skill, Stepped) or "via" not in self.skill.supports:
            raise UnsupportedQuery(
                f"step: a skill of kind {self.skill.kind!r} does not go on step by step from start "
                "to goal; in Python, fit Framed(DMP()) or Framed(PoseDMP())"
            )
        return self.skill

    def _beyond(
        self, via: Via, start_velocity: ArrayLike | None, final_velocity: ArrayLike | None
    ) -> _Beyond:
        """The parts of a query that only some skills take, seen from the frame.

        Raises:
            InvalidInput: if one is of another shape.
            UnsupportedQuery: for one that the skill does not take.
        """
        found = _Beyond()
        if not isinstance(via, Sequence):
            raise InvalidInput(f"via: expected a sequence of (phase, point), got {via!r}")
        if len(via) > 0:
            if not all(isinstance(pair, tuple | list) and len(pair) == 2 for pair in via):
                raise InvalidInput(f"via: expected pairs (phase, point), got {via!r}")
            points = [self._point(point, "via") for _, point in via]
            found["via"] = [
                (pair[0], (point - self.frame.origin) @ self.frame.axes)
                for pair, point in zip(via, points, strict=True)
            ]
        if start_velocity is not None:
            found["start_velocity"] = (
                self._point(start_velocity, "start_velocity") @ self.frame.axes
            )
        if final_velocity is not None:
            found["final_velocity"] = (
                self._point(final_velocity, "final_velocity") @ self.frame.axes
            )
        for name in found:
            if name not in self.supports:
                raise UnsupportedQuery(
                    f"{name}: a skill of kind {self.skill.kind!r} takes none; it takes "
                    f"{', '.join(sorted(self.supports))}"
                )
        return found

    def _point(self, value: ArrayLike, name: str) -> Float64Array:
        return check.array(value, name, shape=(len(self.frame.origin),))

    def _local_shapes(self, obstacles: Sequence[Shape]) -> list[Shape]:
        return [_local_shape(self.frame, shape) for shape in check_shapes(obstacles)]

    def _local(self, place: Any, name: str) -> Place | None:
        """A place of the base frame as it is seen from the frame. Raises InvalidInput."""
        if place is None:
            return None
        turned = self.poses and isinstance(place, tuple | list) and len(place) == 2
        given = place[0] if turned else place
        position = check.array(given, name, shape=(len(self.frame.origin),))
        seen: Float64Array = (position - self.frame.origin) @ self.frame.axes
        if not turned:
            return seen
        q = check.quaternions(place[1], name, shape=(4,))
        back = rotations.inverse(self.frame.orientations(1))
        return seen, rotations.compose(back, q[None])[0]


def from_archive(skill: Skill, settings: Mapping[str, Any], arrays: Arrays) -> FramedSkill:
    """The skill that `FramedSkill.to_archive` took apart, but for the skill inside.

    Args:
        skill: the one inside.
        settings: as `to_archive` returned them.
        arrays: as `to_archive` returned them.

    Raises:
        KeyError: if a part is missing.
        InvalidInput: if a part is not what it should be.
    """
    frame = Frame(arrays["origin"], arrays["axes"])
    return FramedSkill(Framed(skill.model), skill, frame, bool(settings["poses"]))


def _the_frame(frames: Sequence[Frame], size: int, poses: bool) -> Frame:
    """The one frame. Raises InvalidInput."""
    given = list(frames) if isinstance(frames, Sequence) else []
    if len(given) != 1 or not isinstance(given[0], Frame):
        raise InvalidInput(f"frames: expected a sequence of one Frame, got {frames!r}")
    if len(given[0].origin) != size:
        raise InvalidInput(f"frames: expected {size} dimensions, got {len(given[0].origin)}")
    if poses and np.linalg.det(given[0].axes) < 0.0:
        raise InvalidInput("frames: expected right-handed axes for poses")
    return given[0]


def _seen(frame: Frame, motion: MotionT) -> MotionT:
    """A motion as it is seen from a frame, with its events."""
    back = Frame(-frame.origin @ frame.axes, frame.axes.T)
    return back.base(motion)


def _local_shape(frame: Frame, shape: Shape) -> Shape:
    """A shape of the base frame as it is seen from the frame."""
    size = len(frame.origin)
    origin, axes = np.zeros(3), np.eye(3)
    origin[:size], axes[:size, :size] = frame.origin, frame.axes
    position = (np.asarray(shape.position) - origin) @ axes
    if not hasattr(shape, "orientation"):
        return replace(shape, position=position)
    back = rotations.inverse(rotations.from_matrix(axes[None]))
    turned = rotations.compose(back, np.asarray(shape.orientation)[None])[0]
    return replace(shape, position=position, orientation=turned)
