"""One polynomial through all points: Lagrange's and, with velocities, Hermite's.

Both are kept by their values at nodes and evaluated by the barycentric formula, which is stable
where the Vandermonde matrix is not; derivatives are values of a polynomial on the same nodes.

Source: Berrut and Trefethen 2004, eqs. 4.2, 9.4, 9.5.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.trajectories import curve
from leadthrough.trajectories.curve import PointCurve

# Products of more differences of nodes would overflow.
_MAX_NODES = 500


@dataclass(frozen=True, eq=False, init=False)
class Lagrange(PointCurve):
    """The polynomial of least degree through points.

    On evenly spaced nodes it oscillates the more, the higher its degree (Runge 1901); on those of
    `chebyshev_nodes` it does not.

    Attributes:
        nodes: strictly increasing times (n,), 2 to 500.
        points: (n, d); (n,) are taken as one-dimensional.
    """

    nodes: Float64Array
    points: Float64Array
    _weights: Float64Array = field(init=False, repr=False)

    def __init__(self, nodes: ArrayLike, points: ArrayLike) -> None:
        times = curve.knot_times(nodes, "nodes")
        if len(times) > _MAX_NODES:
            raise InvalidInput(f"nodes: expected at most {_MAX_NODES}, got {len(times)}")
        table = curve.points(points, "points", count=len(times))
        vars(self).update(nodes=times, points=table, _weights=_weights(times))

    @property
    def domain(self) -> tuple[float, float]:
        """First and last node."""
        return float(self.nodes[0]), float(self.nodes[-1])

    @property
    def knots(self) -> Float64Array:
        """The ends of the domain."""
        return self.nodes[[0, -1]]

    def basis(self, t: ArrayLike) -> Float64Array:
        """Lagrange's polynomials (n, nodes): 1 at their own node, 0 at the others.

        Args:
            t: times of the domain (n,).
        """
        times = curve.times_inside(np.atleast_1d(t), self.domain)
        return _barycentric(self.nodes, self._weights, np.eye(len(self.nodes)), times)

    def _values(self, times: Float64Array, order: int) -> Float64Array:
        values = self.points
        for _ in range(min(order, len(self.nodes))):
            values = self._slopes(values)
        return _barycentric(self.nodes, self._weights, values, times)

    def _stretched(self, factor: float) -> Self:
        return replace(self, nodes=self.nodes * factor)

    def _slopes(self, values: Float64Array) -> Float64Array:
        """Derivatives at the nodes of the polynomial with given values there."""
        gaps = self.nodes[:, None] - self.nodes
        np.fill_diagonal(gaps, 1.0)
        matrix = self._weights / self._weights[:, None] / gaps
        np.fill_diagonal(matrix, 0.0)
        # Rows of differences: exact for constants whatever the rounding of the matrix.
        return np.asarray(matrix @ values - matrix.sum(axis=1)[:, None] * values)


def chebyshev_nodes(count: int, domain: tuple[float, float] = (-1.0, 1.0)) -> Float64Array:
    """Rising Chebyshev nodes (count,) of the second kind on a domain, its ends included.

    Interpolation on them converges for every function that is Lipschitz continuous.

    Args:
        count: at least 2.
        domain: first and last node.
    """
    number = check.integer(count, "count", at_least=2)
    first, last = curve.knot_times(domain, "domain")[[0, -1]]
    unit = np.sin(np.pi * (2.0 * np.arange(number) - (number - 1)) / (2.0 * (number - 1)))
    nodes = 0.5 * (first + last) + 0.5 * (last - first) * unit
    nodes[[0, -1]] = first, last
    return np.asarray(nodes)


def osculating(times: ArrayLike, points: ArrayLike, velocities: ArrayLike) -> Lagrange:
    """The polynomial of degree 2n - 1 through points (n, d) at rising times, with their velocities.

    Source: Grioli 2023, eqs. 2.6, 2.7.
    """
    nodes = curve.knot_times(times, "times")
    x = curve.points(points, "points", count=len(nodes))
    v = curve.points(velocities, "velocities", count=len(nodes))
    if x.shape != v.shape:
        raise InvalidInput(f"velocities: expected shape {x.shape}, got {v.shape}")
    through = Lagrange(nodes, np.eye(len(nodes)))
    at = chebyshev_nodes(2 * len(nodes), through.domain)
    squares = through.evaluate(at) ** 2
    own_slopes = np.diag(through.evaluate(nodes, 1))
    offsets = at[:, None] - nodes
    values = (1.0 - 2.0 * own_slopes * offsets) * squares @ x + offsets * squares @ v
    return Lagrange(at, values)


def _weights(nodes: Float64Array) -> Float64Array:
    # Scaled by the capacity of the interval, products neither underflow nor overflow.
    gaps = (nodes[:, None] - nodes) * (4.0 / (nodes[-1] - nodes[0]))
    np.fill_diagonal(gaps, 1.0)
    logarithms = -np.log(np.abs(gaps)).sum(axis=1)
    return np.asarray(np.prod(np.sign(gaps), axis=1) * np.exp(logarithms - logarithms.max()))


def _barycentric(
    nodes: Float64Array, weights: Float64Array, values: Float64Array, t: Float64Array
) -> Float64Array:
    gaps = np.atleast_1d(t)[:, None] - nodes
    hit, node = np.nonzero(gaps == 0.0)
    gaps[hit] = 1.0
    factors = weights / gaps
    factors[hit] = 1.0  # at a node the value is its own
    result = factors @ values / factors.sum(axis=1)[:, None]
    result[hit] = values[node]
    return np.asarray(result if np.ndim(t) else result[0])
