"""Learned parts of primitives, discrete and rhythmic: weights by regression of a mean motion.

- "replay" (the default) minimises the squared distance between the replayed motion and the samples:
  the springs are linear in the weights and in the slopes at both ends, so the responses to each of
  them are the regressors. Nothing is differentiated, so noise is not amplified.
- "ridge" fits the force that the samples' finite differences require, all weights together.
- "lwr" fits each weight by itself, weighted by its kernel: w_i = s^T Psi_i f / s^T Psi_i s.
  Source: Schaal and Atkeson 1998; Ijspeert et al. 2013, eq. 2.14.

The last two are the literature's; second differences amplify the noise of the samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core
from leadthrough import check, rotations, sanity
from leadthrough.check import FitError, Float64Array, InvalidInput
from leadthrough.models.archive import Arrays, FittedSkill
from leadthrough.models.coordinates import (
    Posture,
    arrays_of,
    demonstrated_posture,
    mean_orientations,
    settings_of,
)
from leadthrough.models.dmp import transformation
from leadthrough.models.dmp.channels import PoseChannels
from leadthrough.models.dmp.orientation import (
    REPRESENTATIONS,
    OrientationCoordinates,
    learn,
    learn_closed,
)
from leadthrough.models.dmp.transformation import RATE, Ends, Kernels, TransformationSystem, course
from leadthrough.models.modes import common_phases
from leadthrough.models.protocol import Demonstrations, motions_of, warn_of_misalignment
from leadthrough.motion import (
    Event,
    JointTrajectory,
    Motion,
    MotionT_co,
    PoseTrajectory,
    agreed_events,
    events_of_plain,
    events_within,
    fields_of,
    lerp,
    moved_events,
    normalised_times,
    plain_events,
    rows_of,
)
from leadthrough.noise import noise_of

# A period whose last samples are missing, up to this fraction of it, counts as whole.
_SLACK = 0.02
_MIN_SAMPLES = 4  # of a period
# Of a rhythm: from its end to its start, in its extent; of single periods from their mean, in RMS.
_OPEN, _UNLIKE = 0.25, 0.4


@dataclass(frozen=True, eq=False)
class MeanMotion:
    """One motion that primitives are fitted to."""

    phases: Float64Array  # (n,) from 0 to 1
    positions: Float64Array  # (n, d)
    orientations: Float64Array | None  # (n, 4) w, x, y, z, or None
    duration: float  # s
    joint_names: tuple[str, ...] | None  # of joint motions, else None
    events: tuple[Event, ...] = ()  # at phases
    posture: Posture | None = None  # the arm's joints at phases, or None

    @property
    def size(self) -> float:
        """Diagonal of the box around the positions, in their unit."""
        return float(np.linalg.norm(np.ptp(self.positions, axis=0)))


def mean_motion(motions: Sequence[Motion], phases: Sequence[Float64Array]) -> MeanMotion:
    """The mean of motions over the phases (n,) of their samples."""
    first = motions[0]
    names = first.joint_names if isinstance(first, JointTrajectory) else None
    happened = agreed_events(
        [moved_events(each.events, each.times, u) for each, u in zip(motions, phases, strict=True)]
    )
    posture = demonstrated_posture(motions, phases)
    if len(motions) == 1:
        q = first.orientations if isinstance(first, PoseTrajectory) else None
        return MeanMotion(phases[0], first.positions, q, first.duration, names, happened, posture)
    count = max(len(motion.times) for motion in motions)
    even = np.linspace(0.0, 1.0, count)
    pairs = zip(phases, motions, strict=True)
    positions = np.mean([lerp(even, own, motion.positions) for own, motion in pairs], axis=0)
    duration = float(np.mean([motion.duration for motion in motions]))
    q = _mean_orientations(motions, phases, even)
    return MeanMotion(even, positions, q, duration, names, happened, posture)


def mean_cycle(demonstrations: Demonstrations[Motion], period: float | None) -> MeanMotion:
    """The mean over all whole periods in the demonstrations, closed: it ends where it began."""
    cycles = motions_of(demonstrations)
    if period is not None:
        cycles = [part for motion in cycles for part in _periods(motion, period)]
    warn_of_misalignment(cycles)
    mean = mean_motion(cycles, [normalised_times(motion.times) for motion in cycles])
    gap = mean.positions[-1] - mean.positions[0]
    _warn_of_no_rhythm(mean, cycles, float(np.linalg.norm(gap)))
    positions = mean.positions - np.outer(mean.phases, gap)
    q = mean.orientations
    if q is not None:
        off = rotations.log(rotations.compose(q[:1], rotations.inverse(q[-1:])))
        q = rotations.compose(rotations.exp(np.outer(mean.phases, off[0])), q)
    return replace(mean, positions=positions, orientations=q)


def _warn_of_no_rhythm(mean: MeanMotion, cycles: Sequence[Motion], gap: float) -> None:
    """Warns where one mean period, closed, is unlike the demonstrations."""
    rows = [lerp(mean.phases, normalised_times(each.times), each.positions) for each in cycles]
    about = np.array([each - each.mean(axis=0) for each in rows])
    unlike = np.std(about - about.mean(axis=0))
    if gap > _OPEN * mean.size or unlike > _UNLIKE * np.std(about):
        sanity.warn(
            f"demonstrations: periods of {mean.duration:.4g} s end {gap:.3g} from where they begin "
            f"and differ by {unlike:.3g}, and their mean is closed; give whole periods from the "
            "same phase on, or the right period"
        )


def _mean_orientations(
    motions: Sequence[Motion], phases: Sequence[Float64Array], even: Float64Array
) -> Float64Array | None:
    layers = [
        rotations.interpolate(own, motion.orientations, even)
        for own, motion in zip(phases, motions, strict=True)
        if isinstance(motion, PoseTrajectory)
    ]
    return mean_orientations(layers) if layers else None


def _periods(motion: Motion, period: float) -> list[Motion]:
    """The whole periods of a motion, each from time 0 on."""
    count = int(motion.duration / period + _SLACK)
    if count == 0:
        raise FitError(
            f"demonstrations: expected at least one period of {period:.4g} s, "
            f"got {motion.duration:.4g} s"
        )
    samples = int(np.ceil(len(motion.times) * period / motion.duration))
    if samples < _MIN_SAMPLES:
        raise FitError(
            f"demonstrations: expected at least {_MIN_SAMPLES} samples in a period of "
            f"{period:.4g} s, got {samples}"
        )
    return [_part(motion, index * period, period, samples) for index in range(count)]


def _part(motion: Motion, begin: float, period: float, samples: int) -> Motion:
    own = np.linspace(0.0, period, samples)
    at = np.minimum(motion.times[0] + begin + own, motion.times[-1])
    rows = {name: lerp(at, motion.times, each) for name, each in rows_of(motion).items()}
    if isinstance(motion, PoseTrajectory):
        rows["orientations"] = rotations.interpolate(motion.times, motion.orientations, at)
    happening = moved_events(events_within(motion.events, at[0], at[-1]), at, own)
    return replace(motion, times=own, events=happening, **fields_of(motion, rows))


REGRESSIONS = ("replay", "ridge", "lwr")

# Ridge penalty, as a fraction of the regressors' mean square: enough where samples are fewer than
# weights, and far below what changes a fit.
_RIDGE = 1e-8
# Overlap of kernels whose weights are fitted alone: that of twenty with the widths of Ijspeert et
# al. 2013, n / c_i^2. It replays better than a wider one, and than those widths of more kernels.
_ALONE = 0.4
# A motion as short as this beside its range cannot scale a force.
_MIN_DISTANCE = 1e-3
# A channel that moves less than this fraction of its group's largest range needs no force.
_STILL = 1e-6
# The weights that follow from the data begin with this number, and end where the replay is within
# so many standard deviations of the noise, or this fraction of the extent.
_MIN_WEIGHTS, _NOISE, _DETAIL = 50, 3.0, 1e-3
_SWUNG_IN = 4.0  # periods
_TOGETHER = 100  # kernels of which the responses are computed at a time
_POSITION, _ORIENTATION = slice(3), slice(3, 6)  # channels of poses


@dataclass(frozen=True, eq=False)
class _Target:
    """Samples that a transformation system is fitted to."""

    form: str  # one of FORMS
    phases: Float64Array  # (n,) from 0 to 1
    values: Float64Array  # (n, channels)
    kernels: Kernels  # of the force
    ends: Ends  # first and last values, at rest
    groups: Sequence[slice]  # channels that have a unit in common, each

    @property
    def scale(self) -> Float64Array:
        """Factor of the force, (channels,); 1 for channels that need none."""
        if self.form != "ijspeert":
            return np.ones(len(self.ends.goal))
        return np.where(self._unmoved, 1.0, self.ends.goal - self.ends.start)

    def check_scale(self) -> None:
        """Refuses a goal that cannot scale a force."""
        if self.form != "ijspeert":
            return
        short = ~self._unmoved & (np.abs(self.scale) < _MIN_DISTANCE * self._reach)
        if short.any():
            raise FitError(
                f"demonstrations: channel {int(np.argmax(short))} ends where it began, so the goal "
                'cannot scale its force; use the form "blended" or "hoffmann"'
            )

    @property
    def _reach(self) -> Float64Array:
        """The range of the channel of each one's group that moves most, (channels,)."""
        ranges = np.ptp(self.values, axis=0)
        for group in self.groups:
            ranges[group] = ranges[group].max()
        return np.asarray(ranges)

    @property
    def _unmoved(self) -> NDArray[np.bool_]:
        """Mask (channels,) of those that move so little that they need no force."""
        return np.asarray(np.ptp(self.values, axis=0) <= _STILL * self._reach)


def fit(
    phases: Float64Array,
    values: Float64Array,
    groups: Sequence[slice],
    *,
    weights: int,
    form: str,
    regression: str,
) -> TransformationSystem:
    """A system that moves through values at phases."""
    rest = np.zeros(values.shape[1])
    ends = Ends(values[0].copy(), values[-1].copy(), rest, rest)
    overlap = _ALONE if regression == "lwr" else transformation.OVERLAP
    target = _Target(
        form, phases, values, transformation.kernels_of(form, weights, overlap), ends, groups
    )
    target.check_scale()
    with np.errstate(all="ignore"):  # values that are not finite are refused below
        solution, slopes = (
            _by_replay(target) if regression == "replay" else _by_force(target, regression)
        )
    if not (np.isfinite(solution).all() and np.isfinite(slopes).all()):
        raise FitError("demonstrations: numbers too large to fit; use another unit")
    return TransformationSystem(
        form, solution, replace(ends, start_slope=slopes[0], goal_slope=slopes[1]), overlap
    )


def fit_with_enough(
    phases: Float64Array, values: Float64Array, groups: Sequence[slice], **settings: Any
) -> TransformationSystem:
    """A system with as few weights, doubled from 50 to 1000, as replay the values closely."""
    weights = _MIN_WEIGHTS
    while True:
        system = fit(phases, values, groups, weights=weights, **settings)
        if weights == transformation.MAX_WEIGHTS or _replays(system, phases, values, groups):
            return system
        weights = min(2 * weights, transformation.MAX_WEIGHTS)


def _replays(
    system: TransformationSystem,
    phases: Float64Array,
    values: Float64Array,
    groups: Sequence[slice],
) -> bool:
    """Whether values are replayed within their noise or a thousandth of their extent."""
    ends = system.ends
    made, _ = core.dmp_rollout(
        system.forces, system.demonstrated_course, ends.start, ends.start_slope, phases
    )
    for group in groups:
        own = values[:, group]
        noise = _NOISE * noise_of(own) * np.sqrt(own.shape[1])
        allowed = max(noise, _DETAIL * float(np.linalg.norm(np.ptp(own, axis=0))))
        if np.linalg.norm(made[:, group] - own, axis=1).max() > allowed:
            return False
    return True


def fit_rhythm(phases: Float64Array, values: Float64Array, *, weights: int) -> TransformationSystem:
    """A system that repeats the values of one period, fitted by replay."""
    from scipy.integrate import trapezoid

    with np.errstate(all="ignore"):  # values that are not finite are refused below
        centre = trapezoid(values, phases, axis=0)
        kernels = transformation.kernels_of(transformation.RHYTHMIC, weights)
        # The springs have swung in after this many periods, to 16 digits.
        response, _ = _responses(kernels, np.concatenate([[0.0], _SWUNG_IN + phases]))
        solution = _ridge(response[1:], values - centre)
    if not np.isfinite(solution).all():
        raise FitError("demonstrations: numbers too large to fit; use another unit")
    rest = np.zeros(values.shape[1])
    ends = Ends(centre, centre, rest, rest)
    system = TransformationSystem(transformation.RHYTHMIC, np.ascontiguousarray(solution), ends)
    swung_in = np.array([0.0, _SWUNG_IN])
    asked = course(transformation.RHYTHMIC, system.ends)
    y, slopes = core.dmp_rollout(system.forces, asked, centre, rest, swung_in)
    return replace(system, ends=Ends(y[-1].copy(), centre, slopes[-1].copy(), rest))


def _by_replay(target: _Target) -> tuple[Float64Array, Float64Array]:
    """Weights, and slopes at both ends."""
    response, last = _responses(target.kernels, target.phases)
    known, slope_responses = _without_force(target)
    design: Float64Array = np.hstack([response, slope_responses])
    gram = design.T @ design
    count, channels = last.shape[1], target.values.shape[1]
    gram[np.diag_indices(len(gram))] += _RIDGE * np.trace(gram[:count, :count]) / count
    wanted = design.T @ ((target.values - known) / target.scale)
    constraints = np.zeros((len(gram), 2))
    constraints[:count] = last.T
    solved = np.asarray(np.linalg.solve(gram, np.hstack([wanted, constraints])), np.float64)
    solution = solved[:, :channels]
    if target.form == "blended":
        solution = _settled(solution, constraints, solved[:, channels:])
    slopes = np.zeros((2, channels))
    slopes[: len(gram) - count] = solution[count:] * target.scale
    return np.ascontiguousarray(solution[:count]), slopes


def _by_force(target: _Target, regression: str) -> tuple[Float64Array, Float64Array]:
    """Weights, and slopes at both ends."""
    edge: Any = min(2, len(target.phases) - 1)
    rates = np.asarray(np.gradient(target.values, target.phases, axis=0, edge_order=edge))
    bends = np.asarray(np.gradient(rates, target.phases, axis=0, edge_order=edge))
    ends = replace(target.ends, start_slope=rates[0], goal_slope=rates[-1])
    r, r_rates, r_bends = _reference(target.form, ends, target.phases)
    force = bends - r_bends + 2.0 * RATE * (rates - r_rates) + RATE**2 * (target.values - r)
    fade = _at(target.kernels.fade[:, None], target.kernels, target.phases)
    force = (force - fade * course(target.form, ends).drive) / target.scale
    if regression == "ridge":
        solution = _ridge(_at(target.kernels.features(), target.kernels, target.phases), force)
    else:
        solution = _locally_weighted(target.kernels, target.phases, force)
    if target.form == "blended":
        _, last = _responses(target.kernels, np.array([0.0, 1.0]))
        solution = _settled(solution, last.T, last.T)
    return np.ascontiguousarray(solution), rates[[0, -1]]


def _ridge(design: Float64Array, wanted: Float64Array) -> Float64Array:
    gram = design.T @ design
    gram[np.diag_indices(len(gram))] += _RIDGE * np.trace(gram) / len(gram)
    return np.asarray(np.linalg.solve(gram, design.T @ wanted))


def _locally_weighted(kernels: Kernels, phases: Float64Array, force: Float64Array) -> Float64Array:
    values, regressor = (_at(each, kernels, phases) for each in kernels.tables())
    above = (values * regressor).T @ force
    below = np.einsum("nw,nw->w", values, regressor**2)[:, None]
    return np.asarray(np.divide(above, below, out=np.zeros_like(above), where=below > 0.0))


def _at(table: Float64Array, kernels: Kernels, phases: Float64Array) -> Float64Array:
    """Rows of a table over the nodes, linear between them."""
    place = phases * (len(kernels.phases) - 1)
    left = np.clip(place.astype(np.intp), 0, len(kernels.phases) - 2)
    fraction = (place - left)[:, None]
    return np.asarray((1.0 - fraction) * table[left] + fraction * table[left + 1])


def _responses(kernels: Kernels, phases: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Errors (n, weights) that each function alone makes, and the last value and slope of them."""
    values, last = [], []
    # Of several groups the last would be kept, and never asked for first.
    alone = _each_alone if len(kernels.centres) <= _TOGETHER else _each_alone.__wrapped__
    for first in range(0, len(kernels.centres), _TOGETHER):
        forces, channels = alone(kernels, first)
        rest = np.zeros(channels)
        still = course("hoffmann", Ends(rest, rest, rest, rest))
        made, slopes = core.dmp_rollout(forces, still, rest, rest, phases)
        values.append(made)
        last.append(np.stack([made[-1], slopes[-1]]))
    return (values[0], last[0]) if len(values) == 1 else (np.hstack(values), np.hstack(last))


@lru_cache(maxsize=1)  # those of the last fit; of many weights they take tens of megabytes
def _each_alone(kernels: Kernels, first: int) -> tuple[core.DmpForces, int]:
    """Forces of one channel for each of some kernels, of which the weight is 1, and how many."""
    nodes = kernels.features(some=slice(first, first + _TOGETHER))
    return core.DmpForces(nodes, kernels.fade, RATE, kernels.rhythmic), nodes.shape[1]


def _without_force(target: _Target) -> tuple[Float64Array, Float64Array]:
    """Values (n, channels) from rest to rest without a learned force; responses to the slopes."""
    phases, ends = target.phases, target.ends
    if target.form == "blended":
        nothing, one, two = np.zeros(2), np.array([1.0, 0.0]), np.array([0.0, 1.0])
        powers = phases[:, None] ** np.arange(6.0)
        slopes = transformation.minimum_jerk(Ends(nothing, nothing, one, two))
        return powers @ transformation.minimum_jerk(ends), powers @ slopes
    no_weights = np.zeros((len(target.kernels.centres), len(ends.start)))
    forces = transformation.tabulated(target.kernels, no_weights)
    known, _ = core.dmp_rollout(
        forces, course(target.form, ends), ends.start, ends.start_slope, phases
    )
    return known, (phases * np.exp(-RATE * phases))[:, None]


def _reference(
    form: str, ends: Ends, phases: Float64Array
) -> tuple[Float64Array, Float64Array, Float64Array]:
    if form != "blended":
        nothing = np.zeros((1, len(ends.goal)))
        return ends.goal[None], nothing, nothing
    polynomial: Any = np.polynomial.polynomial
    coefficients = transformation.minimum_jerk(ends)
    r, rates, bends = (
        polynomial.polyval(phases, polynomial.polyder(coefficients, order)).T for order in range(3)
    )
    return np.asarray(r), np.asarray(rates), np.asarray(bends)


def _settled(
    solution: Float64Array, constraints: Float64Array, correction: Float64Array
) -> Float64Array:
    """The solution moved along the correction (n, 2) until constraints (n, 2) on it vanish."""
    excess = constraints.T @ solution
    return np.asarray(solution - correction @ np.linalg.solve(constraints.T @ correction, excess))


class Parts(TypedDict):
    """Attributes that all primitives have."""

    system: TransformationSystem
    events: tuple[Event, ...]
    joint_names: tuple[str, ...] | None
    orientation: OrientationCoordinates | None
    posture: Posture | None


@dataclass(frozen=True, eq=False, kw_only=True)
class Primitive(FittedSkill[MotionT_co]):
    """A learned primitive; its attributes are documented where they are public."""

    system: TransformationSystem
    events: tuple[Event, ...] = ()
    joint_names: tuple[str, ...] | None = None
    orientation: OrientationCoordinates | None = None
    posture: Posture | None = None

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        settings = {
            "events": plain_events(self.events),
            "joint_names": None if self.joint_names is None else list(self.joint_names),
            **settings_of(self.posture),
        }
        orientation = {} if self.orientation is None else self.orientation.arrays()
        return settings, {**self.system.arrays(), **arrays_of(self.posture), **orientation}


def take_parts(
    settings: dict[str, Any], arrays: Arrays, *, form: str, weights: int, representation: str
) -> Parts:
    """The parts in a file, taken out of its settings."""
    names = settings.pop("joint_names", None)
    orientation = None
    if "controls" in arrays:
        rhythmic = form == transformation.RHYTHMIC
        orientation = OrientationCoordinates.from_arrays(representation, arrays, rhythmic=rhythmic)
    return Parts(
        system=TransformationSystem.from_arrays(form, weights, arrays),
        events=events_of_plain(settings.pop("events", ())),
        joint_names=None if names is None else tuple(names),
        orientation=orientation,
        posture=Posture.from_archive(settings, arrays),
    )


def check_choices(form: str, regression: str, orientation: str) -> None:
    """Refuses a form, a regression or an orientation that there is not."""
    check.choice(form, "form", transformation.FORMS)
    check.choice(regression, "regression", REGRESSIONS)
    check.choice(orientation, "orientation", REPRESENTATIONS)


def learn_motion(
    motions: Sequence[Motion],
    weights: int | None,
    *,
    form: str,
    regression: str,
    orientation: str,
) -> tuple[MeanMotion, Parts]:
    """The mean of motions of one mode, and the parts of a discrete primitive that follows it."""
    mean = mean_motion(motions, common_phases(motions))
    coordinates, values = None, mean.positions
    groups: tuple[slice, ...] = (slice(None),)
    if mean.orientations is not None:
        if form == "ijspeert" and orientation == "anchored":
            raise InvalidInput(
                'orientation: "anchored" begins and ends at 0, which scales no force of the form '
                '"ijspeert"; use "lifted", or another form'
            )
        coordinates, rotated = learn(mean.phases, mean.orientations, orientation)
        values, groups = np.hstack([values, rotated]), (_POSITION, _ORIENTATION)
    settings: Any = {"form": form, "regression": regression}
    if weights is None:
        system = fit_with_enough(mean.phases, values, groups, **settings)
    else:
        system = fit(mean.phases, values, groups, weights=weights, **settings)
    if coordinates is not None and mean.orientations is not None:
        channels = PoseChannels(system, mean.size, coordinates)
        if channels.refuses_spins:
            angle = channels.replayed_angle(mean.phases, mean.orientations)
            coordinates = replace(coordinates, angle=angle)
    return mean, _parts(mean, system, coordinates)


def learn_rhythm(
    demonstrations: Demonstrations[Motion], weights: int, period: float | None
) -> tuple[MeanMotion, Parts]:
    """The mean period of demonstrations, and the parts of a rhythmic primitive that follows it."""
    mean = mean_cycle(demonstrations, period)
    coordinates, values = None, mean.positions
    if mean.orientations is not None:
        coordinates, rotated = learn_closed(mean.phases, mean.orientations)
        values = np.hstack([values, rotated])
    system = fit_rhythm(mean.phases, values, weights=weights)
    if coordinates is not None:
        begun = system.ends.start[None, _ORIENTATION].copy()
        first = coordinates.orientations(np.zeros(1), begun)[0]
        coordinates = replace(coordinates, start=first, goal=first)
    return mean, _parts(mean, system, coordinates)


def _parts(
    mean: MeanMotion, system: TransformationSystem, coordinates: OrientationCoordinates | None
) -> Parts:
    return Parts(
        system=system,
        events=mean.events,
        joint_names=mean.joint_names,
        orientation=coordinates,
        posture=mean.posture,
    )
