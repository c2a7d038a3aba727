"""Numerics of movement primitives: orientation noise, running means, kernels."""

import numpy as np
import pytest
from models.dmp.turns import turn
from scipy.ndimage import uniform_filter1d

from leadthrough import rotations
from leadthrough.models.dmp.orientation import noise_of
from leadthrough.models.dmp.progress import running_mean
from leadthrough.models.dmp.transformation import gaussian_kernels, von_mises_kernels


@pytest.mark.parametrize("sigma", [1e-3, 0.02])
def test_the_noise_of_orientations_is_measured_whatever_the_motion(sigma):
    _, q = turn(200, 1500)
    assert noise_of(q) < 1e-5
    assert noise_of(q[::2000]) == 0.0  # too few to tell
    added = np.random.default_rng(1).normal(0.0, sigma, (len(q), 3))
    assert noise_of(rotations.compose(q, rotations.exp(added))) == pytest.approx(sigma, rel=0.1)


@pytest.mark.parametrize("mode", ["nearest", "wrap"])
@pytest.mark.parametrize("size", [1, 2, 7, 20, 61])
def test_running_means_have_the_bits_of_scipys(size, mode):
    values = np.random.default_rng(size).normal(size=(50, 3))
    expected = uniform_filter1d(values, size, axis=0, mode=mode)
    assert running_mean(values, size, mode).tobytes() == expected.tobytes()
    assert running_mean(values[:, 0], size, mode).tobytes() == expected[:, 0].tobytes()


def test_kernels_sum_to_their_regressor():
    for basis in (gaussian_kernels(12, 0.8), von_mises_kernels(12)):
        share = basis.features() / basis.tables()[1]
        np.testing.assert_allclose(share.sum(axis=1), 1.0, atol=1e-12)
    rhythm = von_mises_kernels(7).features()
    np.testing.assert_allclose(rhythm[0], rhythm[-1], atol=1e-12)


@pytest.mark.parametrize("count", [2, 50, 420])
def test_kernels_are_gaussian_to_the_bit_in_whichever_parts(count):
    basis = gaussian_kernels(count, 0.8)
    values = np.exp(-basis.sharpness * (basis.fade[:, None] - basis.centres) ** 2)
    assert basis.tables()[0].tobytes() == values.tobytes()
    features = values / values.sum(axis=1, keepdims=True) * (basis.fade[:, None] / basis.centres)
    assert np.concatenate([basis.features(part) for part in basis.parts]).tobytes() == (
        features.tobytes()
    )
    halves = np.hstack(
        [basis.features(some=part) for part in (slice(count // 2), slice(count // 2, None))]
    )
    assert halves.tobytes() == features.tobytes()
