import numpy as np
import pytest
from scipy.ndimage import uniform_filter1d

from leadthrough.models.dmp.progress import running_mean


@pytest.mark.parametrize("mode", ["nearest", "wrap"])
@pytest.mark.parametrize("size", [1, 2, 7, 20, 61])
def test_running_means_have_the_bits_of_scipys(size, mode):
    values = np.random.default_rng(size).normal(size=(50, 3))
    expected = uniform_filter1d(values, size, axis=0, mode=mode)
    assert running_mean(values, size, mode).tobytes() == expected.tobytes()
    assert running_mean(values[:, 0], size, mode).tobytes() == expected[:, 0].tobytes()
