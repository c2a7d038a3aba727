"""Smooth sections of a path between the places where the motion rests."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.trajectories import Spline

Rows = NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Section:
    """A path with two continuous derivatives, from rest to rest.

    Attributes:
        spline: the path.
        rows: way-points, samples or knots (m,) of the whole path, by their index.
        parameters: where they lie on the spline, (m,).
        hold: s, how long the motion rests at the end.
    """

    spline: Spline
    rows: Rows
    parameters: Float64Array
    hold: float = 0.0


@dataclass(frozen=True, eq=False)
class Sections:
    """A whole path in sections; none where nothing moves.

    Attributes:
        initial_hold: s, how long the motion rests at its start.
        parts: the sections, in their order.
    """

    initial_hold: float
    parts: list[Section]


def between(
    stops: Collection[int],
    section: Callable[[int, int], Section | None],
    *,
    holds: Mapping[int, float],
) -> Sections:
    """The sections from each stop to the next.

    Args:
        stops: row indices, the first and the last row of the path among them.
        section: the section between two rows, or None where nothing moves between them; the hold
            after such a stretch goes to the section before it.
        holds: seconds of rest by row.
    """
    initial_hold, parts = holds.get(0, 0.0), list[Section]()
    for first, last in pairwise(sorted(stops)):
        part, hold = section(first, last), holds.get(last, 0.0)
        if part is not None:
            parts.append(replace(part, hold=hold))
        elif parts:
            parts[-1] = replace(parts[-1], hold=parts[-1].hold + hold)
        else:
            initial_hold += hold
    return Sections(initial_hold, parts)
