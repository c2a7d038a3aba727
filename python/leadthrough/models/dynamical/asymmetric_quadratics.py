"""The weighted sum of asymmetric quadratic functions (WSAQF), an energy of CLF-DM.

V(x) = x^T P_0 x + sum_l max(0, x^T P_l (x - c_l))^2, all P_l + P_l^T positive definite. With
q_l = x^T P_l (x - c_l) > 0 where a term counts, x . grad V = 2 x^T P_0 x + sum_l 2 q_l
(q_l + x^T P_l x) > 0: it grows along every ray.

Source: Khansari-Zadeh and Billard 2014, "Learning control Lyapunov function to ensure stability of
dynamical system-based robot reaching motions", eqs. 5 and 6.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.models.dynamical import lyapunov
from leadthrough.repr import ShortRepr

# The least eigenvalues of P_0 and of the symmetric parts of P_l, and the largest entries of the
# roots of P_0 and P_l, of the skew parts and the centres. Without them, valleys of the energy
# become so narrow that a trajectory follows them in tiny steps only.
_LEAST = (0.05, 0.1)
_STARTS = 12
_LARGEST = (1.0, 0.7, 0.7, 1.5)


@dataclass(frozen=True, eq=False)
class AsymmetricQuadratics(ShortRepr):
    """A weighted sum of asymmetric quadratic functions."""

    symmetric: Float64Array  # P_0, (d, d)
    matrices: Float64Array  # P_l, (l, d, d)
    centres: Float64Array  # c_l, (l, d)

    def value(self, x: Float64Array) -> Float64Array:
        """Energies (n,) at positions (n, d)."""
        active = self._terms(x)[0]
        return np.asarray((x @ self.symmetric * x).sum(axis=1) + (active**2).sum(axis=0))

    def gradient(self, x: Float64Array) -> Float64Array:
        """Their gradients (n, d)."""
        active, along = self._terms(x)
        return np.asarray(2.0 * (x @ self.symmetric + (active[:, :, None] * along).sum(axis=0)))

    def arrays(self) -> Mapping[str, NDArray[Any]]:
        """What it is made of."""
        return {name: getattr(self, name) for name in ("symmetric", "matrices", "centres")}

    def _terms(self, x: Float64Array) -> tuple[Float64Array, Float64Array]:
        """max(0, q_l), (l, n), and the gradients (l, n, d) of q_l."""
        forward = (x[None] - self.centres[:, None]) @ self.matrices.transpose(0, 2, 1)
        active = np.maximum((forward * x).sum(axis=2), 0.0)
        return active, forward + x @ self.matrices


def fitted(x: Float64Array, v: Float64Array, count: int, *, seed: int) -> AsymmetricQuadratics:
    """The sum of asymmetric quadratic functions that falls best along demonstrations."""
    size = x.shape[1]
    moving = np.linalg.norm(v, axis=1) > 0.0
    rng = np.random.default_rng(seed)
    starts = [_start(x, count, rng) for _ in range(_STARTS if count else 1)]
    sizes = [size**2, count * size**2, count * size**2, count * size]
    largest = np.repeat(_LARGEST, sizes)
    found = lyapunov.fitted(
        lambda p, at: _gradient(p, at, count), starts, x[moving], v[moving], largest=largest
    )
    return _built(found, size, count)


def _start(x: Float64Array, count: int, rng: np.random.Generator) -> Float64Array:
    """Parameters of round functions about samples drawn at random."""
    size = x.shape[1]
    centres = x[rng.integers(len(x), size=count)]
    turned = np.eye(size) + 0.1 * rng.standard_normal((count, size, size))
    parts = [np.eye(size), turned, np.zeros((count, size, size)), centres]
    return np.concatenate([part.ravel() for part in parts])


def _split(packed: Float64Array, d: int, count: int) -> tuple[Float64Array, ...]:
    """The roots of P_0 (d, d) and of P_l (l, d, d), their skew parts and the centres (l, d)."""
    sizes = np.cumsum([d * d, count * d * d, count * d * d])
    root, roots, skew, centres = np.split(packed, sizes)
    shape = (count, d, d)
    return root.reshape(d, d), roots.reshape(shape), skew.reshape(shape), centres.reshape(count, d)


def _built(packed: Float64Array, d: int, count: int) -> AsymmetricQuadratics:
    root, roots, skew, centres = _split(packed, d, count)
    matrices = (
        roots @ roots.transpose(0, 2, 1) + skew - skew.transpose(0, 2, 1) + _LEAST[1] * np.eye(d)
    )
    symmetric = root @ root.T + _LEAST[0] * np.eye(d)
    return AsymmetricQuadratics(symmetric, matrices, centres)


def _gradient(
    packed: Float64Array, x: Float64Array, count: int
) -> tuple[Float64Array, lyapunov.Slopes]:
    d = x.shape[1]
    root, roots, _, _ = _split(packed, d, count)
    built = _built(packed, d, count)
    active, along = built._terms(x)

    def back(pull: Float64Array) -> Float64Array:
        """The slopes in the parameters, of slopes (n, d) in the gradient of the energy."""
        plain = 2.0 * pull.T @ x
        counts = active > 0.0
        on_active = np.where(counts, (along * pull).sum(axis=2), 0.0)[:, :, None]
        q = active[:, :, None]
        off = x[None] - built.centres[:, None]
        # q has the slope x (x - c)^T in P, its gradient's product with the pull p has
        # p (x - c)^T + x p^T; in c they are -P^T x and -P^T p.
        at_x = (on_active * x).transpose(0, 2, 1)
        at_pull = (q * pull).transpose(0, 2, 1)
        in_matrix = 2.0 * (at_x @ off + at_pull @ off + (q * x).transpose(0, 2, 1) @ pull)
        moved = (on_active * x + q * pull).sum(axis=1)
        in_centre = -2.0 * (moved[:, None, :] @ built.matrices)[:, 0]
        turned = in_matrix.transpose(0, 2, 1)
        parts = [
            (plain + plain.T) @ root,
            (in_matrix + turned) @ roots,
            in_matrix - turned,
            in_centre,
        ]
        return np.concatenate([part.ravel() for part in parts])

    return built.gradient(x), back
