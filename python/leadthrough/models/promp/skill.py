"""A fitted probabilistic movement primitive: generated, conditioned, sampled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Generic, cast

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.models.archive import Arrays, FittedSkill
from leadthrough.models.chart import Chart
from leadthrough.models.demonstrations import Demonstrations
from leadthrough.models.promp import dense, ends, limits, observation, resolution, task_space
from leadthrough.models.promp.basis import Basis
from leadthrough.models.promp.belief import Experience
from leadthrough.models.promp.clock import phases_at
from leadthrough.models.promp.drawn import Drawing
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.promp.saved import taken_apart
from leadthrough.models.promp.task_space import TaskMap
from leadthrough.models.promp.truncation import Truncated
from leadthrough.models.protocol import Parameter, whole_number
from leadthrough.models.queries import checked_query, checked_threads, even_times
from leadthrough.models.targets import Target
from leadthrough.motion import Motion, MotionT_co, normalised_times
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.models.promp.model import ProMP

_LEAST_WEIGHTS, _MOST_WEIGHTS = 5, 40  # the range worth trying on a slider


@dataclass(frozen=True, eq=False)
class ProMPSkill(FittedSkill, Generic[MotionT_co]):
    """A normal distribution of motions; made by `ProMP.fit`.

    Attributes:
        model: the settings that it was fitted with.
        basis: the k basis functions of the phase.
        chart: what the d columns are: the coordinates of points, the joints, or for poses the
            position and a rotation vector from a reference orientation.
        free: distribution of the weights (d k,), one column after the other, before the limits.
        noise: variances (d,) of the demonstrations about their curves.
        scale: reach (d,) of the motion.
        duration: duration of the motion, s.
        bounds: lower and upper limits (d,) each, or None.
        experience: the demonstrations, as long as the skill is as it was fitted.
    """

    model: ProMP
    basis: Basis
    chart: Chart[MotionT_co]
    free: Gaussian
    noise: Float64Array
    scale: Float64Array
    duration: float
    bounds: limits.Bounds | None = None
    experience: Experience | None = None

    kind: ClassVar[str] = "promp"

    @cached_property
    def weights(self) -> Gaussian:
        """Mean and covariance of the weights (d k,), inside the limits; `free` without limits."""
        return self.free if self.bounds is None else self._truncated.moments

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours; a rhythmic motion has no goal."""
        parts = {"start", "goal", "duration"}
        return frozenset(parts - {"goal"} if self.basis.is_rhythmic else parts)

    def distribution(
        self, times: ArrayLike, *, order: int = 0
    ) -> tuple[Float64Array, Float64Array]:
        """Mean and covariance of the columns, without the noise of the demonstrations.

        They are those of `weights`, which an estimator found: that few demonstrations tell mean
        and covariance only roughly is not part of them, nor of `sample` and `condition`. The
        skills that `infer` returns have covariances of which it is part.

        Args:
            times: times (n,), s, in [0, duration]; of a rhythmic motion any.
            order: 0 for positions, 1 for velocities, per s, 2 for accelerations, per s^2.

        Returns:
            Mean (n, d) and covariance (n, d, d).

        Raises:
            InvalidInput: if there is no time, one lies outside the motion or order is not 0, 1, 2.
        """
        check.integer(order, "order", at_least=0, at_most=2)
        rows = self.basis(self._phases(times, "times", at_least=1), order) * self.duration**-order
        size, count = self.chart.width, self.basis.count
        blocks = self.weights.covariance.reshape(size, count, size, count).transpose(1, 3, 0, 2)
        pairs = (rows[:, :, None] * rows[:, None, :]).reshape(len(rows), -1)
        covariance = dense.product(pairs, blocks.reshape(count**2, size**2))
        return rows @ self.weights.mean.reshape(size, count).T, covariance.reshape(-1, size, size)

    @checked_query
    def generate(
        self,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> MotionT_co:
        """The mean motion, or one between a start and a goal.

        Inside what was shown it is conditioned on them. Farther off it is shifted, and no phase
        moves by more than one and a half times what the ends are moved by.

        Args:
            start: columns (d,) at the start; for poses (position (3,), orientation (4,) as
                w, x, y, z) or the position alone. By default the mean.
            goal: the same at the end; a rhythmic motion has none.
            duration: duration, s, > 0; by default the skill's own.
            dt: largest time between samples, s, > 0.
            obstacles: must be empty.

        Returns:
            A motion of the type that was demonstrated; joints with velocities and accelerations.

        Raises:
            InvalidInput: if an argument is wrong, or if the motion is fixed to something else at
                its start or its goal.
            UnsupportedQuery: for obstacles, or a goal of a rhythmic motion.
        """
        if len(obstacles) > 0:
            raise UnsupportedQuery(
                "obstacles: a ProMP cannot avoid them; leave them out or use FastMarching"
            )
        if goal is not None and self.basis.is_rhythmic:
            raise UnsupportedQuery(
                "goal: a rhythmic motion has none, it ends where it starts; leave it out"
            )
        check.number(dt, "dt", above=0.0)
        skill = self if duration is None else self.lasting(duration)
        asked = ends.asked(self.chart, start, goal)
        skill = ends.moved(skill, asked) if asked else skill
        times = even_times(skill.duration, dt)
        return skill._motion(skill.weights.mean, times)

    def novelty(self, *, start: Target | None = None, goal: Target | None = None) -> float:
        """How far a start and a goal lie from what was shown, in standard deviations.

        The largest deviation along any principal axis of the distribution of these ends. From
        about 3 on, the motion is an extrapolation: `generate` shifts it there.

        Args:
            start: as in `generate`.
            goal: as in `generate`.

        Returns:
            0 for the mean ends; infinite where the motion is fixed to something else.

        Raises:
            InvalidInput: if an argument is wrong.
        """
        asked = ends.asked(self.chart, start, goal)
        return ends.novelty(self, asked) if asked else 0.0

    def condition(
        self,
        time: ArrayLike,
        position: Target,
        *,
        covariance: ArrayLike | None = None,
        order: int = 0,
        columns: Sequence[int] | None = None,
    ) -> ProMPSkill[MotionT_co]:
        """A skill whose motions pass one or several via points; call it again for more.

        The covariance of `weights` counts as known: see `distribution`.

        Args:
            time: time of the via point, s, in [0, duration]; (m,) for several.
            position: the values (p,) there, for poses as in `generate`; (m, p) for several.
            covariance: covariance (p, p) of the values at each via point; by default the motion
                passes through them exactly.
            order: what the values are: 0 positions, 1 velocities, per s, 2 accelerations, per s^2.
            columns: indices of the p columns that the values are for; by default all; for poses
                those of the position or of the position and the orientation.

        Raises:
            InvalidInput: if an argument is wrong, if several via points are given for poses, if
                the motion is already fixed to something else at that time, or if exact via points
                are so close to each other that the basis can only throw the motion elsewhere.
        """
        plain = columns is None and covariance is not None and type(order) is int and order == 0
        if plain and (seen := observation.quickly(self, time, position, covariance)) is not None:
            return seen
        check.integer(order, "order", at_least=0, at_most=2)
        several = isinstance(time, list | tuple) or getattr(time, "ndim", 0) > 0
        phases = self._phases(time if several else [cast(float, time)], "time", at_least=1)
        if columns is None and order == 0 and self.chart.kind == "poses":
            if several:
                raise InvalidInput("time: expected one time for a pose; call again for more")
            chosen = None
            values = self.chart.target(position, "position", float(phases[0]))[None]
        else:
            chosen = observation.chosen(columns, self.chart)
            shape = (len(phases), len(chosen)) if several else (len(chosen),)
            values = check.array(position, "position", shape=shape).reshape(-1, len(chosen))
        skill = observation.of_values(
            self, phases, values, covariance, columns=chosen, order=order, name="position"
        )
        if covariance is None and order == 0:
            columns_of = self.chart.every[: values.shape[1]] if chosen is None else chosen
            resolution.refuse_too_close(self, skill, phases, values, columns_of)
        return skill

    def condition_task(
        self,
        time: float,
        value: ArrayLike,
        task: TaskMap,
        *,
        covariance: ArrayLike | None = None,
    ) -> ProMPSkill[MotionT_co]:
        """A skill whose motions pass a via point in a task space, such as a tool's position.

        Args:
            time: time of the via point, s, in [0, duration].
            value: value (p,) in the task space.
            task: takes columns (d,), returns their value (p,) in the task space and its Jacobian
                (p, d); for joints an arm's kinematics.
            covariance: covariance (p, p) of the value; by default the mean motion passes exactly.

        Raises:
            InvalidInput: if an argument is wrong or the mean motion cannot reach the value.

        Source: Gomez-Gonzalez et al. 2020, "Adaptation and robust learning of probabilistic
        movement primitives", section IV-D, iterated.
        """
        rows = np.asarray(
            np.kron(np.eye(self.chart.width), self.basis(self._phases([time], "time")))
        )
        noise = observation.noise_of(covariance, np.size(value))
        return self.with_weights(task_space.through(self, rows, value, task, noise))

    def lasting(self, duration: float) -> ProMPSkill[MotionT_co]:
        """The same motion at another speed.

        Args:
            duration: new duration, s, > 0.

        Raises:
            InvalidInput: if the duration is not positive.
        """
        return replace(self, duration=check.number(duration, "duration", above=0.0))

    @one_blas_thread
    def within(self, lower: ArrayLike, upper: ArrayLike) -> ProMPSkill[MotionT_co]:
        """A skill whose mean and samples keep limits.

        Its distribution is that of the motions that keep the limits, cut off where they do not:
        `distribution` gives its mean and covariance, to a few hundredths of the standard deviation,
        `generate` its mean, `sample` draws from it. Via points stay. `condition` and `generate`
        with a start or goal observe first and cut off then, in whatever order they are called.

        Args:
            lower: lower limits (d,), -inf where there is none.
            upper: upper limits (d,), > lower, inf where there is none.

        Raises:
            InvalidInput: if the limits are wrong, or if via points lie outside them.
        """
        bounds = limits.checked(lower, upper, self.chart.width)
        bounded = replace(self, bounds=bounds).with_weights(self.free)
        return replace(bounded, experience=self.experience)

    def sample(
        self, count: int, *, seed: int, dt: float = 0.01, threads: int = 1
    ) -> list[MotionT_co]:
        """Random motions, inside the limits, from `distribution`.

        Args:
            count: number of motions, >= 1.
            seed: seed of the random number generator, >= 0.
            dt: largest time between samples, s, > 0.
            threads: number of threads, 1 to 256; does not change the motions.

        Raises:
            InvalidInput: if an argument is out of range.
        """
        times = even_times(self.duration, check.number(dt, "dt", above=0.0))
        check.affordable_count(count, "count", each=len(times) * self.chart.width)
        checked_threads(threads)
        drawing = Drawing(self.chart, self.basis, times, self.duration)
        return drawing.motions(self.sample_weights(count, seed=seed), threads)

    def sample_weights(self, count: int, *, seed: int) -> Float64Array:
        """Random weight vectors, inside the limits.

        Args:
            count: number of vectors, >= 1.
            seed: seed of the random number generator, >= 0.

        Returns:
            Weights (count, d k), one column after the other.

        Raises:
            InvalidInput: if an argument is out of range.
        """
        size = check.affordable_count(count, "count", each=len(self.free.mean))
        rng = np.random.default_rng(check.integer(seed, "seed", at_least=0))
        return (self.free if self.bounds is None else self._truncated).draw(size, rng)

    def log_likelihood(self, trajectory: Motion) -> float:
        """Log density of a motion whose samples are as noisy as the demonstrations'.

        Args:
            trajectory: a motion of the type that was demonstrated, at least two samples. Its
                duration does not matter: it is compared over normalised time.

        Raises:
            InvalidInput: if the motion has another type or fewer than two samples.
        """
        observation.check_seen(trajectory, "trajectory")
        phases = normalised_times(trajectory.times)
        values = self.chart.columns(trajectory, phases, "trajectory")
        return observation.log_density(self, phases, values)

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[MotionT_co]]:
        """The number of weights, if there are demonstrations to fit again.

        The skill fitted again has the same settings, duration and limits, but no via points.

        Args:
            demonstrations: the demonstrations that the skill was fitted to.
        """
        if len(demonstrations) == 0:
            return []

        def fitted(weights: int) -> ProMPSkill[MotionT_co]:
            made = replace(self.model, weights=weights).fit(demonstrations)
            again = cast(ProMPSkill[MotionT_co], made).lasting(self.duration)
            return again if self.bounds is None else again.within(*self.bounds)

        least, most = _LEAST_WEIGHTS, _MOST_WEIGHTS
        return [whole_number("weights", self.basis.count, least=least, most=most, apply=fitted)]

    # Any: settings are whatever JSON holds.
    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        """Settings and arrays that `model.from_archive` turns into the skill again."""
        return taken_apart(self)

    def with_weights(self, weights: Gaussian) -> ProMPSkill[MotionT_co]:
        """The skill with another distribution of the weights, before the limits.

        Args:
            weights: distribution of the weights (d k,), one column after the other.

        Raises:
            InvalidInput: if the limits cannot be kept.
        """
        if self.bounds is not None:
            limits.moved_inside(weights, self.basis, self.bounds, self.scale)
        # Spelled out, as `replace` takes longer and controllers condition in a loop.
        kept = self.noise, self.scale, self.duration, self.bounds
        return ProMPSkill(self.model, self.basis, self.chart, weights, *kept)

    @cached_property
    def _truncated(self) -> Truncated:
        assert self.bounds is not None
        return Truncated(self.free, self.basis, self.bounds, self.scale)

    def _phases(self, times: ArrayLike, name: str, at_least: int = 0) -> Float64Array:
        cyclic = self.basis.is_rhythmic
        return phases_at(times, name, duration=self.duration, repeats=cyclic, at_least=at_least)

    def _motion(self, weights: Float64Array, times: Float64Array) -> MotionT_co:
        phases = times / self.duration
        curves = weights.reshape(self.chart.width, -1).T
        orders = (0, 1, 2) if self.chart.kind == "joints" else (0,)
        values = [self.basis(phases, each) @ curves * self.duration**-each for each in orders]
        return self.chart.motion(times, phases, *values)
