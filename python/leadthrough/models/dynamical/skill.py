"""A skill that is a dynamical system: motions, the velocity anywhere, and its stability."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar, Generic

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.models.archive import Arrays, FittedSkill, prefixed
from leadthrough.models.coordinates import NODES, Coordinates
from leadthrough.models.dynamical.field import (
    MAX_DISTANCE,
    Field,
    StabilityReport,
    advanced,
    goal_trajectory,
    stability_report,
)
from leadthrough.models.queries import CheckedQuery, even_times
from leadthrough.models.registry import entry_of_class
from leadthrough.motion import MotionT_co, Target, normalised_times

_MAX_STEP = 100.0  # durations of the demonstrations


@dataclass(frozen=True, eq=False)
class DynamicalSkill(FittedSkill[MotionT_co]):
    """A system x' = f(x) whose trajectories all end at the goal; made by `fit` of its model.

    It has no clock: wherever a tool is pushed to, `policy` leads it on from there. `generate`
    returns the trajectory from a start, continued to rest at the goal over its last 5 %; the whole
    system moves with the goal. By default it lasts as long as the system takes, at most 100 times
    the demonstrations' duration.

    Attributes:
        model: the settings that it was fitted with.
        coordinates: of the d columns: of points, joints, or for poses the position and a
            rotation vector from the goal's orientation.
        field: the system, in normalised columns about the goal and durations.
        scale: divisors (d,) of the columns.
        ends: mean start and goal (2, d) of the demonstrations.
        demonstrated_duration: median duration of the demonstrations, s.
        pace: factor of the system's own speed, with which it takes as long from the
            demonstrations' starts as they took.
        positions: normalised positions (n, d) of the demonstrations, about the goal.
    """

    model: Any  # one of the models of this family, whose settings differ
    coordinates: Coordinates[MotionT_co]
    field: Field
    scale: Float64Array
    ends: Float64Array
    demonstrated_duration: float
    pace: float
    positions: Float64Array

    kind: ClassVar[str] = "dynamical"
    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration"})

    def policy(self, position: ArrayLike, *, goal: Target | None = None) -> Float64Array:
        """Velocity at a position, leading to the goal.

        Args:
            position: position or joints (d,), or rows (n, d) of them; for poses (position (3,),
                orientation (4,) as w, x, y, z), or rows (n, 3) and (n, 4).
            goal: its end; by default the demonstrations' mean goal.

        Returns:
            Velocity (d,), or (n, d), per second; of a pose (6,) or (n, 6): linear and angular, in
            the base frame, m/s and rad/s.
        """
        here, x, is_one = self._rows(position, goal)
        columns = self._velocities(x)
        if self.coordinates.kind == "poses":
            vectors = x[:, 3:] * self.scale[3:]
            columns[:, 3:] = twist(here.coordinates, vectors, columns[:, 3:])
        return np.asarray(columns[0]) if is_one else columns

    def step(self, position: ArrayLike, dt: float, *, goal: Target | None = None) -> Any:
        """The position that the system reaches from a position within dt.

        Take it in a control loop instead of `position + dt * policy(position)`, which stops short
        of the goal where the velocity turns quicker than once per step: the system is integrated
        in steps as short as it needs.

        Args:
            position: as for `policy`.
            dt: s, > 0.
            goal: as for `policy`.

        Returns:
            Position or positions in the form of the argument.

        Raises:
            InvalidInput: beyond a thousand sizes of the demonstrations.
        """
        longest = _MAX_STEP * self.demonstrated_duration
        span = check.number(dt, "dt", above=0.0, at_most=longest)
        here, x, is_one = self._rows(position, goal)
        after = here.columns(advanced(self.field, x, span * self.pace / self.demonstrated_duration))
        if self.coordinates.kind == "poses":
            turns = here.coordinates.orientations(after[:, 3:], np.ones(len(after)))
            return (after[0, :3], turns[0]) if is_one else (after[:, :3], turns)
        return after[0] if is_one else after

    def _answer(self, query: CheckedQuery) -> MotionT_co:
        here = self._situation(query.start, query.goal)
        path = goal_trajectory(self.field, here.start)
        times = even_times(query.end(self._seconds(path.duration)), query.dt)
        phases = normalised_times(times)
        columns = here.columns(path.at(phases))
        return here.coordinates.motion(times, phases, columns)

    @property
    def duration(self) -> float:
        """Duration of the nominal motion, s."""
        path = goal_trajectory(self.field, self._situation(None, None).start)
        return self._seconds(path.duration)

    def stability(
        self, starts: int = 10_000, *, around: float = 1.0, seed: int = 0
    ) -> StabilityReport:
        """Report of trajectories from many starts: whether they arrive and their energies fall.

        Args:
            starts: number of starts, >= 1: half drawn evenly in a box around the demonstrations,
                half about their samples.
            around: enlargement of the box on each side, in extents of the demonstrations.
            seed: seed of the random number generator that draws the starts.
        """
        check.affordable_count(starts, "starts", each=8 * self.coordinates.width)
        check.number(around, "around", at_least=0.0)
        rng = np.random.default_rng(check.integer(seed, "seed", at_least=0))
        return stability_report(self.field, self.positions, starts, around, rng)

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        settings = {
            "name": type(self.model).__name__,
            "model": asdict(self.model),
            "field": self.field.name,
            "duration": self.demonstrated_duration,
            "pace": self.pace,
            **self.coordinates.settings(),
        }
        own = {f"field_{name}": value for name, value in self.field.arrays().items()}
        arrays = {"scale": self.scale, "ends": self.ends, "positions": self.positions}
        return settings, {**arrays, **own, **self.coordinates.arrays()}

    def _rows(
        self, position: Any, goal: Target | None
    ) -> tuple[Situation[MotionT_co], Float64Array, bool]:
        """The situation, normalised positions (n, d), and whether one was given, not rows."""
        here = self._situation(None, goal)
        size = self.coordinates.size
        if self.coordinates.kind != "poses":
            given = check.array_of_rank(position, "position", shapes=((size,), ("n", size)))
            x = (np.atleast_2d(given) - here.goal) / self.scale
            return here, _within_reach(x), given.ndim == 1
        place, turn = pose_of(position)
        places = check.array_of_rank(place, "position", shapes=((3,), ("n", 3)))
        count = places.shape[:-1]
        turns = check.quaternions(turn, "position", shape=(*count, 4)).reshape(-1, 4)
        rows = [
            self._nearest_to_demonstrations(self._situation(pose, goal).start)
            for pose in zip(np.atleast_2d(places), turns, strict=True)
        ]
        return here, _within_reach(np.array(rows).reshape(-1, 6)), not count

    def _velocities(self, x: Float64Array) -> Float64Array:
        """Velocities (n, d) of the columns, per second, at normalised positions (n, d)."""
        return self.field.velocity(x) * self.scale * (self.pace / self.demonstrated_duration)

    def _seconds(self, duration: float) -> float:
        return duration * self.demonstrated_duration / self.pace

    def _situation(self, start: Target | None, goal: Target | None) -> Situation[MotionT_co]:
        """The situation of a query; parts left out are as demonstrated."""
        coordinates, size = self.coordinates, self.coordinates.size
        position = self.ends[1, :size]
        if goal is not None:
            target = coordinates.target(goal, "goal", 1.0)
            position = target[:size]
            if len(target) > size:
                about = coordinates.orientations(target[None, size:], np.ones(1))
                coordinates = replace(coordinates, reference=np.repeat(about, len(NODES), axis=0))
        first = self.ends[0].copy()
        if start is not None:
            given = coordinates.target(start, "start", 0.0)
            if len(given) > size:
                turns, nominal = sheets(given[size:], first[size:]), first[size:]
                nearest = min(turns, key=lambda turn: float(np.linalg.norm(turn - nominal)))
                given = np.concatenate([given[:size], nearest])
            first[: len(given)] = given
        first[:size] -= position
        return Situation(coordinates, position, first / self.scale, self.scale)

    def _nearest_to_demonstrations(self, x: Float64Array) -> Float64Array:
        """The same pose (6,), its rotation vector on the sheet nearest to a demonstration."""
        turns = sheets(x[3:] * self.scale[3:], self.ends[0, 3:])
        places = [np.concatenate([x[:3], turn / self.scale[3:]]) for turn in turns]
        return min(places, key=lambda each: float(((self.positions - each) ** 2).sum(axis=1).min()))


@dataclass(frozen=True, eq=False)
class Situation(Generic[MotionT_co]):
    """A goal, and where a motion starts."""

    coordinates: Coordinates[MotionT_co]  # of motions to this goal
    goal: Float64Array  # position or joints (m,) of the goal
    start: Float64Array  # the start (d,) in normalised columns about the goal
    scale: Float64Array  # divisors (d,) of the columns

    def columns(self, x: Float64Array) -> Float64Array:
        """The coordinates's columns (n, d) of normalised positions (n, d)."""
        columns = x * self.scale
        columns[:, : self.coordinates.size] += self.goal
        return columns


def sheets(turn: Float64Array, axis: Float64Array) -> list[Float64Array]:
    """Rotation vectors (3,) of one rotation: the shortest, and with a turn less and a turn more."""
    angle = float(np.linalg.norm(turn))
    own = turn / angle if angle > 0.0 else axis / max(float(np.linalg.norm(axis)), 1e-300)
    return [(angle + 2.0 * np.pi * k) * own for k in (0, -1, 1)]


def twist(coordinates: Coordinates, vectors: Float64Array, rate: Float64Array) -> Float64Array:
    """Angular velocities (n, 3) in the base frame of rotation vectors from the goal."""
    local = (rotations.left_jacobian(vectors) @ rate[:, :, None])[:, :, 0]
    assert coordinates.reference is not None
    return np.asarray(local @ rotations.to_matrix(coordinates.reference[:1])[0].T)


def _within_reach(x: Float64Array) -> Float64Array:
    """The normalised positions (n, d), if the system is followed there."""
    if len(x) and np.abs(x).max() > MAX_DISTANCE:
        raise InvalidInput(
            f"position: expected one within {MAX_DISTANCE:.0f} sizes of the demonstrations, got "
            f"one {np.abs(x).max():.0f} away from the goal"
        )
    return x


def pose_of(place: Any) -> tuple[Any, Any]:
    """Position and orientation of a pose."""
    if not isinstance(place, tuple | list) or len(place) != 2:
        raise InvalidInput(
            "position: expected (position (3,), orientation (4,)) of a skill of poses"
        )
    return place[0], place[1]


def from_archive(settings: dict[str, Any], arrays: Arrays) -> DynamicalSkill:
    coordinates = Coordinates.from_archive(settings, arrays)
    kind = entry_of_class(settings["name"]).load()
    own = {
        name: check.frozen(value, f"field_{name}", shape=value.shape)
        for name, value in prefixed(arrays, "field_").items()
    }
    field = kind.system.from_arrays(own)
    if field.size != coordinates.width:
        raise InvalidInput(f"field: expected {coordinates.width} columns, got {field.size}")
    return DynamicalSkill(
        kind(**settings["model"]),
        coordinates,
        field,
        check.frozen(arrays["scale"], "scale", shape=(coordinates.width,)),
        check.frozen(arrays["ends"], "ends", shape=(2, coordinates.width)),
        check.number(settings["duration"], "duration", above=0.0),
        check.number(settings["pace"], "pace", above=0.0),
        check.frozen(arrays["positions"], "positions", shape=("n", coordinates.width)),
    )
