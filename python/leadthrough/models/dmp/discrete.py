"""Discrete movement primitives of points, joints and poses.

The equations of the forms stand in `transformation`, those of the fits in `regression`, and the
representations of orientations in `orientation`. Position and orientation of a pose share one
phase.
Sources: Ijspeert et al. 2013, "Dynamical movement primitives", Neural Computation 25; Hoffmann et
al. 2009, "Biologically-inspired dynamical systems for movement generation".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.models.archive import Arrays, SteppedSkill
from leadthrough.models.dmp.channels import PointChannels, PoseChannels
from leadthrough.models.dmp.learning import Primitive, check_choices, learn_motion, take_parts
from leadthrough.models.dmp.query import check_final_velocity, check_state, check_step
from leadthrough.models.dmp.transformation import MAX_WEIGHTS, RATE
from leadthrough.models.modes import learned_by_mode
from leadthrough.models.protocol import Demonstrations, Outliers, Skill, Unfitted
from leadthrough.models.queries import CheckedQuery, even_phases
from leadthrough.motion import Motion, MotionT, MotionT_co, Target, moved_events
from leadthrough.shapes import Shape


@dataclass(frozen=True)
class DMP(Unfitted):
    """Dynamic movement primitives of points in any number of dimensions, of joints, or of poses.

    Attributes:
        weights: number of kernels per channel, 2 to 1000; None: as few, doubled from 50, as replay
            the demonstrated motion within its noise or a thousandth of its extent.
        form: "blended", which meets start, goal and velocities exactly; "hoffmann" (Hoffmann et al.
            2009, Pastor et al. 2009), whose force is not scaled by the goal either; "ijspeert"
            (Ijspeert et al. 2002, 2013), whose force is. At the end of a motion the last two are
            only near a new goal: "hoffmann" lacks 2.5 % of what start and goal were moved by
            (0.03 % after half as long again, in `step`), "ijspeert" its error in replay, scaled.
        regression: "replay" minimises the error of the replayed motion; "ridge" and "lwr" fit the
            force that finite differences ask for, all kernels together or each by itself.
        orientation: coordinates of the orientation of poses: "anchored", which holds for any
            rotation; "lifted" (Lauretti et al. 2023), up to about 220 degrees; "log" and "euler"
            (ZYZ), which break where they jump. The form "ijspeert" scales the orientation's forces
            by these coordinates at the start, seen from the goal; "anchored" has none.
    """

    weights: int | None = None
    form: str = "blended"
    regression: str = "replay"
    orientation: str = "anchored"

    slider: ClassVar[tuple[str, int, int]] = ("weights", 5, 100)

    def __post_init__(self) -> None:
        if self.weights is not None:
            check.integer(self.weights, "weights", at_least=2, at_most=MAX_WEIGHTS)
        check_choices(self.form, self.regression, self.orientation)

    @staticmethod
    def lauretti(weights: int | None = 50) -> DMP:
        """The planner of Lauretti et al. 2023 for poses by its own equations, to compare with.

        Springs drive position and orientation, with forces scaled by goal - start (eqs. 1, 2 and A1
        to A7), the dynamic parameterisation of the logarithm (eqs. 7 to 9) and locally weighted
        regression. The logarithm is that of the rotation from the goal, in the goal's axes. Slips
        in the paper are corrected: time is scaled alike in all terms, the logarithm in eq. 6 is
        constant, and omega, the derivative of the rotation vector, is integrated before exp.

        Its weaknesses are the paper's: a motion of which a channel ends where it began is refused;
        a new goal on the other side of the start in a channel mirrors that channel; where goal -
        start is small, a small change of it distorts the motion strongly; the tool may spin towards
        a new goal.

        Args:
            weights: as the attribute.
        """
        return DMP(weights, form="ijspeert", regression="lwr", orientation="lifted")

    def fit(
        self, demonstrations: Demonstrations[MotionT], *, outliers: Outliers = "refuse"
    ) -> DMPSkill[MotionT]:
        """A skill from demonstrations; several of one mode are averaged by phase.

        Args:
            demonstrations: all of points, all of joints or all of poses.
            outliers: treatment of one that contradicts all others: "refuse", "drop" or "keep", as
                for `learn`.

        Raises:
            InvalidInput: for other motions, and for poses with the form "ijspeert" and the
                orientation "anchored".
            FitError: for one that does not move or contradicts all others, and with the form
                "ijspeert" for one of which a channel ends where it began; for several whose
                orientations lie too far apart for a mean, and where "lifted" would spin.
        """
        return learned_by_mode(self._fitted, demonstrations, outliers)

    def _fitted(self, motions: Sequence[MotionT]) -> DMPSkill[MotionT]:
        mean, parts = learn_motion(motions, **asdict(self))
        model = replace(self, weights=len(parts["system"].weights))
        return DMPSkill(model=model, duration=mean.duration, size=mean.size, **parts)


@dataclass(frozen=True, eq=False, kw_only=True)
class DMPSkill(Primitive[MotionT_co], SteppedSkill[MotionT_co]):
    """A learned primitive; made by `DMP.fit`.

    A motion lasts `default_duration` by default: as demonstrated, or longer where a moved start or
    goal would make it more than 1.3 times as fast. It does not depend on the sampling step.

    Attributes:
        model: the settings that it was fitted with, with the number of weights that was used.
        system: the learned transformation system; of poses with three channels of the position
            and three of the orientation.
        duration: s, as demonstrated.
        size: diagonal of the box around the demonstrated positions, m.
        events: at fractions of the duration, 0 to 1.
        joint_names: of joints; None for points and poses.
        orientation: coordinates of the orientation; None for points and joints.
        posture: the arm's joints at fractions of the duration, if demonstrated beside the motion.
    """

    model: DMP
    duration: float
    size: float

    kind: ClassVar[str] = "dmp"

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours.

        Obstacles for poses and for points in two or three dimensions, limits for points and joints,
        a final velocity with the form "blended".
        """
        known = {"start", "goal", "duration", "via", "start_velocity"}
        optional = {
            "final_velocity": self.system.form == "blended",
            "obstacles": self._channels.dimensions is not None,
            "limits": self.orientation is None,
        }
        return frozenset(known | {name for name, honoured in optional.items() if honoured})

    def _answer(self, query: CheckedQuery) -> MotionT_co:
        constraints = self._channels.constraints(query.obstacles, query.limits)
        state = self._begin(query)
        phases = even_phases(state.duration, query.dt)
        posture, times = self.posture, state.duration * phases
        made = self._channels.motion(
            state,
            phases,
            constraints=constraints,
            events=moved_events(self.events, (0.0, 1.0), (0.0, state.duration)),
            joints=None if posture is None else posture.along(times, phases),
        )
        return cast(MotionT_co, made)  # of the demonstrated type

    def _begin(self, query: CheckedQuery) -> Any:
        check_final_velocity(query.final_velocity, self.system.form)
        own_velocities = query.start_velocity is None and query.final_velocity is None
        if query.duration is None and own_velocities and query.via == ():
            return self._begin_at_own_pace(query)
        if query.duration is None:
            total = self.default_duration(start=query.start, goal=query.goal)
        else:
            total = query.duration
        return self._channels.begin(query, total)

    def _begin_at_own_pace(self, query: CheckedQuery) -> Any:
        """The state of a motion of the default duration, which follows from the state itself."""
        if query.start is None and query.goal is None:
            return self._channels.as_demonstrated(self.duration)
        state: Any = self._channels.begin(query, self.duration)
        if self.system.form != "blended":
            return state
        longer = self._channels.lengthening(state, self.duration)
        return self._channels.lasting(state, self.duration * longer)

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
        """The state dt s later; exact for any dt.

        Args:
            state: from `begin` or the last step.
            dt: s, > 0.
            goal: as in `generate`, moves the goal.
            coupling: (d,), an acceleration, unit per s^2, that acts during the step; of poses
                (3,) m/s^2, or (6,) with an angular one, rad/s^2 in the base frame.
            lag: >= 0; in this step the motion, phase and springs alike, runs 1 / (1 + lag) as fast,
                as with a larger tau. For phase stopping, take a gain times the squared distance
                between the arm and the state: while the arm is held, the motion waits; once it
                follows, the motion goes on as fast as before. (An arm that always trails behind
                slows it always: choose the gain small for its normal error.)
            measured: like goal; where the motion goes on from instead of the state's position, or
                pose.
            obstacles: as in `generate`, of this step.
            limits: as in `generate`, of this step.

        Returns:
            A state with .position (d,), .velocity (d,) and .phase; of poses also .orientation (4,),
            .angular_velocity (3,) rad/s in the base frame, and .pose (7,), which is position and
            orientation in a row.

        Raises:
            UnsupportedQuery: for obstacles or limits that are not among `supports`, and where the
                orientation "lifted" would spin on the way to a new goal, or from a new pose.
        """
        changed = goal is not None or measured is not None or coupling is not None
        constrained = limits is not None or bool(obstacles)
        if not (changed or constrained) and type(dt) is float and lag == 0.0:
            # The quick path: control loops step a thousand times a second.
            try:
                after = state.tick(self.system.forces, dt)
            except AttributeError:  # no state
                after = None
            if after is not None:
                return after
        check_state(state)
        span = check_step(dt, lag, state.duration)
        if goal is not None:
            state = self._channels.redirected(state, goal)
        if measured is not None:
            state = self._channels.moved(state, measured)
        if coupling is None and not constrained:
            return state.coast(self.system.forces, span)
        still = np.zeros(len(state.value))
        push = still if coupling is None else self._channels.acceleration(coupling)
        constraints = self._channels.constraints(obstacles, limits)
        return self._channels.step_within(state, span, push, constraints)

    def default_duration(self, *, start: Target | None = None, goal: Target | None = None) -> float:
        """Default duration of a motion, s: as demonstrated, or longer.

        A start or goal that is moved along the motion's own direction makes the motion quicker. It
        then lasts longer, until the highest linear, angular or joint speed is within 1.3 times the
        demonstrated one. Speeds up to 0.05 m/s and 0.25 rad/s are never held back; a tool that was
        demonstrated to move by less than 2 mm, or to rotate by less than 0.05 rad, sets no pace
        for that. The forms of the literature keep the demonstrated duration.

        Args:
            start: as in `generate`.
            goal: as in `generate`.
        """
        if (start is None and goal is None) or self.system.form != "blended":
            return self.duration
        state: Any = self._channels.begin(CheckedQuery(start, goal), self.duration)
        return self.duration * self._channels.lengthening(state, self.duration)

    def replay(self, samples: int) -> MotionT_co:
        """The demonstrated motion, evenly sampled.

        Args:
            samples: their number, 2 or more.
        """
        return self.generate(dt=self.duration / (samples - 1))

    def relearned(self, motion: Motion) -> Skill:
        """The skill of another motion, learned with the same settings.

        Args:
            motion: of the demonstrated type.

        Raises:
            FitError: for one that does not move.
        """
        return self.model.fit([motion])

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        settings, arrays = super().to_archive()
        own = {"duration": self.duration, "size": self.size}
        return {**asdict(self.model), **own, **settings}, arrays

    def _tables(self) -> dict[str, Any]:
        system, channels, known = self.system, self._channels, self.orientation
        anchored = known is None or known.representation == "anchored"
        if system.form != "blended" or not anchored:
            raise self._not_exported()
        turned = {} if known is None else known.arrays()
        if known is not None:
            turned |= {"steps": known.curve.steps, "covered": known.curve.covered}
        return {
            "joint_names": "\n".join(self.joint_names or ()),
            "duration": self.duration,
            "rate": RATE,
            "nodes": system.forces.nodes,
            "fade": system.forces.fade,
            "start": system.ends.start,
            "goal": system.ends.goal,
            "start_slope": system.ends.start_slope,
            "demonstrated": system.demonstrated_course.coefficients,
            **channels.moving_course(),
            **turned,
        }

    @cached_property
    def _channels(self) -> PointChannels | PoseChannels:
        if self.orientation is None:
            return PointChannels(self.system, self.size, self.joint_names)
        return PoseChannels(self.system, self.size, self.orientation)


def from_archive(settings: dict[str, Any], arrays: Arrays) -> DMPSkill:
    duration = check.number(settings.pop("duration"), "duration", above=0.0)
    size = check.number(settings.pop("size"), "size", at_least=0.0)
    names = [each.name for each in fields(DMP) if each.name in settings]
    model = DMP(**{name: settings.pop(name) for name in names})
    parts = take_parts(
        settings,
        arrays,
        form=model.form,
        weights=check.integer(model.weights, "weights", at_least=2),
        representation=model.orientation,
    )
    return DMPSkill(model=model, duration=duration, size=size, **parts)
