import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import leadthrough as lt
from leadthrough.errors import InvalidInput

GRID = lt.Grid((1.0, -2.0, 0.5), (0.1, 0.2, 0.3), (4, 5, 6))


def test_centres_lie_at_whole_coordinates():
    indices = np.argwhere(np.ones(GRID.shape))
    centres = GRID.centres().reshape(-1, 3)
    np.testing.assert_allclose(GRID.coordinates(centres), indices, atol=1e-12)
    np.testing.assert_array_equal(GRID.cells_of(centres), indices)
    np.testing.assert_allclose(GRID.points_at(indices), centres, atol=1e-15)


@given(hnp.arrays(float, (3,), elements=st.floats(-3.0, 9.0)))
def test_a_point_is_contained_exactly_if_it_has_a_cell(coordinates):
    point = GRID.points_at([coordinates])
    if GRID.contains(point)[0]:
        cell = GRID.cells_of(point)[0]
        assert (np.abs(cell - coordinates) <= 0.5 + 1e-9).all()
        assert (cell >= 0).all()
        assert (cell < GRID.shape).all()
    else:
        ends = r"from \[ 1.  -2.   0.5\] to \[ 1.3 -1.2  2. \]"
        with pytest.raises(InvalidInput, match=f"points: expected points in the grid, {ends}"):
            GRID.cells_of(point)


@given(
    hnp.arrays(float, st.tuples(st.integers(1, 9), st.integers(2, 3)), elements=st.floats(-9, 9)),
    st.floats(0.0, 2.0),
    st.floats(0.3, 2.0),
)
def test_a_covering_grid_reaches_the_margin_and_little_more(points, margin, spacing):
    grid = lt.Grid.covering(points, margin=margin, spacing=spacing)
    low, high = grid.origin, grid.points_at([np.array(grid.shape) - 1])[0]
    slack = 1e-9
    assert (low <= points.min(axis=0) - margin + slack).all()
    assert (high >= points.max(axis=0) + margin - slack).all()
    assert (low > points.min(axis=0) - margin - spacing - slack).all()
    assert (high < points.max(axis=0) + margin + spacing + slack).all()
    assert grid.contains(points).all()
