"""Movement primitives of poses: position and orientation on one phase.

How the orientation is represented stands in `turning`; what moves it, in `springs`.
Source: Lauretti et al. 2023, "Robot learning by demonstration with dynamic parameterization of the
orientation", Robotics 12:166, for the representations that ours is compared with.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import _core, check, events, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import FitError, InvalidInput, UnsupportedQuery
from leadthrough.events import Event
from leadthrough.io.atomic import StrPath
from leadthrough.models import archive
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.dmp import springs, turning
from leadthrough.models.dmp.coupling import check_around, roll, step_around
from leadthrough.models.dmp.kernels import MOST_WEIGHTS, enough_weights
from leadthrough.models.dmp.mean_motion import MeanMotion, mean_motion
from leadthrough.models.dmp.query import (
    check_channels,
    check_duration,
    check_step,
    course_through,
    ends_of,
)
from leadthrough.models.dmp.refit import weights_of
from leadthrough.models.dmp.regression import REGRESSIONS, fit
from leadthrough.models.dmp.springs import Ends, Springs
from leadthrough.models.dmp.turning import REPRESENTATIONS, Turning
from leadthrough.models.even_times import even_phases
from leadthrough.models.parameters import Parameter
from leadthrough.models.place import Place
from leadthrough.motion import Motion, PoseTrajectory, computed
from leadthrough.shapes import Shape

Offsets = tuple[Float64Array, Float64Array]

_FORM = "blended"
_NOTHING = np.zeros(3)
# What "lifted" may turn more or less than the demonstration and its offset, before it counts as
# spinning, or as having lost a turn.
_SPIN = np.radians(20.0)
_SPIN_SAMPLES = 1000


@dataclass(frozen=True)
class PoseDMP:
    """Dynamic movement primitives of poses.

    weights: as in `DMP`. orientation: "anchored", which holds for any rotation;
    "lifted" (Lauretti et al. 2023), up to about 220 degrees; "log" and "euler" (ZYZ), which break
    where they jump. regression: as in `DMP`. Positions are those of the form "blended" of `DMP`.
    """

    weights: int | None = 50
    orientation: str = "anchored"
    regression: str = "replay"

    def __post_init__(self) -> None:
        if self.weights is not None:
            check.integer(self.weights, "weights", at_least=2, at_most=MOST_WEIGHTS)
        check.choice(self.orientation, "orientation", REPRESENTATIONS)
        check.choice(self.regression, "regression", REGRESSIONS)

    def fit(self, demonstrations: Demonstrations[Motion]) -> PoseDMPSkill:
        """A skill from demonstrations of poses; several are averaged over normalised time first.

        Raises InvalidInput for other motions; FitError for one that does not move, for several
        whose orientations lie too far apart for a mean, and where "lifted" would spin.
        """
        shown = mean_motion(demonstrations, (PoseTrajectory,))
        assert shown.orientations is not None
        turned, coordinates = turning.learn(shown.phases, shown.orientations, self.orientation)
        count = self.weights or enough_weights(shown.duration)
        learned = fit(
            shown.phases,
            np.hstack([shown.positions, coordinates]),
            weights=count,
            form=_FORM,
            regression=self.regression,
        )
        model = replace(self, weights=count)
        skill = PoseDMPSkill(model, learned, turned, shown.duration, shown.size, shown.events)
        if self.orientation == "lifted":
            return replace(skill, turning=replace(turned, angle=_replayed_angle(skill, shown)))
        return skill


@dataclass(frozen=True, eq=False)
class PoseDMPSkill:
    """A learned primitive of poses; made by `PoseDMP.fit`.

    model: its parameters. springs: of three coordinates of the position and three of the
    orientation. turning: what the latter mean. duration: s, as demonstrated. size: m, diagonal of
    the box around the demonstrated positions. events: at shares of the duration.
    """

    model: PoseDMP
    springs: Springs
    turning: Turning
    duration: float
    size: float
    events: tuple[Event, ...] = ()

    kind: ClassVar[str] = "pose_dmp"
    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration", "obstacles"})

    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
        via: Sequence[tuple[float, ArrayLike]] = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
    ) -> PoseTrajectory:
        """A motion from pose to pose.

        start, goal: a position (3,), or (position (3,), orientation (4,)); what is left out is as
        demonstrated. duration: s, > 0, by default the demonstrations'. dt: s, upper bound of the
        sampling step; the motion does not depend on it. via: (share of the duration inside (0, 1),
        position (3,)), in order. start_velocity, final_velocity: (3,) m/s, by default as
        demonstrated at that duration. obstacles: in the demonstrations' frame; the position keeps
        clear of them, the orientation does not mind them.
        Raises InvalidInput; NoPath where steering does not clear the obstacles; UnsupportedQuery
        where "lifted" would spin.
        """
        step = check.number(dt, "dt", above=0.0)
        around = check_around(obstacles, None, dimensions=3, channels=6)
        state = self.begin(
            start=start,
            goal=goal,
            duration=duration,
            via=via,
            start_velocity=start_velocity,
            final_velocity=final_velocity,
        )
        phases = even_phases(state.duration, step)
        values, _ = roll(self.springs, state, phases, around=around, size=self.size)
        offsets = state.start_offset, state.goal_offset
        turned = self.turning.orientations(phases, values, offsets)
        return computed(
            PoseTrajectory,
            times=state.duration * phases,
            positions=values[:, :3].copy(),
            orientations=turned,
            events=events.moved(self.events, (0.0, 1.0), (0.0, state.duration)),
        )

    def begin(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        via: Sequence[tuple[float, ArrayLike]] = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
    ) -> _core.PoseState:
        """The state at the start, for `step`; arguments as in `generate`.

        Raises InvalidInput; UnsupportedQuery where "lifted" would spin.
        """
        total = check_duration(duration, self.duration)
        first, first_turned = as_pose(start, "start")
        last, last_turned = as_pose(goal, "goal")
        positions = ends_of(
            self.springs.ends.part(slice(3)),
            start=first,
            goal=last,
            start_velocity=start_velocity,
            final_velocity=final_velocity,
            duration=total,
        )
        turned, offsets = self._turned_ends(first_turned, last_turned)
        ends = positions.joined(turned)
        course = course_through(self.springs, ends, via, count=3)
        state = _core.PoseState(
            course, ends.start, ends.start_slope, 0.0, total, self.turning.curve, *offsets
        )
        as_shown = first_turned is None and last_turned is None
        return state if as_shown else self._without_spin(state)

    def step(
        self,
        state: _core.PoseState,
        dt: float,
        *,
        goal: Place | None = None,
        coupling: ArrayLike | None = None,
        lag: float = 0.0,
        measured: Place | None = None,
        obstacles: Sequence[Shape] = (),
    ) -> _core.PoseState:
        """The state dt s later; exact for any dt > 0.

        It has .position, .velocity (3,), .orientation (4,), .angular_velocity (3,) rad/s in the
        base frame, .pose (7,), which is position and orientation in a row, and .phase. state: from
        `begin` or the last step. goal: as in `generate`, moves the goal. coupling: (3,)
        acceleration, m/s^2, that acts meanwhile, or (6,) with an angular one, rad/s^2 in the base
        frame. measured: like goal; where the motion goes on from instead of the state's pose. lag:
        as in `DMPSkill.step`. obstacles: to keep clear of in this step. Raises InvalidInput;
        UnsupportedQuery where "lifted" would spin on the way to a new goal, or from a new pose.
        """
        changed = goal is not None or measured is not None or coupling is not None
        if not changed and not obstacles and type(dt) is float and lag == 0.0:
            # The quick way: control loops ask a thousand times a second.
            after = state.tick(self.springs.forces, dt)
            if after is not None:
                return after
        span = check_step(dt, lag, state.duration)
        if goal is not None:
            state = self._redirected(state, goal)
        if measured is not None:
            state = self._moved(state, measured)
        if coupling is None and not obstacles:
            return state.coast(self.springs.forces, span)
        push = np.zeros(6) if coupling is None else as_push(coupling)
        around = check_around(obstacles, None, dimensions=3, channels=6)
        return step_around(self.springs, state, span, push, around=around, size=self.size)

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[PoseTrajectory]]:
        """Its number of weights, where there are demonstrations to fit again."""
        return weights_of(self, demonstrations)

    def save(self, path: StrPath) -> None:
        """Writes the skill to a .npz file that `load_skill` reads. Raises InvalidInput."""
        archive.write(path, self.kind, *self.to_archive())

    def to_archive(self) -> tuple[dict[str, Any], archive.Arrays]:
        """Settings and arrays that `from_archive` puts together again."""
        settings = {
            **asdict(self.model),
            "duration": self.duration,
            "size": self.size,
            "events": events.to_plain(self.events),
        }
        arrays = {**self.springs.arrays(), **self.turning.arrays()}
        return settings, arrays

    @classmethod
    def from_archive(cls, settings: dict[str, Any], arrays: archive.Arrays) -> PoseDMPSkill:
        """The skill that `save` took apart. Raises KeyError, TypeError, ValueError."""
        duration = check.number(settings.pop("duration"), "duration", above=0.0)
        size = check.number(settings.pop("size"), "size", at_least=0.0)
        happening = events.from_plain(settings.pop("events", ()))
        model = PoseDMP(**settings)
        learned = Springs.from_arrays(_FORM, settings["weights"], arrays)
        turned = Turning.from_arrays(model.orientation, arrays)
        return cls(model, learned, turned, duration, size, happening)

    def _turned_ends(
        self, start: Float64Array | None, goal: Float64Array | None
    ) -> tuple[Ends, Offsets]:
        """Ends of the orientation's coordinates, and the offsets of the curve."""
        learned, known = self.springs.ends.part(slice(3, 6)), self.turning
        if start is None and goal is None:
            return learned, (_NOTHING, _NOTHING)
        first = known.start if start is None else start
        last = known.goal if goal is None else goal
        offsets = known.offsets(first, last)
        if known.representation == "anchored":
            return learned, offsets
        at_start, _ = known.coordinates(first, phase=0.0, offsets=offsets, near=learned.start)
        at_goal, _ = known.coordinates(last, phase=1.0, offsets=offsets, near=learned.goal)
        return replace(learned, start=at_start, goal=at_goal), offsets

    def _redirected(self, state: _core.PoseState, goal: Any) -> _core.PoseState:
        position, turned = as_pose(goal, "goal")
        ends = self.springs.ends
        wanted = np.concatenate([check_channels(position, "goal", 3), ends.goal[3:]])
        if turned is None:
            course = springs.redirected(_FORM, state.course, wanted)
            return self._with(state, course, state.value, state.slope)
        old = state.start_offset, state.goal_offset
        new = self.turning.offsets(self.turning.start, turned, near=old[1])
        if self.turning.representation == "anchored":
            new = old[0], new[1]
        else:
            at_goal, _ = self.turning.coordinates(turned, phase=1.0, offsets=new, near=wanted[3:])
            wanted[3:] = at_goal
        course = springs.redirected(_FORM, state.course, wanted)
        value, slope = self._coordinates_of(state, state.orientation, new)
        return self._without_spin(self._with(state, course, value, slope, new))

    def _moved(self, state: _core.PoseState, measured: Any) -> _core.PoseState:
        position, turned = as_pose(measured, "measured")
        q = state.orientation if turned is None else turned
        value, slope = self._coordinates_of(state, q, (state.start_offset, state.goal_offset))
        value[:3] = check_channels(position, "measured", 3)
        return self._without_spin(self._with(state, state.course, value, slope))

    def _coordinates_of(
        self, state: _core.PoseState, orientation: Float64Array, offsets: Offsets
    ) -> tuple[Float64Array, Float64Array]:
        """Value and slope (6,) of the state, with another orientation or under other offsets."""
        e, e_slope = self.turning.coordinates(
            orientation,
            phase=state.phase,
            offsets=offsets,
            near=state.value[3:],
            velocity=state.angular_velocity * state.duration,
        )
        return np.append(state.value[:3], e), np.append(state.slope[:3], e_slope)

    def _with(
        self,
        state: _core.PoseState,
        course: _core.DmpCourse,
        value: Float64Array,
        slope: Float64Array,
        offsets: Offsets | None = None,
    ) -> _core.PoseState:
        turned_by = offsets or (state.start_offset, state.goal_offset)
        return _core.PoseState(
            course, value, slope, state.phase, state.duration, state.curve, *turned_by
        )

    def _without_spin(self, state: _core.PoseState) -> _core.PoseState:
        """The same state. Raises UnsupportedQuery where "lifted" would spin from it to the end."""
        if self.model.orientation != "lifted" or state.phase >= 1.0:
            return state
        made = _angle_ahead(self, state)
        shown = self.turning.angle
        least = shown if state.phase == 0.0 else 0.0
        allowed = _SPIN + max(
            float(np.linalg.norm(offset)) for offset in (state.start_offset, state.goal_offset)
        )
        if not least - allowed <= made <= shown + allowed:
            raise UnsupportedQuery(
                f'orientation="lifted": from here to this goal it would turn by '
                f"{np.degrees(made):.0f} degrees, {np.degrees(shown):.0f} were shown; "
                'use "anchored"'
            )
        return state


def _angle_ahead(skill: PoseDMPSkill, state: _core.PoseState) -> float:
    """The angle that the tool turns from a state to the end, rad."""
    phases = np.linspace(state.phase, 1.0, _SPIN_SAMPLES)
    values, _ = _core.dmp_rollout(
        skill.springs.forces, state.course, state.value, state.slope, phases
    )
    made = skill.turning.orientations(phases, values, (state.start_offset, state.goal_offset))
    return float(rotations.distance(made[:-1], made[1:]).sum())


def as_pose(value: Any, name: str) -> tuple[Any, Float64Array | None]:
    """Position and orientation of a part of a query; None where left out. Raises InvalidInput."""
    if isinstance(value, tuple | list) and len(value) == 2:
        return value[0], check.quaternions(value[1], name, shape=(4,))
    return value, None


def as_push(coupling: Any) -> Float64Array:
    """A coupling as linear and angular acceleration, (6,). Raises InvalidInput."""
    given = check.array(coupling, "coupling", shape=("n",))
    if len(given) not in (3, 6):
        raise InvalidInput(f"coupling: expected shape (3,) or (6,), got {given.shape}")
    return np.append(check_channels(given, "coupling", len(given)), np.zeros(6 - len(given)))


def _replayed_angle(skill: PoseDMPSkill, shown: MeanMotion) -> float:
    """The angle turned in replay, rad: what was shown without its noise, to measure spins by.

    The continuous logarithm may swing about where the tool hardly turns. Raises FitError.
    """
    assert shown.orientations is not None
    state = skill.begin()
    values, _ = _core.dmp_rollout(
        skill.springs.forces, state.course, state.value, state.slope, shown.phases
    )
    made = skill.turning.orientations(shown.phases, values)
    worst = float(rotations.distance(made, shown.orientations).max())
    if worst > _SPIN:
        raise FitError(
            f'demonstrations: orientation="lifted" would be off by {np.degrees(worst):.0f} degrees '
            'beside a whole number of turns; use "anchored"'
        )
    return float(rotations.distance(made[:-1], made[1:]).sum())
