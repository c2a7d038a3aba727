"""Mixtures over the time and the columns of motions, whose components follow phases.

The most likely components are thin and follow single demonstrations. So starts are clusters of the
times alone, and until EM has converged, no component is thinner than a fifth of the motion; from
there, a single step each with lower bounds leads to thin components.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Generic

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.models.coordinates import Coordinates, coordinates_of, mean_orientations
from leadthrough.models.gaussians import fitting
from leadthrough.models.gaussians.fitting import FittedMixture, Units, own_units, phase_units
from leadthrough.models.gaussians.mixture import (
    LAST_ITERATIONS,
    MIN_VARIANCE,
    Blocks,
    Mixture,
    Steps,
    bounded,
    fit_blocks,
    sums_of,
)
from leadthrough.models.modes import common_phases
from leadthrough.motion import Motion, MotionT, MotionT_co, lerp
from leadthrough.noise import noise_of

# Points of each demonstration, so that all count the same and the work is bounded. They are
# doubled, up to the second number, while lines between them leave a demonstration by more than a
# fraction of its extent and than so many deviations of its noise, as in motions of a minute.
SAMPLES, _MAX_SAMPLES, _CUT, _NOISE = 200, 1600, 0.01, 3.0

# The least variance of a component in any direction until EM has converged, in phase units, and in
# the single steps from there. Three steps without these bounds instead let a sample move the motion
# of joints seven times as far.
WIDE = 0.05
_THINNER = (0.03, 0.01, 0.003, 0.001)
# Components chosen by the data are doubled from the first number, as long as each has so many
# points of a demonstration, until the mean lies within this fraction of the motion's extent from
# that of the demonstrations, or lies within so many times this and stays: then it follows noise.
_FIRST_COMPONENTS, POINTS_A_COMPONENT, _MISSED = 8, 3, 0.02
_NEARLY, _GAINED = 2.0, 0.8
MAX_COMPONENTS = 512
# From so many components on, EM begins once, as it takes long, and ends at its first tolerance: the
# thousands of iterations that follow move a mean of so fine a detail by less than that.
_MANY_COMPONENTS = 65
_MAX_ITERATIONS = 200


def fit_phases(
    points: Float64Array,
    components: int | None,
    *,
    poses: bool,
    seed: int,
    starts: int,
    samples: int = SAMPLES,
) -> FittedMixture:
    """The mixture of times and columns whose components follow phases; None: as few as suffice."""

    def fitted(
        count: int, starts: int = starts, last_iterations: int = LAST_ITERATIONS
    ) -> FittedMixture:
        blocks, history = phase_blocks(
            [points],
            count,
            poses=poses,
            seed=seed,
            starts=starts,
            least=MIN_VARIANCE,
            last_iterations=last_iterations,
        )
        return FittedMixture(fitting.in_order(blocks), tuple(history))

    if components is not None:
        return fitted(components)
    mean = points.reshape(-1, samples, points.shape[1]).mean(axis=0)
    count, most, before, found = _FIRST_COMPONENTS, samples // POINTS_A_COMPONENT, np.inf, {}
    while True:
        # One start of EM, ended early, tells as well whether the components are enough.
        found[count] = fitted(count, 1, 0)
        missed = _missed(found[count].mixture, mean, poses=poses)
        if missed > _GAINED * before and before < _NEARLY * _MISSED:
            count //= 2
            break
        if missed <= _MISSED or 2 * count > most:
            break
        count, before = 2 * count, missed
    return fitted(count) if count < _MANY_COMPONENTS else found[count]


def _missed(mixture: Mixture, mean: Float64Array, *, poses: bool) -> float:
    """Largest distance of the mean positions of a mixture and of demonstrations, in extents."""
    columns = range(1, 4 if poses else mean.shape[1])
    found, _ = mixture.regress(mean[:, :1], inputs=[0], outputs=columns)
    positions = mean[:, columns]
    missed = np.linalg.norm(found - positions, axis=1).max()
    return float(missed) / (float(np.linalg.norm(np.ptp(positions, axis=0))) or 1.0)


def phase_blocks(
    blocks: Sequence[Float64Array],
    count: int,
    *,
    poses: bool,
    seed: int,
    starts: int,
    least: float,
    last_iterations: int = LAST_ITERATIONS,
) -> tuple[Blocks, list[float]]:
    """Components of times and columns given in blocks, each with the time first."""
    units = [phase_units(own_units(each), count, poses=poses) for each in blocks]
    scaled = [own.scaled(each) for each, own in zip(blocks, units, strict=True)]
    wide, history = fit_blocks(
        scaled,
        scaled[0][:, :1],
        count,
        seed=seed,
        starts=starts,
        least=WIDE,
        last_iterations=last_iterations,
    )
    thin, more = thinner(wide, Steps(scaled), least)
    history += more
    volume = sum(own.log_volume for own in units)
    return _unscaled(thin, units), [value - volume for value in history]


def adapted(mixture: Mixture, points: Float64Array, before: float, *, poses: bool) -> Mixture:
    """The mixture of new points (n, d) and of the `before` old ones that it stands for."""
    # Calinon and Billard 2007, direct method: the old mixture stands for the sums of its points.
    units = _units_of(mixture, poses=poses)
    covariances = units.scaled_covariances(mixture.covariances)
    old = Blocks(mixture.weights, (units.scaled(mixture.means),), (covariances,))
    blocks, sums = [units.scaled(points)], sums_of(old, before)
    steps = Steps(blocks, sums, least=WIDE)
    wide = replace(old, covariances=(bounded(covariances, WIDE),))
    converged, _ = steps.run(wide, _MAX_ITERATIONS)
    new, _ = thinner(converged, steps, MIN_VARIANCE)
    return Mixture(new.weights, units.means(new.means[0]), units.covariances(new.covariances[0]))


def _units_of(mixture: Mixture, *, poses: bool) -> Units:
    middle = mixture.weights @ mixture.means
    variances = np.einsum("kii->ki", mixture.covariances) + (mixture.means - middle) ** 2
    own = Units(middle, np.sqrt(mixture.weights @ variances))
    return phase_units(own, mixture.count, poses=poses)


def thinner(components: Blocks, steps: Steps, least: float) -> tuple[Blocks, list[float]]:
    """Components after a step of EM with each of the lower bounds, down to the least."""
    history = []
    responsibilities, _ = steps.expect(components)
    for bound in [*(each for each in _THINNER if each > least), least]:
        components = steps.bounded_by(bound).maximise(responsibilities)
        responsibilities, likelihood = steps.expect(components)
        history.append(likelihood)
    return components, history


def _unscaled(scaled: Blocks, units: Sequence[Units]) -> Blocks:
    """Components in their columns' own units."""
    return Blocks(
        scaled.weights,
        tuple(own.means(each) for each, own in zip(scaled.means, units, strict=True)),
        tuple(own.covariances(each) for each, own in zip(scaled.covariances, units, strict=True)),
    )


@dataclass(frozen=True, eq=False)
class Sampled(Generic[MotionT_co]):
    """Demonstrations, resampled at evenly spaced times."""

    motions: Sequence[MotionT_co]
    phases: Sequence[Float64Array]  # normalised times (n,) of each motion's samples
    coordinates: Coordinates[MotionT_co]
    duration: float  # median duration, s, to which all are stretched
    rows: Sequence[Float64Array]  # points (m, 1 + d) of each motion, the time first, s

    @property
    def points(self) -> Float64Array:
        return np.concatenate(self.rows)

    @property
    def ends(self) -> Float64Array:
        """Mean start and mean goal (2, d) of the motions."""
        return np.asarray(np.mean([each[[0, -1], 1:] for each in self.rows], axis=0))


def sampled(
    motions: Sequence[MotionT],
    *,
    middle: Callable[[Sequence[Float64Array]], Float64Array] = mean_orientations,
    least: int = SAMPLES,
) -> Sampled[MotionT]:
    """Motions, resampled at evenly spaced times of their common timing, at so many or more."""
    phases = common_phases(motions)
    coordinates = coordinates_of(motions, phases, middle=middle)
    duration = float(np.median([motion.duration for motion in motions]))
    count = samples_of(motions, phases, least)
    rows = timed_columns(motions, phases, coordinates, duration, count)
    return Sampled(motions, phases, coordinates, duration, rows)


def samples_of(motions: Sequence[Motion], phases: Sequence[Float64Array], least: int) -> int:
    """Number of evenly spaced samples, at least so many, that keep the detail of all motions."""
    count = SAMPLES
    pairs = tuple(zip(motions, phases, strict=True))
    while count < least or (
        count < _MAX_SAMPLES and any(_cuts(motion, at, count) for motion, at in pairs)
    ):
        count *= 2
    return count


def _cuts(motion: Motion, phases: Float64Array, count: int) -> bool:
    """Whether lines between so many evenly spaced samples leave a motion's positions."""
    if len(phases) <= count:
        return False
    even = np.linspace(0.0, 1.0, count)
    path = motion.positions
    missed = lerp(phases, even, lerp(even, phases, path)) - path
    extent = float(np.linalg.norm(np.ptp(path, axis=0)))
    allowed = max(_CUT * extent, _NOISE * noise_of(path) * np.sqrt(path.shape[1]))
    return bool(np.linalg.norm(missed, axis=1).max() > allowed)


def timed_columns(
    motions: Sequence[Motion],
    phases: Sequence[Float64Array],
    coordinates: Coordinates,
    duration: float,
    count: int = SAMPLES,
) -> list[Float64Array]:
    """Times, s, and columns (count, 1 + d) of each motion."""
    even = np.linspace(0.0, 1.0, count)
    result = []
    for i, (motion, at) in enumerate(zip(motions, phases, strict=True)):
        columns = coordinates.columns(motion, at, f"demonstrations[{i}]")
        values = [np.interp(even, at, column) for column in columns.T]
        result.append(np.column_stack([even * duration, *values]))
    return result
