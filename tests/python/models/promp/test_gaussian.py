"""Normal distributions of vectors."""

import numpy as np

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
