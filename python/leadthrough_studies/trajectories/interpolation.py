"""Statements of chapter 2 of Grioli's notes (2023) on polynomials, splines and Bezier curves."""

from __future__ import annotations

import numpy as np

from leadthrough import trajectories as tr
from leadthrough.check import Float64Array
from leadthrough_studies.study import Row, Task

_FINE = 2001
_ORDERS = (1, 2, 3, 4)  # continuous derivatives of the splines that are counted
_PIECES = 6
_STATES = 1000  # random pairs between which minimum jerk is compared


def tasks(nodes: tuple[int, ...], seed: int) -> list[Task]:
    """A task for each statement; polynomials for each number of nodes.

    Args:
        nodes: numbers of nodes.
        seed: of the random states.
    """
    return [
        *(Task(polynomials, {"nodes": count}) for count in nodes),
        *(Task(freedom, {"continuity": order}) for order in _ORDERS),
        Task(six_points, {"seed": seed}),
    ]


def polynomials(nodes: int) -> list[Row]:
    """The polynomial of eq. 2.1 by the system of eq. 2.2 and by Lagrange's basis, eq. 2.4.

    The points are those of 1 / (1 + t^2) on [-1, 1], which the notes call Runge's function, on
    Chebyshev nodes; the error on evenly spaced ones shows that this function converges there.
    """
    t = np.linspace(-1.0, 1.0, _FINE)
    at, even = tr.chebyshev_nodes(nodes), np.linspace(-1.0, 1.0, nodes)
    powers = np.vander(at, increasing=True)
    by_powers = np.vander(t, nodes, increasing=True) @ np.linalg.solve(powers, _as_printed(at))
    basis = tr.Lagrange(at, np.eye(nodes)).evaluate(t)
    on_even = tr.Lagrange(even, _as_printed(even)).evaluate(t)[:, 0]
    return [
        {
            "study": "polynomials",
            "nodes": nodes,
            "condition": float(np.linalg.cond(powers)),
            "basis_condition": float(np.abs(basis).sum(axis=1).max()),  # Lebesgue's constant
            "difference": float(np.abs(by_powers - basis @ _as_printed(at)).max()),
            "printed_error": float(np.abs(on_even - _as_printed(t)).max()),
        }
    ]


def freedom(continuity: int) -> list[Row]:
    """Degrees of freedom that the constraints of a spline leave, eq. 2.12: the null space's size.

    The spline has degree continuity + 1 and passes through the ends of its pieces.
    """
    degree = continuity + 1
    rows = []
    for i in range(_PIECES):
        rows += [_on_piece(i, 0.0, 0, degree), _on_piece(i, 1.0, 0, degree)]
    for i in range(1, _PIECES):
        rows += [
            _on_piece(i - 1, 1.0, order, degree) - _on_piece(i, 0.0, order, degree)
            for order in range(1, continuity + 1)
        ]
    left = _PIECES * (degree + 1) - np.linalg.matrix_rank(np.array(rows))
    return [{"study": "freedom", "continuity": continuity, "left": int(left)}]


def six_points(seed: int) -> list[Row]:
    """Section 2.3.1: a Bezier curve of six points beside the optimality condition of eq. 2.19.

    Between any two states the sixth derivative of the optimum is zero (Flash and Hogan 1985), so it
    is the quintic with these states; the coefficients are found here by a linear system.
    """
    rng = np.random.default_rng(seed)
    worst, points = 0.0, set()
    u = np.linspace(0.0, 1.0, 101)
    for _ in range(_STATES):
        start, end = rng.normal(size=(2, 3))
        made = tr.minimum_jerk(tr.State(*start[:, None]), tr.State(*end[:, None]), duration=1.0)
        points.add(len(made.points))
        worst = max(worst, float(np.abs(made.evaluate(u)[:, 0] - _quintic(start, end, u)).max()))
    return [{"study": "six points", "points": max(points), "difference": worst}]


def _as_printed(t: Float64Array) -> Float64Array:
    return np.asarray(1.0 / (1.0 + t**2))


def _on_piece(piece: int, u: float, order: int, degree: int) -> Float64Array:
    """Row of coefficients: a derivative of one of the pieces, each on [0, 1], in monomials."""
    row = np.zeros((_PIECES, degree + 1))
    for power in range(order, degree + 1):
        factor = np.prod(np.arange(power - order + 1, power + 1)) if order else 1.0
        row[piece, power] = factor * u ** (power - order)
    return row.ravel()


def _quintic(start: Float64Array, end: Float64Array, u: Float64Array) -> Float64Array:
    """The quintic on [0, 1] with these positions, velocities and accelerations."""
    system = np.array(
        [
            [np.polyval(np.polyder(np.eye(6)[5 - power], order), at) for power in range(6)]
            for at in (0.0, 1.0)
            for order in range(3)
        ]
    )
    coefficients = np.linalg.solve(system, np.concatenate([start, end]))
    return np.asarray(np.polyval(coefficients[::-1], u))
