"""Motions and demonstrations: frozen, checked, with read-only copies of the data.

Their events are names with times, such as a gripper that closes. Whatever changes a motion's clock
passes its events through `moved_events`, so that they stay at their places along the path. A skill
stores its events at fractions, 0 to 1, of its duration.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import TYPE_CHECKING, Any, Generic, Self, TypeAlias, TypeVar, cast
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput, numbers_text, one_line
from leadthrough.drawing import Drawn, of_joints, of_points, of_poses

# A point or joints (d,); of poses a position (3,), or (position (3,), orientation (4,) w, x, y, z).
Target: TypeAlias = ArrayLike | tuple[ArrayLike, ArrayLike]

_FIELDS = ("positions", "orientations", "velocities", "accelerations")


def rows_of(recorded: object) -> dict[str, Any]:
    """The arrays (n, k) of a motion or recording that there are, by their fields, but the times."""
    found = {name: getattr(recorded, name, None) for name in _FIELDS}
    if (joints := getattr(recorded, "joints", None)) is not None:
        found["joints"] = joints.positions
    return {name: rows for name, rows in found.items() if rows is not None}


def fields_of(recorded: object, rows: Mapping[str, Any]) -> dict[str, Any]:
    """The arrays as `rows_of` returns them, as the fields of a motion or recording."""
    joints, own = rows.get("joints"), getattr(recorded, "joints", None)
    if joints is None or own is None:
        return dict(rows)
    # The motion puts them on its own clock.
    counted = type(own)(range(len(joints)), joints, joint_names=own.joint_names)
    return {**rows, "joints": counted}


@dataclass(frozen=True, order=True)
class Event:
    """Something that happens at one time of a motion.

    Attributes:
        time: s, on the clock of the motion.
        name: action or observation, such as "close gripper"; not blank.
    """

    time: float
    name: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "time", check.number(self.time, "time"))
        if not isinstance(self.name, str):
            raise InvalidInput(f"name: expected the event's name as text, got {self.name!r}")
        if not self.name.strip():
            raise InvalidInput(f"name: expected an event's name, got blank text {self.name!r}")


Events = tuple[Event, ...]


class Sampled(Drawn):
    """Samples at times; the motions derive from it."""

    times: Float64Array
    positions: Float64Array
    events: Events

    def __len__(self) -> int:
        return len(self.times)

    def __getitem__(self, samples: slice) -> Self:
        """The motion of some samples, at their own times, with the events between them."""
        if not isinstance(samples, slice):
            raise InvalidInput(
                f"samples: expected a slice such as motion[10:20], got {samples!r}; `positions` "
                "has single samples, and `at` gives the position at a time"
            )
        times = self.times[samples]
        if len(times) == 0:
            raise InvalidInput(
                f"samples: expected some of the {len(self.times)} samples, got none in {samples}"
            )
        between = events_within(self.events, float(times[0]), float(times[-1]))
        rows = {name: rows[samples] for name, rows in rows_of(self).items()}
        motion: Any = self  # a dataclass, of whichever type
        piece: Self = replace(motion, times=times, events=between, **fields_of(self, rows))
        return piece

    def _places(self, times: ArrayLike) -> tuple[bool, Float64Array, Float64Array]:
        """Whether there are several times, these (m,), and the positions (m, d) then."""
        given = check.array_of_rank(times, "time", shapes=((), ("m",)))
        at = np.atleast_1d(given)
        first, last = self.times[0], self.times[-1]
        outside = (at < first) | (at > last)
        if outside.any():
            raise check.refused("time", f"{first:.6g} to {last:.6g} s", f"{at[outside][0]:.6g} s")
        return given.ndim > 0, at, lerp(at, self.times, self.positions)

    def _repr_parts(self) -> list[str]:
        span = f"{len(self.times)} samples over {self.duration:.4g} s"
        names = [event.name for event in self.events]
        return [span, *self._summary(), *([f"events {', '.join(names)}"] if names else [])]

    def _summary(self) -> list[str]:
        first, last = (numbers_text(row) for row in self.positions[[0, -1]])
        return [f"{first} to {last}"]

    @property
    def _marks(self) -> list[tuple[float, str]]:
        return [(event.time, event.name) for event in self.events]

    @property
    def duration(self) -> float:
        """Time from the first sample to the last, s."""
        return float(self.times[-1] - self.times[0])


class SampledRows(Sampled):
    """Points or joints at times."""

    def at(self, time: ArrayLike) -> Float64Array:
        """Position or joints (d,) at a time in s, or (m, d) at times (m,); linear between."""
        several, _, points = self._places(time)
        return points if several else points[0]


@dataclass(frozen=True, eq=False, init=False)
class Trajectory(SampledRows):
    """Timed points.

    Attributes:
        times: (n,) s, strictly increasing.
        positions: (n, d) m; drawings may use any unit.
        events: at times between the first and the last sample, in their order.
        joints: as of a `PoseTrajectory`.
    """

    times: Float64Array
    positions: Float64Array
    events: Events
    joints: JointTrajectory | None = None

    def __init__(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        events: Sequence[Event] = (),
        joints: JointTrajectory | None = None,
    ) -> None:
        clock = check.times(times, "times")
        vars(self).update(
            times=clock,
            positions=_rows(positions, "positions", len(clock), "d"),
            events=_checked_events(events, clock),
            joints=_joints(joints, clock),
        )

    def _panels(self, deviations: Float64Array | None = None) -> list[Panel]:
        return of_points(self.times, self.positions, self._marks, deviations=deviations)


@dataclass(frozen=True, eq=False, init=False)
class PoseTrajectory(Sampled):
    """Timed poses in one frame.

    Attributes:
        times: (n,) s, strictly increasing.
        positions: (n, 3) m.
        orientations: (n, 4) w, x, y, z; normalised and made sign-continuous on entry.
        events: at times between the first and the last sample, in their order.
        joints: of the arm that moved so, n samples on the motion's own clock, or None. In a motion
            that a skill generated they are those that the arm was shown with at the same phase:
            where a start or goal is new, the posture to stay near to.
    """

    times: Float64Array
    positions: Float64Array
    orientations: Float64Array
    events: Events
    joints: JointTrajectory | None = None

    def __init__(
        self,
        times: ArrayLike,
        positions: ArrayLike,
        orientations: ArrayLike,
        events: Sequence[Event] = (),
        joints: JointTrajectory | None = None,
    ) -> None:
        clock = check.times(times, "times")
        count = len(clock)
        kept_events = _checked_events(events, clock)
        points = _rows(positions, "positions", count, 3)
        quaternions = check.quaternions(orientations, "orientations", shape=(count, 4))
        vars(self).update(
            times=clock,
            positions=points,
            orientations=check.freeze(rotations.group.aligned(quaternions)),
            events=kept_events,
            joints=_joints(joints, clock),
        )

    def at(self, time: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Position (3,) and orientation (4,) at a time in s, as skills take a start or goal.

        Between samples it moves straight and turns at constant velocity. Several times (m,) give
        (m, 3) and (m, 4).
        """
        several, at, points = self._places(time)
        if len(self.times) == 1:
            orientations = np.repeat(self.orientations, len(at), axis=0)
        else:
            orientations = rotations.interpolate(self.times, self.orientations, at)
        return (points, orientations) if several else (points[0], orientations[0])

    def _panels(self, deviations: Float64Array | None = None) -> list[Panel]:
        return of_poses(
            self.times, self.positions, self.orientations, self._marks, deviations=deviations
        )

    def _summary(self) -> list[str]:
        angle = float(rotations.distance(self.orientations[:1], self.orientations[-1:])[0])
        return [f"{super()._summary()[0]} m, turned by {angle:.3g} rad"]


@dataclass(frozen=True, eq=False, init=False)
class JointTrajectory(SampledRows):
    """Timed joint configurations, in rad; prismatic joints in m.

    Attributes:
        times: (n,) s, strictly increasing.
        positions: (n, joints) rad.
        velocities: (n, joints) rad/s, or None.
        accelerations: (n, joints) rad/s^2, or None.
        joint_names: one per column, or none at all.
        events: at times between the first and the last sample, in their order.
    """

    times: Float64Array
    positions: Float64Array
    velocities: Float64Array | None
    accelerations: Float64Array | None
    joint_names: tuple[str, ...]
    events: Events

    def __init__(  # noqa: PLR0917 (as they were always given: arrays first, then what goes along)
        self,
        times: ArrayLike,
        positions: ArrayLike,
        velocities: ArrayLike | None = None,
        accelerations: ArrayLike | None = None,
        joint_names: Sequence[str] = (),
        events: Sequence[Event] = (),
    ) -> None:
        clock = check.times(times, "times")
        kept_events = _checked_events(events, clock)
        angles = _rows(positions, "positions", len(clock), "joints")
        derivatives = {
            name: None if rows is None else _rows(rows, name, *angles.shape)
            for name, rows in (("velocities", velocities), ("accelerations", accelerations))
        }
        vars(self).update(
            times=clock,
            positions=angles,
            **derivatives,
            joint_names=check.names(joint_names, "joint_names", count=angles.shape[1]),
            events=kept_events,
        )

    def _panels(self, deviations: Float64Array | None = None) -> list[Panel]:
        return of_joints(
            self.times, self.positions, self.velocities, self.joint_names, self._marks,
            deviations=deviations,
        )  # fmt: skip

    def _summary(self) -> list[str]:
        count = self.positions.shape[1]
        names = f"{self.joint_names[0]} ... {self.joint_names[-1]}, " if self.joint_names else ""
        lacking = [name for name in ("velocities", "accelerations") if getattr(self, name) is None]
        without = [f"without {' and '.join(lacking)}"] if lacking else []
        return [f"{names}{count} joints", *without]


Motion = Trajectory | PoseTrajectory | JointTrajectory
if TYPE_CHECKING:
    # Type checkers bring typing_extensions. By the default, a plain `Demonstration` is one of any
    # motion; typing.TypeVar takes defaults from Python 3.13 on.
    from typing_extensions import TypeVar as _TypeVar

    from leadthrough.drawing import Panel

    MotionT = _TypeVar("MotionT", bound=Motion, default=Motion)
    MotionT_co = _TypeVar("MotionT_co", bound=Motion, default=Motion, covariant=True)
else:
    MotionT = TypeVar("MotionT", bound=Motion)
    MotionT_co = TypeVar("MotionT_co", bound=Motion, covariant=True)
_Found = TypeVar("_Found")


def normalised_times(times: Float64Array) -> Float64Array:
    """Fractions (n,) of the duration passed at increasing times (n,), from 0 to 1; 0 if n is 1."""
    if len(times) == 1:
        return np.zeros(1)
    return np.asarray((times - times[0]) / (times[-1] - times[0]))


def target_of(motion: Motion, row: int) -> Target:
    """A sample of a motion, as a skill is asked for it."""
    position: Float64Array = motion.positions[row]
    return (position, motion.orientations[row]) if isinstance(motion, PoseTrajectory) else position


def lerp(at: NDArray[Any], places: NDArray[Any], rows: Float64Array) -> Float64Array:
    """Rows (m, width) at places (m,), linearly between rows (n, width) at rising places (n,)."""
    return np.column_stack([np.interp(at, places, column) for column in rows.T])


def kept(find: Callable[[Any], _Found]) -> Callable[[Any], _Found]:
    """The function of a motion, its results kept as long as the motion is in use."""
    known = WeakKeyDictionary[Motion, _Found]()
    return lambda each: known[each] if each in known else known.setdefault(each, find(each))


def thin(motion: MotionT, rows: int) -> MotionT:
    """About as many samples of a longer motion, with the last one, to which it leads."""
    step = -(-len(motion.times) // rows)
    if step == 1:
        return motion
    some = cast(MotionT, motion[(len(motion.times) - 1) % step :: step])
    return replace(some, events=clipped_events(motion.events, some.times))


def joints_with(motion: Motion) -> JointTrajectory | None:
    """The joints that go along with a motion of the tip, if it has any."""
    return None if isinstance(motion, JointTrajectory) else motion.joints


def checked_motion(value: MotionT, name: str) -> MotionT:
    if not isinstance(value, Motion):
        raise InvalidInput(
            f"{name}: expected a Trajectory, PoseTrajectory or JointTrajectory, "
            f"got {type(value).__name__}{check.part_to_give(value)}"
        )
    return value


@dataclass(frozen=True, eq=False, init=False)
class Demonstration(Drawn, Generic[MotionT_co]):
    """One motion demonstrated to the robot, such as a `Demonstration[JointTrajectory]`.

    Attributes:
        motion: the demonstrated motion; `joints` that are given become the motion's own.
        name: for messages and files.
    """

    motion: MotionT_co
    name: str

    def __init__(
        self, motion: MotionT_co, name: str = "", joints: JointTrajectory | None = None
    ) -> None:
        given = checked_motion(motion, "motion")
        if joints is not None:
            given = _with_joints(given, joints)
        vars(self).update(motion=given, name=name)

    @property
    def events(self) -> Events:
        """Events of the motion."""
        return self.motion.events

    @property
    def joints(self) -> JointTrajectory | None:
        """The arm's joints during the motion of its tip, or None; for joints, the motion itself."""
        return _of_arm(self.motion)

    def _repr_parts(self) -> list[str]:
        return [repr(self.name), one_line(self.motion)]

    def _panels(self) -> list[Panel]:
        return self.motion._panels()


def as_demonstration(value: Demonstration[MotionT] | MotionT, name: str) -> Demonstration[MotionT]:
    """The demonstration; a motion alone becomes one without a name."""
    if isinstance(value, Demonstration):
        return value
    if isinstance(value, Motion):
        return Demonstration(value)
    raise InvalidInput(f"{name}: expected a Demonstration or a motion, got {type(value).__name__}")


def _with_joints(motion: MotionT, joints: JointTrajectory) -> MotionT:
    """The motion with joints that were recorded beside it, at the motion's times."""
    if isinstance(motion, JointTrajectory):
        raise InvalidInput("joints: the motion consists of joints itself; leave them out")
    check.instance(joints, "joints", JointTrajectory)
    apart = np.abs(joints.times[[0, -1]] - motion.times[[0, -1]]).max()
    step = np.diff(joints.times).max(initial=0.0)
    if not (apart <= step or np.array_equal(joints.times, motion.times)):
        (a, b), (c, d) = motion.times[[0, -1]], joints.times[[0, -1]]
        raise InvalidInput(
            f"joints: expected the motion's times, {a:.6g} to {b:.6g} s, got {c:.6g} to {d:.6g} s"
        )
    rows = lerp(motion.times, joints.times, joints.positions)
    own = JointTrajectory(motion.times, rows, joint_names=joints.joint_names)
    return replace(motion, joints=own)


def _joints(joints: JointTrajectory | None, clock: Float64Array) -> JointTrajectory | None:
    """Positions and names of joints, one sample for each of the motion's, on its clock."""
    if joints is None:
        return None
    check.instance(joints, "joints", JointTrajectory)
    if len(joints.times) != len(clock):
        raise check.refused(
            "joints", f"{len(clock)} samples, one for each of the motion's", len(joints.times)
        )
    bare = rows_of(joints).keys() == {"positions"} and not joints.events
    if bare and np.array_equal(joints.times, clock):
        return joints
    return JointTrajectory(clock, joints.positions, joint_names=joints.joint_names)


def _rows(value: ArrayLike, name: str, count: int, width: int | str) -> Float64Array:
    rows = check.frozen(value, name, shape=(count, width))
    if rows.shape[1] == 0:
        raise InvalidInput(f"{name}: expected at least one column, got none")
    return rows


def computed_joints(
    times: Float64Array,
    positions: Float64Array,
    velocities: Float64Array,
    accelerations: Float64Array,
    *,
    joint_names: tuple[str, ...],
    events: Events = (),
) -> JointTrajectory:
    """Joints of arrays just computed, which are not checked or copied and become read-only."""
    return check.computed(
        JointTrajectory,
        times=times,
        positions=positions,
        velocities=velocities,
        accelerations=accelerations,
        joint_names=joint_names,
        events=events,
    )


def in_order(motion: object, names: Sequence[str], argument: str) -> JointTrajectory:
    """The joints as columns in the order of `names`; columns without names are in this order."""
    if not isinstance(motion, JointTrajectory):
        what = f"{type(motion).__name__}{check.part_to_give(motion)}"
        raise check.refused(argument, "a JointTrajectory", what)
    wanted = tuple(names)
    if motion.joint_names == wanted:
        return motion
    if not motion.joint_names:
        if (count := motion.positions.shape[1]) != len(wanted):
            expected = f"{len(wanted)} joints ({', '.join(wanted)})"
            raise check.refused(argument, expected, f"{count} without names")
        return replace(motion, joint_names=wanted)
    return _selected(motion, wanted, argument)


def alike(motions: Sequence[MotionT], argument: str) -> list[MotionT]:
    """The motions with their joints, those beside a tip's too, in the order of the first's."""
    named = [joints.joint_names for each in motions if (joints := _of_arm(each)) is not None]
    return [
        _like(each, named[0], f"{argument}[{i}]") if named else each
        for i, each in enumerate(motions)
    ]


def _of_arm(motion: Motion) -> JointTrajectory | None:
    """The joints that a motion consists of, or that go along with it."""
    return motion if isinstance(motion, JointTrajectory) else motion.joints


def _like(motion: MotionT, names: tuple[str, ...], argument: str) -> MotionT:
    joints = _of_arm(motion)
    if joints is None or joints.joint_names == names:
        return motion
    ordered: Any = _selected(joints, names, argument)
    return ordered if joints is motion else replace(motion, joints=ordered)


def _selected(joints: JointTrajectory, names: tuple[str, ...], argument: str) -> JointTrajectory:
    """The joints with their named columns in the order of `names`."""
    return columns_of(joints, check.column_order(joints.joint_names, names, argument), names)


def columns_of(
    joints: JointTrajectory, columns: Sequence[int], names: tuple[str, ...]
) -> JointTrajectory:
    """Some columns of a motion, which have names of their own."""
    rows = {name: rows[:, columns] for name, rows in rows_of(joints).items()}
    return replace(joints, joint_names=names, **rows)


def with_derivatives(motion: JointTrajectory) -> JointTrajectory:
    """The motion with velocities and accelerations; those missing are slopes of cubic splines."""
    # Velocities are of the one that starts and ends at rest, accelerations of "not a knot".
    velocities, accelerations = motion.velocities, motion.accelerations
    if velocities is not None and accelerations is not None:
        return motion
    if velocities is None:
        velocities = _slopes(motion.times, motion.positions, at_rest=True)
    if accelerations is None:
        accelerations = _slopes(motion.times, velocities, at_rest=False)
    rates = {"velocities": velocities, "accelerations": accelerations}
    return check.computed(JointTrajectory, **{**vars(motion), **rates})


def _slopes(times: Float64Array, values: Float64Array, *, at_rest: bool) -> Float64Array:
    """Slopes (n, joints) of the cubic spline through values (n, joints)."""
    if len(times) == 1:
        return np.zeros_like(values)
    return core.spline_slopes(times - times[0], np.ascontiguousarray(values), at_rest)


def _checked_events(value: object, times: Float64Array) -> Events:
    if not isinstance(value, Sequence):
        raise check.refused("events", "a sequence of Event", type(value).__name__)
    for i, each in enumerate(value):
        check.instance(each, f"events[{i}]", Event, "an Event")
    for event in value:
        if not times[0] <= event.time <= times[-1]:
            raise InvalidInput(
                f"events: expected times within the motion, {times[0]:.6g} to {times[-1]:.6g} s, "
                f"got {event.name!r} at {event.time:.6g} s"
            )
    return tuple(sorted(value))


def moved_events(events: Events, old: ArrayLike, new: ArrayLike) -> Events:
    """The events on another clock."""
    if not events:
        return ()
    before, after = np.asarray(old), np.asarray(new)
    times = np.array([event.time for event in events])
    # From the end backwards: of several equal times np.interp takes the last.
    found = np.clip(np.interp(-times, -before[::-1], after[::-1]), after[0], after[-1])
    return tuple(Event(float(time), event.name) for time, event in zip(found, events, strict=True))


def events_within(events: Events, first: float, last: float) -> Events:
    """The events from `first` to `last`, s, both included."""
    return tuple(event for event in events if first <= event.time <= last)


def clipped_events(events: Events, times: Float64Array) -> Events:
    """All events, those outside of a motion's times (n,) moved to its nearer end."""
    return tuple(
        Event(float(np.clip(event.time, times[0], times[-1])), event.name) for event in events
    )


def agreed_events(demonstrated: Sequence[Events], weights: ArrayLike | None = None) -> Events:
    """The events that most of several motions have, at the weighted mean of their times."""
    each_weight = np.ones(len(demonstrated)) if weights is None else np.asarray(weights)
    seen: dict[tuple[str, int], list[tuple[float, float]]] = defaultdict(list)
    for events, weight in zip(demonstrated, each_weight, strict=True):
        numbers: dict[str, count[int]] = defaultdict(count)
        for event in events:
            seen[event.name, next(numbers[event.name])].append((event.time, float(weight)))
    half = 0.5 * float(each_weight.sum())
    return tuple(
        sorted(
            Event(float(np.average(times, weights=own)), name)
            for (name, _), found in seen.items()
            for times, own in [tuple(zip(*found, strict=True))]
            if sum(own) > half
        )
    )


def plain_events(events: Events) -> list[list[float | str]]:
    """The events as [time, name] pairs, which JSON can hold."""
    return [[event.time, event.name] for event in events]


def events_of_plain(value: Iterable[tuple[float, str]]) -> Events:
    return tuple(Event(*each) for each in value)
