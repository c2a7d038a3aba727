"""Noise of recorded orientations."""

import numpy as np
import pytest
from models.dmp.turns import turn

from leadthrough import rotations
from leadthrough.models.dmp.orientation import noise_of


@pytest.mark.parametrize("sigma", [1e-3, 0.02])
def test_the_noise_of_orientations_is_measured_whatever_the_motion(sigma):
    _, q = turn(200, 1500)
    assert noise_of(q) < 1e-5
    assert noise_of(q[::2000]) == 0.0  # too few to tell
    added = np.random.default_rng(1).normal(0.0, sigma, (len(q), 3))
    assert noise_of(rotations.compose(q, rotations.exp(added))) == pytest.approx(sigma, rel=0.1)
