"""Normal distributions of vectors."""

import numpy as np
import pytest

from leadthrough.models.promp import dense
from leadthrough.models.promp.gaussian import Gaussian, product


def test_product_of_gaussians_is_that_of_their_densities():
    rng = np.random.default_rng(3)
    roots = rng.standard_normal((2, 3, 3))
    a, b = (Gaussian(rng.standard_normal(3), root @ root.T) for root in roots)
    both = product([a, b], [1.0, 2.0])
    precision = np.linalg.inv(a.covariance) + 2.0 * np.linalg.inv(b.covariance)
    np.testing.assert_allclose(np.linalg.inv(both.covariance), precision, rtol=1e-6, atol=1e-6)
    pull = np.linalg.solve(a.covariance, a.mean) + 2.0 * np.linalg.solve(b.covariance, b.mean)
    np.testing.assert_allclose(both.mean, np.linalg.solve(precision, pull), atol=1e-8)


@pytest.mark.parametrize("rank", [1, 5, 12])
def test_roots_square_to_the_covariance_and_draw_nothing_where_it_is_zero(rank):
    rng = np.random.default_rng(rank)
    wide = rng.standard_normal((12, rank))
    covariance = wide @ wide.T
    root = Gaussian(np.zeros(12), covariance).steady_root
    np.testing.assert_allclose(root @ root.T, covariance, atol=1e-12)
    assert np.linalg.matrix_rank(root) == rank
    drawn = Gaussian(np.zeros(12), covariance).draw(4000, rng)
    np.testing.assert_allclose(np.cov(drawn.T), covariance, atol=0.08 * np.trace(covariance))
    fixed = np.linalg.svd(wide)[0][:, rank:]
    np.testing.assert_allclose(drawn @ fixed, 0.0, atol=1e-7)


def test_determinants_and_inverses_agree_with_numpys():
    rng = np.random.default_rng(4)
    wide = rng.standard_normal((9, 9))
    matrix = wide @ wide.T + np.eye(9)
    assert dense.log_determinant(matrix) == pytest.approx(np.linalg.slogdet(matrix)[1])
    np.testing.assert_allclose(dense.inverse_definite(matrix), np.linalg.inv(matrix), atol=1e-12)
    with pytest.raises(np.linalg.LinAlgError):
        dense.log_determinant(-matrix)
    stiff = np.eye(9) + 1e12 * np.outer(wide[0], wide[0])
    wanted = np.log1p(1e12 * (wide[0] ** 2).sum())
    assert dense.log_determinant(stiff, least=1.0) == pytest.approx(wanted, abs=0.01)


def test_row_basis_spans_the_rows_and_is_orthonormal_where_they_nearly_agree():
    rng = np.random.default_rng(3)
    lengths = np.diag([1.0, 1e-3, 1e-6, 1e-12])
    rows = rng.standard_normal((30, 4)) @ lengths @ rng.standard_normal((4, 50))
    basis, chosen = dense.row_basis(rows, least=1e-9)
    assert basis.shape == (3, 50)
    np.testing.assert_allclose(basis @ basis.T, np.eye(3), atol=1e-9)
    np.testing.assert_allclose(rows @ basis.T @ basis, rows, atol=1e-10)
    triangle = rows[chosen] @ basis.T
    assert np.abs(np.triu(triangle, 1)).max() < 1e-14
