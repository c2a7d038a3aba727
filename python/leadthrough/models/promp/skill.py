"""A fitted probabilistic movement primitive: asked for motions, conditioned, sampled."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Generic, cast

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.io.atomic import StrPath
from leadthrough.models import archive
from leadthrough.models.chart import Chart
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.parameters import Parameter, whole_number
from leadthrough.models.place import Place
from leadthrough.models.promp import limits, observation
from leadthrough.models.promp.basis import Basis
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.sampling import even_times
from leadthrough.motion import Motion, MotionT_co, normalised_times
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.models.promp.model import ProMP

# A time may be so many shares of the duration off either end by rounding.
_ULPS = 1e-9

_LEAST_WEIGHTS, _MOST_WEIGHTS = 5, 40  # worth trying

Task = Callable[[Float64Array], tuple[Any, Any]]


@dataclass(frozen=True, eq=False)
class ProMPSkill(Generic[MotionT_co]):
    """What was learned; made by `ProMP.fit`.

    Attributes:
        model: the settings that it was fitted with.
        basis: functions of the phase.
        chart: what the d columns are: the coordinates of points, the joints, or for poses the
            position and a rotation vector from a reference orientation.
        weights: distribution of the weights of the columns, one column after the other.
        noise: (d,) variances of the demonstrations about their curves.
        scale: (d,) reach of the motion.
        duration: s.
        bounds: lower and upper limits (d,), or None.
    """

    model: ProMP
    basis: Basis
    chart: Chart[MotionT_co]
    weights: Gaussian
    noise: Float64Array
    scale: Float64Array
    duration: float
    bounds: tuple[Float64Array, Float64Array] | None = None

    kind: ClassVar[str] = "promp"

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours; a rhythmic motion has no goal."""
        parts = {"start", "goal", "duration"}
        return frozenset(parts - {"goal"} if self.basis.is_rhythmic else parts)

    def distribution(
        self, times: ArrayLike, *, order: int = 0
    ) -> tuple[Float64Array, Float64Array]:
        """Mean (n, d) and covariance (n, d, d) at times (n,), s, in [0, duration].

        order: 0 positions, 1 velocities, 2 accelerations. Without the noise of the demonstrations.
        Raises InvalidInput.
        """
        rows = self._rows(times, order)
        size, count = self.chart.width, self.basis.count
        blocks = self.weights.covariance.reshape(size, count, size, count).transpose(1, 3, 0, 2)
        pairs = (rows[:, :, None] * rows[:, None, :]).reshape(len(rows), -1)
        covariance = pairs @ blocks.reshape(count * count, size * size)
        mean = rows @ self.weights.mean.reshape(size, count).T
        return mean, covariance.reshape(len(rows), size, size)

    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> MotionT_co:
        """The mean motion, conditioned on start and goal where given; of the type that was shown.

        start, goal: (d,), for poses (position (3,), orientation (4,)) or the position alone.
        duration: s, > 0. dt: s, upper bound of the sampling step. Joints come with velocities and
        accelerations. Raises InvalidInput; UnsupportedQuery for obstacles.
        """
        if len(obstacles) > 0:
            raise UnsupportedQuery("obstacles: this model cannot avoid them; see FastMarching")
        check.number(dt, "dt", above=0.0)
        skill = self if duration is None else self.lasting(duration)
        given = {"start": (start, 0.0), "goal": (goal, 1.0)}
        if goal is not None and self.basis.is_rhythmic:
            raise UnsupportedQuery("goal: a rhythmic motion has none, it ends where it starts")
        for name, (value, phase) in given.items():
            if value is not None:
                wanted = self.chart.target(value, name, phase)
                skill = skill._observed(name, np.array([phase]), wanted[None])
        return skill._motion(skill.weights.mean, even_times(skill.duration, dt))

    def condition(
        self,
        time: ArrayLike,
        position: Place,
        *,
        covariance: ArrayLike | None = None,
        order: int = 0,
        columns: Sequence[int] | None = None,
    ) -> ProMPSkill[MotionT_co]:
        """A skill that passes a via point, or several; call it again for more.

        time: s, in [0, duration]. position: (d,), for poses as in `generate`. For several via
        points (m,) and (m, d). covariance: (p, p) of the values observed at each, by default none:
        the motion passes exactly. order: 1 to give velocities instead, 2 accelerations. columns:
        the p ones that are observed, by default all that a position has. Raises InvalidInput, also
        where the motion is already fixed at this time to something else.
        """
        check.integer(order, "order", at_least=0, at_most=2)
        several = isinstance(time, list | tuple) or getattr(time, "ndim", 0) > 0
        phases = self._phases(time if several else [time], "time")
        if columns is None and order == 0 and self.chart.kind == "poses":
            if several:
                raise InvalidInput("time: expected one time for a pose, call again for more")
            value = self.chart.target(position, "position", float(phases[0]))
            return self._observed("position", phases, value[None], covariance)
        chosen = self.chart.every if columns is None else self._columns(columns)
        shape = (len(phases), len(chosen)) if several else (len(chosen),)
        values = check.array(position, "position", shape=shape).reshape(-1, len(chosen))
        return self._observed("position", phases, values, covariance, columns=chosen, order=order)

    def condition_task(
        self, time: float, value: ArrayLike, task: Task, *, covariance: ArrayLike | None = None
    ) -> ProMPSkill[MotionT_co]:
        """A skill that passes a via point in a task space, such as a tool's position.

        time: s. value: (p,). task: takes the columns (d,), gives their value (p,) in the task
        space and its Jacobian (p, d); for joints an arm's kinematics. covariance: (p, p), by
        default the motion passes exactly. Raises InvalidInput, also where the mean motion cannot
        be brought there. Source: Gomez-Gonzalez et al. 2020, section IV-D, iterated.
        """
        (phase,) = self._phases([time], "time")
        rows = self._selection(self.basis(np.array([phase])), range(self.chart.width))
        noise = None if covariance is None else observation.noise_of(covariance, np.size(value))
        return self.with_weights(observation.through(self, rows, value, task, noise))

    def lasting(self, duration: float) -> ProMPSkill[MotionT_co]:
        """The same motion in another duration, s, > 0. Raises InvalidInput."""
        return replace(self, duration=check.number(duration, "duration", above=0.0))

    def within(self, lower: ArrayLike, upper: ArrayLike) -> ProMPSkill[MotionT_co]:
        """A skill whose mean and samples keep limits (d,), infinite ones allowed.

        They are moved the least that the covariance allows: along what varies, so that via points
        stay. Raises InvalidInput where these lie outside.
        """
        bounds = limits.checked(lower, upper, self.chart.width)
        return replace(self, bounds=bounds).with_weights(self.weights)

    def sample(self, count: int, *, seed: int, dt: float = 0.01) -> list[MotionT_co]:
        """Random motions, as many as count. Raises InvalidInput."""
        check.number(dt, "dt", above=0.0)
        times = even_times(self.duration, dt)
        return [self._motion(weights, times) for weights in self.sample_weights(count, seed=seed)]

    def sample_weights(self, count: int, *, seed: int) -> Float64Array:
        """Random weight vectors (count, d k), inside the limits. Raises InvalidInput."""
        size = check.integer(count, "count", at_least=1)
        rng = np.random.default_rng(check.integer(seed, "seed", at_least=0))
        normal = rng.standard_normal((size, len(self.weights.mean)))
        drawn = self.weights.mean + normal @ self.weights.root.T
        if self.bounds is None:
            return drawn
        return np.stack(
            [
                limits.moved_inside(
                    Gaussian(weights, self.weights.covariance), self.basis, self.bounds, self.scale
                )
                for weights in drawn
            ]
        )

    def log_likelihood(self, trajectory: Motion) -> float:
        """The logarithm of the density of a motion, its samples noisy as the demonstrations'.

        It may last differently: its time counts as a share. Raises InvalidInput.
        """
        if not hasattr(trajectory, "positions") or len(trajectory.times) < 2:
            raise InvalidInput("trajectory: expected a motion of at least two samples")
        phases = normalised_times(trajectory.times)
        values = self.chart.columns(trajectory, phases, "trajectory")
        return observation.log_density(self, phases, values)

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[MotionT_co]]:
        """Its number of weights, where there are demonstrations to fit again.

        The skill fitted again has the same settings, duration and limits, but no via points.
        """
        if len(demonstrations) == 0:
            return []

        def fitted(weights: int) -> ProMPSkill[MotionT_co]:
            made = replace(self.model, weights=weights).fit(demonstrations)
            again = cast(ProMPSkill[MotionT_co], made).lasting(self.duration)
            return again if self.bounds is None else again.within(*self.bounds)

        most = _MOST_WEIGHTS
        return [
            whole_number("weights", self.basis.count, least=_LEAST_WEIGHTS, most=most, apply=fitted)
        ]

    def save(self, path: StrPath) -> None:
        """Writes the skill to a .npz file that `load_skill` reads. Raises InvalidInput."""
        archive.write(path, self.kind, *self.to_archive())

    def to_archive(self) -> tuple[dict[str, Any], archive.Arrays]:
        """Settings and arrays that `from_archive` puts together again."""
        settings = {
            "model": asdict(self.model),
            "duration": self.duration,
            **self.chart.settings(),
        }
        arrays = {
            "mean": self.weights.mean,
            "covariance": self.weights.covariance,
            "noise": self.noise,
            "scale": self.scale,
            **self.chart.arrays(),
        }
        if self.bounds is not None:
            arrays["lower"], arrays["upper"] = self.bounds
        return settings, arrays

    def with_weights(self, weights: Gaussian) -> ProMPSkill[MotionT_co]:
        """Itself with other weights, moved inside the limits."""
        if self.bounds is not None:
            mean = limits.moved_inside(weights, self.basis, self.bounds, self.scale)
            weights = Gaussian(mean, weights.covariance)
        return replace(self, weights=weights)

    def _observed(
        self,
        name: str,
        phases: Float64Array,
        values: Float64Array,
        covariance: Any = None,
        *,
        columns: Any = None,
        order: int = 0,
    ) -> ProMPSkill[MotionT_co]:
        chosen = self.chart.every[: values.shape[1]] if columns is None else columns
        noise = None if covariance is None else observation.noise_of(covariance, len(chosen))
        rows, scale = self.basis(phases, order), self.scale[chosen]
        if order > 0:
            pace = self.duration**-order
            rows, scale = rows * pace, scale * pace
        weights = observation.of_columns(
            self.weights, rows, chosen, values, noise, scale=scale, name=name
        )
        return self.with_weights(weights)

    def _selection(self, row: Float64Array, columns: Sequence[int]) -> Float64Array:
        return np.asarray(np.kron(np.eye(self.chart.width)[list(columns)], row))

    def _rows(self, times: Any, order: int) -> Float64Array:
        check.integer(order, "order", at_least=0, at_most=2)
        return self.basis(self._phases(times, "times"), order) * self.duration**-order

    def _phases(self, times: Any, name: str) -> Float64Array:
        given = check.array(times, name, shape=("n",)) / self.duration
        if self.basis.is_rhythmic:
            return given
        first, last = _extent(given)
        # A grid of times up to the duration may end an ulp beyond it.
        if first < -_ULPS or last > 1.0 + _ULPS:
            raise InvalidInput(
                f"{name}: expected times in [0, {self.duration:.6g}] s, "
                f"got {first * self.duration:.6g} to {last * self.duration:.6g} s"
            )
        return given if first >= 0.0 and last <= 1.0 else np.clip(given, 0.0, 1.0)

    def _columns(self, columns: Sequence[int]) -> Any:
        width = self.chart.width
        chosen = [
            check.integer(column, "columns", at_least=0, at_most=width - 1) for column in columns
        ]
        if not chosen or len(set(chosen)) != len(chosen):
            raise InvalidInput(f"columns: expected different ones below {width}, got {columns}")
        return np.array(chosen)

    def _motion(self, weights: Float64Array, times: Float64Array) -> MotionT_co:
        phases = times / self.duration
        curves = weights.reshape(self.chart.width, -1).T
        orders = (0, 1, 2) if self.chart.kind == "joints" else (0,)
        values = (self.basis(phases, order) @ curves * self.duration**-order for order in orders)
        return self.chart.motion(times, phases, *values)


def _extent(values: Float64Array) -> tuple[float, float]:
    """Least and largest; where there are none, in the middle of [0, 1]."""
    if len(values) == 1:  # the quick way: via points come one at a time
        return float(values[0]), float(values[0])
    return (float(values.min()), float(values.max())) if len(values) > 0 else (0.5, 0.5)
