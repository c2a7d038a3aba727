"""Stiffness along a motion from the spread of its demonstrations."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.models import stiffness_profile

U = np.linspace(0.0, 1.0, 160)


def test_stiffness_is_high_where_and_along_what_demonstrations_agree(family):
    _, covariance = lt.GMR(8).fit(family(20)).regress(2.0 * U)
    stiffness = stiffness_profile(covariance, softest=50.0, stiffest=800.0)
    values = np.linalg.eigvalsh(stiffness)
    assert values.min() == pytest.approx(50.0)
    assert values.max() == pytest.approx(800.0)
    assert stiffness[80, 1, 1] < 0.2 * stiffness[3, 1, 1]
    np.testing.assert_allclose(stiffness, stiffness.transpose(0, 2, 1), atol=1e-9)
    # The least stiff axis is the one that varies the most.
    most = np.linalg.eigh(covariance)[1][:, :, -1]
    least = np.linalg.eigh(stiffness)[1][:, :, 0]
    np.testing.assert_allclose(np.abs(np.einsum("ni,ni->n", most, least)), 1.0, atol=1e-6)


def test_stiffness_of_an_even_spread_is_the_stiffest_and_bad_input_is_refused():
    even = np.tile(np.eye(2), (4, 1, 1))
    np.testing.assert_allclose(
        stiffness_profile(even, softest=1.0, stiffest=9.0), 9.0 * even, atol=1e-9
    )
    for covariances in (-even, 0.0 * even, even + np.eye(2, k=1)):
        with pytest.raises(InvalidInput, match="covariances"):
            stiffness_profile(covariances, softest=1.0, stiffest=9.0)
    with pytest.raises(InvalidInput, match="stiffest"):
        stiffness_profile(even, softest=2.0, stiffest=1.0)
