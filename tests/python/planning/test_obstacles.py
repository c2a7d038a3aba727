import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.planning import occupied

TURNED = np.array([0.8, 0.2, -0.4, 0.4])
SHAPES = [
    lt.Box((0.3, 0.5, 0.2), (0.1, 0.2, 0.0), TURNED),
    lt.Sphere(0.25, (0.3, -0.2, 0.1)),
    lt.Capsule(0.1, 0.4, (-0.2, 0.1, 0.05), TURNED),
    lt.Sphere(0.3, (5.0, 5.0, 5.0)),
]


@pytest.mark.parametrize("margin", [0.0, 0.07])
def test_cells_are_occupied_where_a_shape_is_nearer_than_the_margin(margin):
    grid = lt.Grid((-0.5, -0.6, -0.4), (0.05, 0.06, 0.04), (20, 20, 20))
    points = grid.centres().reshape(-1, 3)
    expected = np.min([shape.distance(points) for shape in SHAPES], axis=0) <= margin
    actual = occupied(grid, SHAPES, margin=margin)
    np.testing.assert_array_equal(actual, expected.reshape(grid.shape))
    assert 0 < actual.sum() < actual.size


def test_a_plane_grid_is_cut_at_height_zero():
    grid = lt.Grid((-0.5, -0.5), 0.02, (50, 50))
    flat = grid.centres().reshape(-1, 2)
    points = np.column_stack([flat, np.zeros(len(flat))])
    expected = np.min([shape.distance(points) for shape in SHAPES], axis=0) <= 0.0
    np.testing.assert_array_equal(occupied(grid, SHAPES), expected.reshape(grid.shape))


def test_no_obstacle_occupies_nothing():
    assert not occupied(lt.Grid((0.0, 0.0), 1.0, (3, 3)), []).any()


def test_bad_input_is_refused():
    grid = lt.Grid((0.0, 0.0), 1.0, (3, 3))
    with pytest.raises(InvalidInput, match="obstacles"):
        occupied(grid, ["box"])
    with pytest.raises(InvalidInput, match="margin"):
        occupied(grid, [], margin=np.nan)
