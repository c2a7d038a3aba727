import numpy as np
import pytest
import scipy.ndimage
from hypothesis import given, settings
from hypothesis import strategies as st

from leadthrough.errors import InvalidInput
from leadthrough.planning import distance_transform


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.integers(1, 14), min_size=2, max_size=3),
    st.floats(0.001, 0.9),
    st.integers(0, 2**32),
)
def test_distances_equal_scipy_for_any_spacing(shape, share, seed):
    rng = np.random.default_rng(seed)
    mask = rng.random(shape) < share
    mask.flat[int(rng.integers(mask.size))] = True
    spacing = rng.uniform(0.1, 3.0, len(shape))
    expected = scipy.ndimage.distance_transform_edt(~mask, sampling=spacing)
    np.testing.assert_allclose(distance_transform(mask, spacing=spacing), expected, rtol=1e-12)


def test_without_a_cell_every_distance_is_infinite():
    assert np.isinf(distance_transform(np.zeros((4, 5), bool))).all()


@pytest.mark.parametrize("mask", [np.ones((3, 3)), np.ones(3, bool), np.ones((0, 3), bool), None])
def test_masks_of_the_wrong_kind_are_refused(mask):
    with pytest.raises(InvalidInput, match="mask"):
        distance_transform(mask)


@pytest.mark.parametrize("spacing", [-1.0, np.nan, (1.0, 2.0, 3.0), "1"])
def test_spacings_of_the_wrong_kind_are_refused(spacing):
    with pytest.raises(InvalidInput, match="spacing"):
        distance_transform(np.ones((3, 3), bool), spacing=spacing)
