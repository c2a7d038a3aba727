"""Kernels of the transformation system."""

import numpy as np

from leadthrough.models.dmp.transformation import gaussian_kernels, von_mises_kernels


def test_kernels_sum_to_their_regressor():
    for basis in (gaussian_kernels(12), von_mises_kernels(12)):
        share = basis.values / basis.values.sum(axis=1, keepdims=True)
        np.testing.assert_allclose(share.sum(axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(
        von_mises_kernels(7).features[0], von_mises_kernels(7).features[-1], atol=1e-12
    )
