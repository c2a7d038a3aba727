"""Signed distances against points sampled on the surfaces."""

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough import rotations

TURN = rotations.exp([[0.3, -0.7, 1.1]])[0]
PLACE = np.array([0.4, -0.2, 0.9])
BOX = lt.Box((0.4, 0.6, 1.0), PLACE, TURN)
CAPSULE = lt.Capsule(0.2, 0.8, PLACE, TURN)
SPHERE = lt.Sphere(0.5, PLACE)
CYLINDER = lt.Cylinder(0.3, 0.8, PLACE, TURN)
EACH = pytest.mark.parametrize(
    "shape", [BOX, CAPSULE, SPHERE, CYLINDER], ids=lambda shape: type(shape).__name__
)


def test_distances_on_the_axes_are_exact():
    box = lt.Box((2.0, 4.0, 6.0), (0.0, 0.0, 0.0))
    np.testing.assert_array_equal(box.distance([[0, 0, 0], [3, 0, 0], [4, 6, 3]]), [-1, 2, 5])
    capsule = lt.Capsule(1.0, 4.0, (0.0, 0.0, 0.0))
    np.testing.assert_array_equal(capsule.distance([[0, 0, 0], [3, 0, 1], [0, 0, 5]]), [-1, 2, 2])
    cylinder = lt.Cylinder(1.0, 4.0, (0.0, 0.0, 0.0))
    around = [[0, 0, 0], [3, 0, 1], [0, 0, 5], [0, 5, 5], [0, 0, 1.5]]
    np.testing.assert_array_equal(cylinder.distance(around), [-1, 2, 3, 5, -0.5])


@EACH
def test_bad_points_are_refused(shape):
    for bad in ([0.0, 0, 0], [[0.0, 0]], [[np.nan, 0, 0]], None):
        refused("points: ", shape.distance, bad)
    assert shape.distance(np.zeros((0, 3))).shape == (0,)


@pytest.mark.parametrize(
    ("call", "name"),
    [
        (lambda: lt.Box((1, 0, 1), PLACE), "size"),
        (lambda: lt.Box((1, np.inf, 1), PLACE), "size"),
        (lambda: lt.Box((1, 1), PLACE), "size"),
        (lambda: lt.Box((1, 1, 1), PLACE, (0, 0, 0, 0)), "orientation"),
        (lambda: lt.Sphere(-1.0, PLACE), "radius"),
        (lambda: lt.Sphere(1.0, (0, 0)), "position"),
        (lambda: lt.Capsule(0.1, -1.0, PLACE), "length"),
        (lambda: lt.Capsule(np.nan, 1.0, PLACE), "radius"),
        (lambda: lt.Cylinder(0.1, 0.0, PLACE), "length"),
        (lambda: lt.Cylinder(-0.1, 1.0, PLACE), "radius"),
        (lambda: lt.Cylinder(0.1, 1.0, (0, np.nan, 0)), "position"),
    ],
)
def test_impossible_shapes_are_refused(call, name):
    refused(f"{name}: ", call)


def by_hand(shape, queries):
    """The distances by the formulas of each shape in its own frame."""
    if isinstance(shape, lt.Sphere):
        return np.linalg.norm(queries - shape.position, axis=1) - shape.radius
    local = (queries - shape.position) @ rotations.to_matrix(shape.orientation[None])[0]
    if isinstance(shape, lt.Capsule):
        local[:, 2] -= np.clip(local[:, 2], -0.5 * shape.length, 0.5 * shape.length)
        return np.linalg.norm(local, axis=1) - shape.radius
    if isinstance(shape, lt.Cylinder):
        side = np.hypot(local[:, 0], local[:, 1]) - shape.radius
        outside = np.column_stack([side, np.abs(local[:, 2]) - 0.5 * shape.length])
    else:
        outside = np.abs(local) - 0.5 * shape.size
    beyond = np.linalg.norm(np.maximum(outside, 0.0), axis=1)
    return beyond + np.minimum(outside.max(axis=1), 0.0)


@EACH
def test_distances_are_those_of_the_formulas(shape):
    queries = PLACE + np.random.default_rng(4).uniform(-1, 1, (500, 3))
    np.testing.assert_allclose(shape.distance(queries), by_hand(shape, queries), atol=1e-15)
