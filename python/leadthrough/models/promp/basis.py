"""Basis functions over the phase of a motion, Gaussian, B-spline or rhythmic; motions of weights.

The functions of a basis sum to one at every phase. Prior covariances of the weights describe how
motions vary: by offsets at start and goal that fade along straight lines, and smoothly in between.

Source: Paraschos et al. 2018, "Using probabilistic movement primitives in robotics", section 2.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, Generic, Literal, TypeAlias, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.models.coordinates import Coordinates, rotated_by
from leadthrough.models.promp.gaussian import product
from leadthrough.models.queries import asked_times, checked_threads, mapped
from leadthrough.motion import MotionT_co, PoseTrajectory, Trajectory, computed_joints, moved_events

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

BasisKind: TypeAlias = Literal["bspline", "gaussian", "rhythmic"]
KINDS = get_args(BasisKind)

_DEGREE = 3
# Fewer functions cannot bend, and a period needs three points.
MIN_FUNCTIONS = 4
_LENGTH = 0.25  # correlation length of the deviations in between, in phase
# Variances relative to those of the ends: of the deviations in between, and of each weight on its
# own, so that nothing is ruled out.
_INNER = 0.3
_ROUGH = 1e-3
# No phase is taken to vary less than this fraction of the one that varies the most.
_MIN_PROFILE = 0.1
# Nor is the kernel in between, which vanishes at the ends, taken to be smaller than this there.
_MIN_KERNEL = 0.1
# Fraction of the least spread that is added everywhere, so that nothing is ruled out.
_EVERYWHERE = 0.1


@dataclass(frozen=True)
class Basis(ShortRepr):
    """Basis functions of one kind over the phase of a motion."""

    kind: BasisKind  # "gaussian", "bspline" or "rhythmic" (von Mises functions, of period 1)
    count: int  # number of functions, k
    width: float = 1.0
    margin: float = 1.0

    @property
    def is_rhythmic(self) -> bool:
        """Whether phases 0 and 1 are the same."""
        return self.kind == "rhythmic"

    def __call__(self, phases: Float64Array, order: int = 0) -> Float64Array:
        """Values of the functions, or their derivatives with respect to the phase."""
        if self.kind == "bspline":
            return np.asarray(self._spline(phases, order))
        functions = phases, self.centres, self.sharpness, self.is_rhythmic
        return core.normalised_basis(*functions, order)

    def curves(
        self,
        phases: Float64Array,
        weights: Float64Array,
        paces: Float64Array,
        *,
        most: int,
        threads: int,
    ) -> tuple[list[Float64Array], bool]:
        """Curves of many weights and their derivatives, and whether all are certainly finite."""
        if self.kind == "bspline":
            rows = [self._spline(phases, order) * pace for order, pace in enumerate(paces)]
            return core.curves_over(np.concatenate(rows), len(paces), weights, most, threads)
        functions = phases, self.centres, self.sharpness, self.is_rhythmic
        return core.curves_over_basis(*functions, paces, weights, most, threads)

    @cached_property
    def centres(self) -> Float64Array:
        """Centres (k,) of the functions."""
        if self.is_rhythmic:
            return np.asarray(np.arange(self.count) / self.count)
        if self.kind == "gaussian":
            return np.asarray((np.arange(self.count) - self.margin) / self._spacings)
        knots = self._spline.t
        means = [float(knots[i + 1 : i + 1 + _DEGREE].mean()) for i in range(self.count)]
        return np.asarray(means)

    @cached_property
    def roughness(self) -> Float64Array:
        """Matrix R (k, k) such that w @ R @ w sums the squared second differences of weights w."""
        if self.is_rhythmic:
            steps = np.roll(np.eye(self.count), 1, axis=1) - np.eye(self.count)
            differences = steps @ steps
        else:
            differences = np.diff(np.eye(self.count), 2, axis=0)
        return np.asarray(differences.T @ differences)

    @cached_property
    def _spline(self) -> BSpline:
        from scipy.interpolate import BSpline

        inner = np.linspace(0.0, 1.0, self.count - _DEGREE + 1)
        knots = np.concatenate([np.zeros(_DEGREE), inner, np.ones(_DEGREE)])
        return BSpline(knots, np.eye(self.count), _DEGREE)

    @cached_property
    def sharpness(self) -> float:
        """One over the variance of a Gaussian function, or a von Mises one's concentration."""
        if self.is_rhythmic:
            return (self.count / (2.0 * np.pi * self.width)) ** 2
        return (self._spacings / self.width) ** 2

    @property
    def _spacings(self) -> float:
        """How many spacings of Gaussian centres the motion is long."""
        return self.count - 1.0 - 2.0 * self.margin


def smooth_prior(basis: Basis, spread: Float64Array) -> Float64Array:
    """Covariance (d k, d k) of the weights of columns that vary alike at all phases."""
    one = _INNER * _in_between(basis) + _ROUGH * np.eye(basis.count)
    if not basis.is_rhythmic:
        ends = lines(basis)
        one += ends @ ends.T
    return np.asarray(np.kron(np.diag(spread**2), one))


def inner_prior(basis: Basis) -> Float64Array:
    """Covariance (k, k) of the weights of one column's deviations that vanish at both ends."""
    free = np.eye(basis.count)
    if not basis.is_rhythmic:
        rows = basis(np.array([0.0, 1.0]))
        free -= np.linalg.pinv(rows) @ rows
    return np.asarray(_in_between(basis) + _ROUGH * free)


def shaped_prior(basis: Basis, curves: Float64Array) -> Float64Array:
    """Covariance (d k, d k) with the spread that demonstrations have at each phase."""
    flat = curves.reshape(-1, basis.count)
    at_phases = product(flat, basis(prior_phases(basis)).T).reshape(*curves.shape[:2], -1)
    variances = (at_phases**2).sum(axis=0) / (len(curves) - 1)
    profile = _left_between(basis, variances)
    profile = np.maximum(profile, _MIN_PROFILE * profile.max(axis=1, keepdims=True))
    return _profiled(basis, variances[:, [0, -1]], profile)


def raised(covariance: Float64Array, basis: Basis, least: float) -> Float64Array:
    """A covariance (d k, d k), raised where some phase of the motion varies too little."""
    rows, size = basis(prior_phases(basis)), len(covariance) // basis.count
    blocks = np.einsum("iaib->iab", covariance.reshape(size, basis.count, size, basis.count))
    spread = [(product(rows, block) * rows).sum(axis=1) for block in blocks]
    missing = np.maximum(least**2 - np.array(spread), 0.0)
    added = _profiled(basis, missing[:, [0, -1]], _left_between(basis, missing))
    everywhere = smooth_prior(basis, np.full(size, _EVERYWHERE * least))
    return np.asarray(covariance + added + everywhere)


def _left_between(basis: Basis, variances: Float64Array) -> Float64Array:
    """Deviations in between beside those of the ends, for variances (d, n) in all."""
    fit, inner = _fit_and_kernel(basis)
    reached = product(basis(prior_phases(basis)), fit)
    own = (product(reached, inner) * reached).sum(axis=1)
    left = variances
    if not basis.is_rhythmic:
        u = prior_phases(basis)
        left = variances - variances[:, [0, -1]] @ np.stack([1.0 - u, u]) ** 2
    return np.asarray(np.sqrt(np.maximum(left, 0.0) / np.maximum(own, _MIN_KERNEL)))


def _profiled(basis: Basis, ends: Float64Array, profile: Float64Array) -> Float64Array:
    """Covariance (d k, d k) from variances (d, 2) of the ends and deviations (d, n) in between."""
    fit, inner = _fit_and_kernel(basis)
    result = np.zeros((len(ends), basis.count, len(ends), basis.count))
    ramps = np.zeros((basis.count, 2)) if basis.is_rhythmic else lines(basis)
    for column, (of_ends, between) in enumerate(zip(ends, profile, strict=True)):
        reached = fit * between
        inside = product(product(reached, inner), reached.T)
        result[column, :, column] = (ramps * of_ends) @ ramps.T + inside
    return result.reshape(len(ends) * basis.count, -1)


@lru_cache(maxsize=16)
def _in_between(basis: Basis) -> Float64Array:
    """Covariance (k, k) of the weights of a column between its ends, which are fixed."""
    fit, inner = _fit_and_kernel(basis)
    return np.asarray(product(product(fit, inner), fit.T))


@lru_cache(maxsize=16)
def _fit_and_kernel(basis: Basis) -> tuple[Float64Array, Float64Array]:
    """The map (k, n) from values at `_phases` to weights, and the kernel (n, n) in between."""
    u, fit = prior_phases(basis), weights_of_values(basis)
    gaps = u[:, None] - u
    if basis.is_rhythmic:
        gaps = np.sin(np.pi * gaps) / np.pi
    gaps *= gaps / (-2.0 * _LENGTH**2)
    kernel = np.exp(gaps, out=gaps)
    if not basis.is_rhythmic:
        known = kernel[:, [0, -1]]  # a deviation in between is zero at both ends
        kernel -= product(known, np.linalg.solve(known[[0, -1]], known.T))
        # Neither may its curve deviate there, although the functions cannot follow it everywhere.
        rows = basis(u[[0, -1]])
        fit = fit - product(np.linalg.pinv(rows), product(rows, fit))
    return fit, kernel


def weights_of_values(basis: Basis) -> Float64Array:
    """The map (k, n) from values at `_phases` to the weights of the nearest curve."""
    return np.asarray(np.linalg.pinv(basis(prior_phases(basis)), rcond=1e-6))


def multiplied(basis: Basis, factors: Float64Array) -> Float64Array:
    """The matrix (k, k) of weights that multiplies a curve with factors (n,) at `prior_phases`."""
    values = factors[:, None] * basis(prior_phases(basis))
    return _exact_at_ends(basis, weights_of_values(basis) @ values, values[[0, -1]])


@lru_cache(maxsize=16)
def lines(basis: Basis) -> Float64Array:
    """Weights (k, 2) of the lines from 1 to 0 and from 0 to 1, exact at both ends."""
    return fades(basis, prior_phases(basis))


def fades(basis: Basis, progress: Float64Array) -> Float64Array:
    """Weights (k, 2) of the rest of a progress (n,) at `prior_phases` and of it, exact at ends."""
    values = np.column_stack([1.0 - progress, progress])
    return _exact_at_ends(basis, product(weights_of_values(basis), values), np.eye(2))


def _exact_at_ends(basis: Basis, fitted: Float64Array, values: Float64Array) -> Float64Array:
    """The nearest weights (k, m) to fitted ones of curves with values (2, m) at both ends."""
    if basis.is_rhythmic:  # both are one phase, and may differ
        return fitted
    rows = basis(np.array([0.0, 1.0]))
    return np.asarray(fitted + np.linalg.pinv(rows) @ (values - rows @ fitted))


def prior_phases(basis: Basis) -> Float64Array:
    """Phases (n,) at which priors are stated."""
    return np.linspace(0.0, 1.0, 8 * basis.count + 1)


# Motions of many weights lie together in blocks, as new memory takes longer to get than its numbers
# to compute. Bytes of a block, which stays in memory as long as one of its motions does. The usual
# C library would ask anew for larger ones each time.
_BLOCK = 32 * 2**20
_NAMES = ("positions", "velocities", "accelerations")
# A time may lie this fraction of the duration outside the motion, by rounding: evenly spaced times
# up to the duration may end an ulp beyond it.
_ROUNDING = 1e-9


class Drawing(Generic[MotionT_co]):
    """Motions of many weights at the same times; they share basis functions, events and joints."""

    def __init__(
        self,
        coordinates: Coordinates[MotionT_co],
        basis: Basis,
        times: Float64Array,
        duration: float,
    ) -> None:
        self._coordinates, self._basis, self._times = coordinates, basis, times
        self._phases = phases = times / duration
        orders = 3 if coordinates.kind == "joints" else 1
        self._paces = duration ** -np.arange(orders, dtype=np.float64)
        self._together = max(1, _BLOCK // (8 * orders * len(times) * coordinates.width))
        self._events = moved_events(coordinates.events, phases, times)
        self._joints = (
            None if coordinates.posture is None else coordinates.posture.along(times, phases)
        )
        self._reference = (
            None if coordinates.reference is None else coordinates.reference_at(phases)
        )

    def motions(self, weights: Float64Array, threads: int) -> list[MotionT_co]:
        checked_threads(threads)
        made: list[Any]  # of the type that the coordinates was made for
        if self._coordinates.kind == "joints":
            same: Any = {"joint_names": self._coordinates.joint_names, "events": self._events}
            made = [
                computed_joints(self._times, *values, **same)
                for values in self._curves(weights, threads)
            ]
        elif self._reference is None:
            made = [self._points(values) for values in self._curves(weights, threads)]
        else:
            made = []
            for first in range(0, len(weights), self._together):
                some = weights[first : first + self._together]
                made += mapped(self._poses, self._curves(some, threads), threads)
        return cast(list[MotionT_co], made)

    def _curves(self, weights: Float64Array, threads: int) -> Iterator[Float64Array]:
        """The columns (1, n, d) of each motion, of joints with their derivatives (3, n, d)."""
        blocks, certain = self._basis.curves(
            self._phases, weights, self._paces, most=self._together, threads=threads
        )
        for block in blocks:
            if not certain and not core.all_finite(block):
                _refuse_infinite(block)
            yield from block

    def _points(self, values: Float64Array) -> Trajectory:
        return check.computed(
            Trajectory,
            times=self._times,
            positions=values[0],
            events=self._events,
            joints=self._joints,
        )

    def _poses(self, values: Float64Array) -> PoseTrajectory:
        assert self._reference is not None
        return check.computed(
            PoseTrajectory,
            times=self._times,
            positions=values[0, :, :3].copy(),
            orientations=rotations.align_signs(rotated_by(self._reference, values[0, :, 3:])),
            events=self._events,
            joints=self._joints,
        )


def _refuse_infinite(block: Float64Array) -> None:
    for values in block:
        for rows, name in zip(values, _NAMES, strict=False):
            check.array(rows, name, shape=rows.shape)


def phases_at(
    times: ArrayLike, name: str, *, duration: float, repeats: bool, at_least: int = 0
) -> Float64Array:
    """Phases (n,) at times of a motion."""
    phases = asked_times(times, name, at_least=at_least) / duration
    if repeats or len(phases) == 0:
        return phases
    if len(phases) == 1:  # the quick way: via points come one at a time
        first = last = float(phases[0])
    else:
        first, last = float(phases.min()), float(phases.max())
    if first < -_ROUNDING or last > 1.0 + _ROUNDING:
        outside = (first if first < -_ROUNDING else last) * duration
        raise check.refused(
            name, f"times in [0, {duration:.6g}] s, the motion's duration", f"{outside:.6g} s"
        )
    return phases if first >= 0.0 and last <= 1.0 else np.clip(phases, 0.0, 1.0)
