"""Smooth sections of a path between the places where the motion rests."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.trajectories import Spline

Rows = NDArray[np.intp]


_SAME_PLACE = 1e-12  # rad or m


@dataclass(frozen=True, eq=False)
class Section:
    """A path with two continuous derivatives, from rest to rest."""

    spline: Spline  # the path
    rows: Rows  # way-points, samples or knots (m,) of the whole path, by their index
    parameters: Float64Array  # where they lie on the spline, (m,)
    hold: float = 0.0  # s, how long the motion rests at the end

    def cut_at(self, parameters: Float64Array) -> list[Section]:
        """The section in parts, without its hold; all rows stay, some beyond the part's ends."""
        parts, begin = list[Section](), self.spline.coefficients[0, 0]
        for part in _parts(self.spline, parameters):
            # From 0, as a short part's own parameters would be lost in the digits of the whole,
            # and from where the part before ends to the last digit.
            table = part.coefficients.copy()
            table[0, 0] = begin
            spline = Spline(part.knots - part.knots[0], table)
            own = self.parameters - part.knots[0]
            parts.append(replace(self, spline=spline, parameters=own, hold=0.0))
            begin = spline.evaluate(spline.domain[1])
        return parts


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight lines, at whose ends the motion rests."""

    ends: Float64Array  # of the lines, (m + 1, joints)
    at: Float64Array  # lengths (m + 1,) of the path at the ends
    rows: Rows  # way-points (n,) on the lines, by their index in the whole path
    lengths: Float64Array  # of the path at these way-points, (n,)
    holds: Float64Array  # s, how long the motion rests after each line, (m,)


@dataclass(frozen=True, eq=False)
class Sections:
    """A whole path in sections; none where nothing moves."""

    initial_hold: float  # s, how long the motion rests at its start
    parts: list[Section | Lines]  # the sections, in their order, and lines


def between(
    stops: Collection[int],
    section: Callable[[int, int], Section | None],
    *,
    holds: Mapping[int, float],
) -> Sections:
    """The sections from each stop to the next."""
    initial_hold, parts = holds.get(0, 0.0), list[Section]()
    for first, last in pairwise(sorted(stops)):
        part, hold = section(first, last), holds.get(last, 0.0)
        if part is not None:
            parts.append(replace(part, hold=hold))
        elif parts:
            parts[-1] = replace(parts[-1], hold=parts[-1].hold + hold)
        else:
            initial_hold += hold
    return Sections(initial_hold, list[Section | Lines](parts))


def _parts(spline: Spline, parameters: Float64Array) -> list[Spline]:
    """The spline between its start, each of the parameters and its end; each part moves."""
    start, end = spline.domain
    inner = parameters[(parameters > start) & (parameters < end)]
    q = spline.evaluate(np.array([start, *inner, end]))
    moved = np.abs(np.diff(q, axis=0)).max(axis=1) > _SAME_PLACE
    inner = inner[moved[:-1] & moved[1:]]
    return [_between(spline, *ends) for ends in pairwise([start, *inner.tolist(), end])]


def _between(spline: Spline, first: float, last: float) -> Spline:
    """The spline between two of its parameters."""
    begin = int(np.searchsorted(spline.knots, first, side="right")) - 1
    end = int(np.searchsorted(spline.knots, last, side="left"))
    knots, pieces = spline.knots[begin : end + 1].copy(), spline.coefficients[begin:end].copy()
    pieces[0] = _moved(pieces[0], first - knots[0])
    knots[[0, -1]] = first, last
    return Spline(knots, pieces)


def _moved(piece: Float64Array, by: float) -> Float64Array:
    """Coefficients (terms, d) of a polynomial that begins later by so much."""
    powers = range(len(piece))
    table = [[math.comb(k, i) * by ** (k - i) if k >= i else 0.0 for k in powers] for i in powers]
    return np.array(table) @ piece
