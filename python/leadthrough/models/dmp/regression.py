"""Weights of a movement primitive from a demonstration.

- "replay" (the default) minimises the squared distance between the replayed motion and the samples:
  the springs are linear in the weights and in the slopes at both ends, so the responses to each of
  them make the regressors. Nothing is differentiated, which is what noise asks for.
- "ridge" fits the force that the samples' finite differences ask for, all weights together.
- "lwr" fits each weight for itself by its kernel: w_i = s^T Psi_i f / s^T Psi_i s.
  Source: Schaal and Atkeson 1998; Ijspeert et al. 2013, eq. 2.14.

The last two are the literature's; they inherit the noise of second differences.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.integrate import trapezoid

from leadthrough import _core
from leadthrough.check import Float64Array
from leadthrough.errors import FitError
from leadthrough.models.dmp.kernels import Kernels
from leadthrough.models.dmp.springs import (
    RATE,
    RHYTHMIC,
    Ends,
    Springs,
    course,
    kernels_of,
    minimum_jerk,
    tabulated,
)

REGRESSIONS = ("replay", "ridge", "lwr")

# Ridge penalty, as a share of the regressors' mean square: enough where samples are fewer than
# weights, and far below what changes a fit.
_RIDGE = 1e-8
# A motion as short as this beside its range cannot scale a force.
_SHORTEST_SHARE = 1e-3
_SWUNG_IN = 4.0  # periods


@dataclass(frozen=True, eq=False)
class _Shown:
    """Values (n, channels) at phases (n,), and the ends of a fit at rest through them."""

    form: str
    phases: Float64Array
    values: Float64Array
    functions: Kernels
    ends: Ends

    @property
    def scale(self) -> Float64Array:
        """What multiplies the force, (channels,)."""
        if self.form != "ijspeert":
            return np.ones(len(self.ends.goal))
        return self.ends.goal - self.ends.start


def fit(
    phases: Float64Array, values: Float64Array, *, weights: int, form: str, regression: str
) -> Springs:
    """Springs that move through values (n, channels), n >= 2, at phases (n,) from 0 to 1.

    Raises FitError where values overflow or, with the form "ijspeert", a channel ends where it
    began.
    """
    rest = np.zeros(values.shape[1])
    ends = Ends(values[0].copy(), values[-1].copy(), rest, rest)
    shown = _Shown(form, phases, values, kernels_of(form, weights), ends)
    _check_scale(shown)
    with np.errstate(all="ignore"):  # what is not finite is refused below
        found, slopes = (
            _by_replay(shown) if regression == "replay" else _by_force(shown, regression)
        )
    if not (np.isfinite(found).all() and np.isfinite(slopes).all()):
        raise FitError("demonstrations: numbers too large to fit")
    return Springs(form, found, replace(ends, start_slope=slopes[0], goal_slope=slopes[1]))


def fit_rhythm(phases: Float64Array, values: Float64Array, *, weights: int) -> Springs:
    """Springs that go round through values (n, channels) at phases (n,) of one period, by replay.

    Their centre is the mean over the period, and their start lies on the round. Raises FitError
    where values overflow.
    """
    with np.errstate(all="ignore"):  # what is not finite is refused below
        centre = trapezoid(values, phases, axis=0)
        functions = kernels_of(RHYTHMIC, weights)
        # The springs have swung in after this many periods, to 16 digits.
        response, _ = _responses(functions, np.concatenate([[0.0], _SWUNG_IN + phases]))
        design = response[1:]
        gram = design.T @ design
        gram[np.diag_indices(len(gram))] += _RIDGE * np.trace(gram) / len(gram)
        found = np.asarray(np.linalg.solve(gram, design.T @ (values - centre)), np.float64)
    if not np.isfinite(found).all():
        raise FitError("demonstrations: numbers too large to fit")
    rest = np.zeros(values.shape[1])
    springs = Springs(RHYTHMIC, np.ascontiguousarray(found), Ends(centre, centre, rest, rest))
    swung_in = np.array([0.0, _SWUNG_IN])
    asked = course(RHYTHMIC, springs.ends)
    y, slopes = _core.dmp_rollout(springs.forces, asked, centre, rest, swung_in)
    return replace(springs, ends=Ends(y[-1].copy(), centre, slopes[-1].copy(), rest))


def _by_replay(shown: _Shown) -> tuple[Float64Array, Float64Array]:
    """Weights, and slopes at both ends."""
    response, last = _responses(shown.functions, shown.phases)
    known, slope_responses = _without_force(shown)
    design: Float64Array = np.hstack([response, slope_responses])
    gram = design.T @ design
    count, channels = response.shape[1], shown.values.shape[1]
    gram[np.diag_indices(len(gram))] += _RIDGE * np.trace(gram[:count, :count]) / count
    wanted = design.T @ ((shown.values - known) / shown.scale)
    constraints = np.zeros((len(gram), 2))
    constraints[:count] = last.T
    solved = np.asarray(np.linalg.solve(gram, np.hstack([wanted, constraints])), np.float64)
    found = solved[:, :channels]
    if shown.form == "blended":
        found = _settled(found, constraints, solved[:, channels:])
    slopes = np.zeros((2, channels))
    slopes[: len(gram) - count] = found[count:] * shown.scale
    return np.ascontiguousarray(found[:count]), slopes


def _by_force(shown: _Shown, regression: str) -> tuple[Float64Array, Float64Array]:
    """Weights, and slopes at both ends."""
    edge: Any = min(2, len(shown.phases) - 1)
    rates = np.asarray(np.gradient(shown.values, shown.phases, axis=0, edge_order=edge))
    bends = np.asarray(np.gradient(rates, shown.phases, axis=0, edge_order=edge))
    ends = replace(shown.ends, start_slope=rates[0], goal_slope=rates[-1])
    r, r_rates, r_bends = _reference(shown.form, ends, shown.phases)
    force = bends - r_bends + 2.0 * RATE * (rates - r_rates) + RATE**2 * (shown.values - r)
    fade = _at(shown.functions.fade[:, None], shown.functions, shown.phases)
    force = (force - fade * course(shown.form, ends).drive) / shown.scale
    solve = _ridge if regression == "ridge" else _locally_weighted
    found = solve(shown.functions, shown.phases, force)
    if shown.form == "blended":
        _, last = _responses(shown.functions, np.array([0.0, 1.0]))
        found = _settled(found, last.T, last.T)
    return np.ascontiguousarray(found), rates[[0, -1]]


def _ridge(functions: Kernels, phases: Float64Array, force: Float64Array) -> Float64Array:
    design = _at(functions.functions, functions, phases)
    gram = design.T @ design
    gram[np.diag_indices(len(gram))] += _RIDGE * np.trace(gram) / len(gram)
    return np.asarray(np.linalg.solve(gram, design.T @ force))


def _locally_weighted(
    functions: Kernels, phases: Float64Array, force: Float64Array
) -> Float64Array:
    kernels = _at(functions.kernels, functions, phases)
    regressor = _at(functions.regressor, functions, phases)
    above = (kernels * regressor).T @ force
    below = np.einsum("nw,nw->w", kernels, regressor**2)[:, None]
    return np.asarray(np.divide(above, below, out=np.zeros_like(above), where=below > 0.0))


def _at(table: Float64Array, functions: Kernels, phases: Float64Array) -> Float64Array:
    """Rows of a table over the nodes, linear between them."""
    place = phases * (len(functions.phases) - 1)
    left = np.clip(place.astype(np.intp), 0, len(functions.phases) - 2)
    share = (place - left)[:, None]
    return np.asarray((1.0 - share) * table[left] + share * table[left + 1])


def _responses(functions: Kernels, phases: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Errors (n, weights) that each function alone makes, and the last value and slope of them."""
    rest = np.zeros(functions.kernels.shape[1])
    still = course("hoffmann", Ends(rest, rest, rest, rest))
    values, slopes = _core.dmp_rollout(tabulated(functions), still, rest, rest, phases)
    return values, np.stack([values[-1], slopes[-1]])


def _without_force(shown: _Shown) -> tuple[Float64Array, Float64Array]:
    """Values (n, channels) from rest to rest without a learned force; responses to the slopes."""
    phases, ends = shown.phases, shown.ends
    if shown.form == "blended":
        nothing, one, two = np.zeros(2), np.array([1.0, 0.0]), np.array([0.0, 1.0])
        powers = phases[:, None] ** np.arange(6.0)
        slopes = minimum_jerk(Ends(nothing, nothing, one, two))
        return powers @ minimum_jerk(ends), powers @ slopes
    no_weights = np.zeros((shown.functions.kernels.shape[1], len(ends.start)))
    forces = tabulated(shown.functions, no_weights)
    known, _ = _core.dmp_rollout(
        forces, course(shown.form, ends), ends.start, ends.start_slope, phases
    )
    return known, (phases * np.exp(-RATE * phases))[:, None]


def _reference(
    form: str, ends: Ends, phases: Float64Array
) -> tuple[Float64Array, Float64Array, Float64Array]:
    if form != "blended":
        nothing = np.zeros((1, len(ends.goal)))
        return ends.goal[None], nothing, nothing
    polynomial: Any = np.polynomial.polynomial
    coefficients = minimum_jerk(ends)
    r, rates, bends = (
        polynomial.polyval(phases, polynomial.polyder(coefficients, order)).T for order in range(3)
    )
    return np.asarray(r), np.asarray(rates), np.asarray(bends)


def _settled(
    found: Float64Array, constraints: Float64Array, correction: Float64Array
) -> Float64Array:
    """The solution moved along the correction (n, 2) until constraints (n, 2) on it vanish.

    A blended motion ends at its goal: the error and its slope are 0 there.
    """
    excess = constraints.T @ found
    return np.asarray(found - correction @ np.linalg.solve(constraints.T @ correction, excess))


def _check_scale(shown: _Shown) -> None:
    reach = np.ptp(shown.values, axis=0).max()
    short = np.abs(shown.scale) < _SHORTEST_SHARE * reach
    if shown.form == "ijspeert" and short.any():
        raise FitError(
            f"demonstrations: channel {int(np.argmax(short))} ends where it began, so the goal "
            'cannot scale its force; use the form "blended" or "hoffmann"'
        )
