"""Probabilistic movement primitives: normal distributions over motions.

A motion is a weighted sum of basis functions of its phase; over the demonstrations, the weights are
normally distributed.

Source: Paraschos et al. 2013, "Probabilistic movement primitives".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Literal, TypeAlias, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import Float64Array, InvalidInput, UnsupportedQuery
from leadthrough.models import protocol
from leadthrough.models.archive import Arrays, FittedSkill
from leadthrough.models.coordinates import Coordinates, coordinates_of, scales
from leadthrough.models.modes import common_phases, learned_by_mode
from leadthrough.models.promp import conditioning, estimation, limits
from leadthrough.models.promp.basis import (
    KINDS,
    MIN_FUNCTIONS,
    Basis,
    BasisKind,
    Drawing,
    phases_at,
)
from leadthrough.models.promp.conditioning import Primitive, TaskMap
from leadthrough.models.promp.estimation import Experience, Fit, Samples, checked_phases
from leadthrough.models.promp.gaussian import Gaussian
from leadthrough.models.promp.limits import Truncated
from leadthrough.models.protocol import Demonstrations, Outliers, fit_all, motions_of
from leadthrough.models.queries import CheckedQuery, check_place, checked_threads, even_times
from leadthrough.motion import Motion, MotionT, MotionT_co, Target, normalised_times

Estimator: TypeAlias = Literal["least_squares", "em"]

# Margins of the basis: of files which do not say, and of fewer functions than these, which cannot
# be spared outside the motion.
_EARLIER_MARGIN, _SMALL_MARGIN = 1.0, 0.25
_FEW = 15
# The number of weights that follows from the data: the first, and the largest; the misfit of curves
# from which on more are of use, as a fraction of the extent, and the samples that each needs.
_WEIGHTS, _MAX_FOLLOWING, _MISSED, _SAMPLES_A_WEIGHT = 20, 320, 0.02, 4
# Attributes of a skill that another distribution of the weights leaves as they are.
_KEPT = ("model", "basis", "coordinates", "noise", "scale", "duration", "bounds")


@dataclass(frozen=True)
class ProMP(protocol.Unfitted):
    """A probabilistic movement primitive of points, joints or poses.

    Attributes:
        weights: number of basis functions per column, 4 to 10,000; None for as few, doubled from 20
            up to 320, as keep least-squares curves within 2 % of the positions' extent (root mean
            square), with at least four samples each.
        basis: "gaussian", "bspline", or "rhythmic" for motions of one period that end where they
            began.
        width: standard deviation of the Gaussian and rhythmic functions, in spacings of their
            centres, 0.3 to 3. Velocities ripple with narrow functions, from 0.6 down; wide ones
            are hard to distinguish.
        estimator: "least_squares", which is quick and exact at both ends of every demonstration,
            or "em", which weighs noisy samples against each other and takes demonstrations of only
            a part of the motion.
        regularization: cost of a wiggle of a least-squares curve relative to that of an error, > 0.
        margin: how far the outermost Gaussian functions lie beyond the ends of the motion, in
            spacings of the centres, 0 to 1. The less, the finer is the detail that as many
            functions resolve; the more, the smoother is the motion at its ends. By default 1, and
            0.25 for fewer than 15 functions.
    """

    weights: int | None = None
    basis: BasisKind = "gaussian"
    width: float = 1.0
    estimator: Estimator = "least_squares"
    regularization: float = 1e-5
    margin: float | None = None

    slider: ClassVar[tuple[str, int, int]] = ("weights", 5, 40)

    def __post_init__(self) -> None:
        if self.weights is not None:
            check.integer(self.weights, "weights", at_least=MIN_FUNCTIONS, at_most=10_000)
        check.choice(self.basis, "basis", KINDS)
        check.number(self.width, "width", at_least=0.3, at_most=3.0)
        check.choice(self.estimator, "estimator", get_args(Estimator))
        check.number(self.regularization, "regularization", above=0.0)
        if self.margin is not None:
            check.number(self.margin, "margin", at_least=0.0, at_most=1.0)

    @one_blas_thread
    def fit(
        self,
        demonstrations: Demonstrations[MotionT],
        *,
        phases: Sequence[ArrayLike] | None = None,
        outliers: Outliers = "refuse",
    ) -> ProMPSkill[MotionT]:
        """A skill from demonstrations, all of points, of the same joints, or of poses.

        Args:
            demonstrations: one or more demonstrations, or motions, of one type.
            phases: for each demonstration, the phases (n,) of its samples, increasing in [0, 1];
                of rhythmic motions in periods. By default modes are told apart and those of one are
                aligned; rhythmic motions have their normalised times. A demonstration of a part of
                the motion covers a part of [0, 1], which needs estimator="em".
            outliers: without phases, treatment of a demonstration that contradicts all others, as
                for `learn`: "refuse", "drop", "keep". With phases none is compared.

        Raises:
            FitError: if there is no demonstration, one does not move or contradicts all others, one
                shows too small a part for its estimator, or none shows some part of the motion.

        Warns:
            MisalignmentWarning: if rhythmic motions are misaligned in time and no phases are given.
        """
        rhythmic = self.basis == "rhythmic"
        if phases is not None:
            motions = motions_of(demonstrations, outliers="keep")
            return self._fitted(motions, checked_phases(phases, motions, rhythmic=rhythmic))
        if rhythmic:
            motions = motions_of(demonstrations, outliers=outliers)
            protocol.warn_of_misalignment(motions)
            return self._fitted(motions, [normalised_times(motion.times) for motion in motions])
        return learned_by_mode(
            lambda own: self._fitted(own, common_phases(own)), demonstrations, outliers
        )

    def _fitted(
        self, motions: Sequence[MotionT], at: Sequence[Float64Array]
    ) -> ProMPSkill[MotionT]:
        """The skill of motions of one mode, with the phases (n,) of the samples of each."""
        coordinates = coordinates_of(motions, at)
        samples = _samples_of(coordinates, motions, at)
        if self.estimator == "em":
            basis = _basis_of(self)
            fit = estimation.expectation_maximisation(basis, samples)
        else:
            estimation.refuse_parts(at)
            basis, fit = self._least_squares(samples, coordinates.size)
        whole = [m.duration / float(u[-1] - u[0]) for m, u in zip(motions, at, strict=True)]
        duration = float(np.median(whole))
        experience = None
        if len(fit.curves) > 0:
            # In their own time, as a motion that has begun is: its timing is part of a forecast.
            own = [
                u[0] + (u[-1] - u[0]) * normalised_times(each.times)
                for each, u in zip(motions, at, strict=True)
            ]
            curves = fit.curves
            if self.estimator == "least_squares" and not all(map(np.array_equal, own, at)):
                timed = _samples_of(coordinates, motions, own)
                curves, _ = estimation.fitted_curves(basis, timed, self.regularization)
            paces = np.log(np.divide(whole, duration))
            experience = Experience(basis, curves, paces, fit.noise, samples.scale)
        return ProMPSkill(
            replace(self, weights=basis.count),
            basis,
            coordinates,
            fit.weights,
            fit.noise,
            samples.scale,
            duration,
            experience=experience,
        )

    def _least_squares(self, samples: Samples, size: int) -> tuple[Basis, Fit]:
        """Curves through positions, the first columns, and others, with the basis they need."""
        model = self
        extents = [np.linalg.norm(np.ptp(each[:, :size], axis=0)) for each in samples.columns]
        missed = _MISSED * float(np.mean(extents))
        most = min(_MAX_FOLLOWING, min(map(len, samples.phases)) // _SAMPLES_A_WEIGHT)
        while True:
            basis = _basis_of(model)
            curves, noise = estimation.fitted_curves(basis, samples, self.regularization)
            is_near = float(np.sqrt(noise[:size].sum())) <= missed or missed == 0.0
            if self.weights is not None or is_near or 2 * basis.count > most:
                return basis, Fit(estimation.shrunk(curves, basis, samples.scale), noise, curves)
            model = replace(self, weights=2 * basis.count)


def _samples_of(
    coordinates: Coordinates, motions: Sequence[Motion], phases: Sequence[Float64Array]
) -> Samples:
    """The columns of motions at phases."""
    columns = [
        coordinates.columns(motion, u, f"demonstrations[{i}]")
        for i, (motion, u) in enumerate(zip(motions, phases, strict=True))
    ]
    return Samples(phases, columns, scales(columns, coordinates))


@dataclass(frozen=True, eq=False)
class ProMPSkill(Primitive[MotionT_co], FittedSkill[MotionT_co]):
    """A normal distribution of motions; made by `ProMP.fit`.

    `generate` returns its mean, joints with velocities and accelerations. Inside the demonstrated
    range it is conditioned on a start and a goal; farther off it is shifted, and no phase moves by
    more than one and a half times the move of the ends. A rhythmic motion has no goal.

    Attributes:
        model: the settings that it was fitted with.
        basis: the k basis functions of the phase.
        coordinates: meaning of the d columns: points, joints, or for poses the
            position and a rotation vector from a reference orientation.
        free: distribution of the weights (d k,), one column after the other, before the limits.
        noise: variances (d,) of the demonstrations about their curves.
        scale: reach (d,) of the motion.
        duration: duration of the motion, s.
        bounds: lower and upper limits (d,) each, or None.
        experience: the demonstrations, as long as the skill is as it was fitted.
    """

    model: ProMP
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

        They are those of `weights`, as estimated: the uncertainty that few demonstrations leave
        about mean and covariance is not part of them, nor of `sample` and `condition`. It is part
        of the covariances of the skills that `infer` returns.

        Args:
            times: times (n,), s, in [0, duration]; of a rhythmic motion any.
            order: 0 for positions, 1 for velocities, per s, 2 for accelerations, per s^2.

        Returns:
            Mean (n, d) and covariance (n, d, d).
        """
        check.integer(order, "order", at_least=0, at_most=2)
        rows = self.basis(self._phases(times, "times", at_least=1), order) * self.duration**-order
        return self.weights.columns_at(rows)

    def _answer(self, query: CheckedQuery) -> MotionT_co:
        if query.goal is not None and self.basis.is_rhythmic:
            raise UnsupportedQuery(
                "goal: a rhythmic motion has none, it ends where it starts; leave it out"
            )
        skill = self if query.duration is None else self.lasting(query.duration)
        asked = conditioning.asked(self.coordinates, query.start, query.goal)
        skill = conditioning.moved(skill, asked) if asked else skill
        times = even_times(skill.duration, query.dt)
        drawing = Drawing(skill.coordinates, skill.basis, times, skill.duration)
        return drawing.motions(skill.weights.mean[None], threads=1)[0]

    def novelty(self, *, start: Target | None = None, goal: Target | None = None) -> float:
        """Distance of a start and a goal from the demonstrated ones, in standard deviations.

        The largest deviation along any principal axis of the distribution of these ends. From
        about 3 on, the motion is an extrapolation: `generate` shifts it there.

        Args:
            start: as in `generate`.
            goal: as in `generate`.

        Returns:
            0 for the mean ends; infinite where the motion is fixed to something else.
        """
        asked = conditioning.asked(self.coordinates, start, goal)
        return conditioning.novelty(self, asked) if asked else 0.0

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
            order: of the values: 0 positions, 1 velocities, per s, 2 accelerations, per s^2.
            columns: indices of the p columns that the values are for; by default all; for poses
                those of the position or of the position and the orientation.

        Raises:
            InvalidInput: if an argument is wrong, if several via points are given for poses, if
                the motion is already fixed to something else at that time, or if exact via points
                are so close to each other that the basis can only throw the motion elsewhere.
        """
        plain = columns is None and covariance is not None and type(order) is int and order == 0
        if plain and self.bounds is None:
            observed = conditioning.quickly(self, time, position, covariance)
            if observed is not None:
                return self.with_weights(observed)
        check.integer(order, "order", at_least=0, at_most=2)
        several = check.rank(time) > 0
        phases = self._phases(time if several else [cast(float, time)], "time", at_least=1)
        if columns is None and order == 0 and self.coordinates.kind == "poses":
            if several:
                raise InvalidInput("time: expected one time for a pose; call again for more")
            chosen = None
            values = self.coordinates.target(position, "position", float(phases[0]))[None]
        else:
            chosen = conditioning.chosen(columns, self.coordinates)
            shape = (len(phases), len(chosen)) if several else (len(chosen),)
            values = check.array(position, "position", shape=shape).reshape(-1, len(chosen))
        skill = conditioning.of_values(
            self, phases, values, covariance, columns=chosen, order=order, name="position"
        )
        if covariance is None and order == 0:
            for place in cast(Sequence[Target], position) if several else [position]:
                check_place(place, self._own_motion, "position")
            columns_of = self.coordinates.every[: values.shape[1]] if chosen is None else chosen
            conditioning.refuse_too_close(self, skill, phases, values, columns_of)
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
            np.kron(np.eye(self.coordinates.width), self.basis(self._phases([time], "time")))
        )
        noise = conditioning.noise_of(covariance, np.size(value))
        return self.with_weights(conditioning.through(self, rows, value, task, noise))

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
        bounds = limits.checked(lower, upper, self.coordinates.width)
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
        """
        times = even_times(self.duration, check.number(dt, "dt", above=0.0))
        check.affordable_count(count, "count", each=len(times) * self.coordinates.width)
        checked_threads(threads)
        drawing = Drawing(self.coordinates, self.basis, times, self.duration)
        return drawing.motions(self.sample_weights(count, seed=seed), threads)

    def sample_weights(self, count: int, *, seed: int) -> Float64Array:
        """Random weight vectors, inside the limits.

        Args:
            count: number of vectors, >= 1.
            seed: seed of the random number generator, >= 0.

        Returns:
            Weights (count, d k), one column after the other.
        """
        size = check.affordable_count(count, "count", each=len(self.free.mean))
        rng = np.random.default_rng(check.integer(seed, "seed", at_least=0))
        return (self.free if self.bounds is None else self._truncated).draw(size, rng)

    def log_likelihood(self, trajectory: Motion) -> float:
        """Log density of a motion whose samples are as noisy as the demonstrations'.

        Args:
            trajectory: a motion of the type that was demonstrated, at least two samples. Its
                duration does not matter: it is compared over normalised time.
        """
        conditioning.check_seen(trajectory, "trajectory")
        phases = normalised_times(trajectory.times)
        values = self.coordinates.columns(trajectory, phases, "trajectory")
        return conditioning.log_density(self, phases, values)

    def _fitted_again(
        self, model: ProMP, demonstrations: Demonstrations[Motion]
    ) -> ProMPSkill[MotionT_co]:
        again = cast(ProMPSkill[MotionT_co], fit_all(model, demonstrations)).lasting(self.duration)
        return again if self.bounds is None else again.within(*self.bounds)

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        settings = {
            "model": asdict(self.model),
            "duration": self.duration,
            **self.coordinates.settings(),
        }
        arrays = {
            "mean": self.free.mean,
            "covariance": self.free.covariance,
            "noise": self.noise,
            "scale": self.scale,
            **self.coordinates.arrays(),
        }
        if self.bounds is not None:
            arrays["lower"], arrays["upper"] = self.bounds
            settings["truncated"] = True
        if self.experience is not None:
            arrays["curves"], arrays["paces"] = self.experience.curves, self.experience.paces
        return settings, arrays

    def _tables(self) -> dict[str, Any]:
        basis, width = self.basis, self.coordinates.width
        if basis.kind == "bspline" or self.coordinates.kind == "poses":
            raise self._not_exported()
        return {
            "joint_names": "\n".join(self.coordinates.joint_names),
            "duration": self.duration,
            "rhythmic": basis.is_rhythmic,
            "centres": basis.centres,
            "sharpness": basis.sharpness,
            "columns": width,
            "weights": self.weights.mean.reshape(width, -1).T,
        }

    def with_weights(self, weights: Gaussian) -> ProMPSkill[MotionT_co]:
        """The skill with another distribution of the weights, before the limits.

        Args:
            weights: distribution of the weights (d k,), one column after the other.

        Raises:
            InvalidInput: if the limits cannot be satisfied.
        """
        if self.bounds is not None:
            limits.moved_inside(weights, self.basis, self.bounds, self.scale)
        # Without the constructor, in half the time: controllers condition in a loop.
        made, own = object.__new__(type(self)), vars(self)
        vars(made).update({name: own[name] for name in _KEPT}, free=weights, experience=None)
        return made

    @cached_property
    def _truncated(self) -> Truncated:
        assert self.bounds is not None
        return Truncated(self.free, self.basis, self.bounds, self.scale)

    def _phases(self, times: ArrayLike, name: str, at_least: int = 0) -> Float64Array:
        cyclic = self.basis.is_rhythmic
        return phases_at(times, name, duration=self.duration, repeats=cyclic, at_least=at_least)


def from_archive(settings: dict[str, Any], arrays: Arrays) -> ProMPSkill:
    model = _model_of(settings)
    basis, coordinates = _basis_of(model), Coordinates.from_archive(settings, arrays)
    size = coordinates.width * basis.count
    weights = Gaussian(
        check.frozen(arrays["mean"], "mean", shape=(size,)),
        check.frozen(arrays["covariance"], "covariance", shape=(size, size)),
    )
    noise, scale = (
        check.frozen(arrays[name], name, shape=(coordinates.width,)) for name in ("noise", "scale")
    )
    bounds = None
    if "lower" in arrays:
        bounds = limits.checked(arrays["lower"], arrays["upper"], coordinates.width)
    experience = None
    if "curves" in arrays:
        curves = check.frozen(arrays["curves"], "curves", shape=("m", size))
        paces = check.frozen(arrays["paces"], "paces", shape=("n",))
        experience = Experience(basis, curves, paces, noise, scale)
    duration = float(settings["duration"])
    skill = ProMPSkill(
        model, basis, coordinates, weights, noise, scale, duration, bounds, experience
    )
    if bounds is not None and "truncated" not in settings:
        # An earlier version wrote the distribution that it had already moved inside the limits.
        vars(skill)["weights"] = weights
    return skill


def _model_of(settings: dict[str, Any]) -> ProMP:
    """The model in a file; the earliest ones have only its basis, in three entries."""
    if "model" in settings:
        return ProMP(**{"margin": _EARLIER_MARGIN, **settings["model"]})
    count, width = int(settings["count"]), float(settings.get("width", ProMP.width))
    return ProMP(weights=count, basis=settings["basis"], width=width, margin=_EARLIER_MARGIN)


def _basis_of(model: ProMP) -> Basis:
    margin, count = model.margin, _WEIGHTS if model.weights is None else model.weights
    if margin is None:
        margin = _EARLIER_MARGIN if count >= _FEW else _SMALL_MARGIN
    return Basis(model.basis, count, float(model.width), float(margin))
