"""Signed distances against points sampled on the surfaces."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays
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

points = arrays(float, (5, 3), elements=st.floats(-3, 3))


def to_base(local):
    return local @ rotations.to_matrix(TURN[None])[0].T + PLACE


def surface(shape, count=40_000):
    """Points on the surface, dense enough that the nearest one is near the true foot point."""
    random = np.random.default_rng(1)
    directions = random.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    if isinstance(shape, lt.Sphere):
        return shape.position + shape.radius * directions
    if isinstance(shape, lt.Capsule):
        ends = shape.radius * directions + np.outer(np.sign(directions[:, 2]), [0, 0, 0.5]) * (
            shape.length
        )
        sides = directions.copy()
        sides[:, :2] *= shape.radius / np.linalg.norm(sides[:, :2], axis=1, keepdims=True)
        sides[:, 2] = random.uniform(-0.5, 0.5, count) * shape.length
        return to_base(np.vstack([ends, sides]))
    if isinstance(shape, lt.Cylinder):
        sides = directions.copy()
        sides[:, :2] /= np.linalg.norm(sides[:, :2], axis=1, keepdims=True)
        sides[:, 2] = random.uniform(-1, 1, count)
        ends = sides * [[1, 1, 0]] * np.sqrt(random.uniform(size=(count, 1)))
        ends[:, 2] = np.sign(directions[:, 2])
        return to_base(np.vstack([sides, ends]) * [shape.radius, shape.radius, 0.5 * shape.length])
    faces = random.uniform(-0.5, 0.5, (count, 3))
    faces[np.arange(count), np.arange(count) % 3] = np.where(random.random(count) < 0.5, -0.5, 0.5)
    return to_base(faces * shape.size)


@EACH
def test_distance_is_to_the_nearest_point_of_the_surface(shape):
    shell = surface(shape)
    queries = PLACE + np.random.default_rng(2).uniform(-1, 1, (200, 3))
    nearest = np.array([np.linalg.norm(shell - query, axis=1).min() for query in queries])
    assert np.abs(np.abs(shape.distance(queries)) - nearest).max() < 0.02
    assert np.abs(shape.distance(shell)).max() < 1e-15 * 10
    assert shape.distance([PLACE])[0] < 0
    assert shape.distance([PLACE + 10])[0] > 0


def test_distances_on_the_axes_are_exact():
    box = lt.Box((2.0, 4.0, 6.0), (0.0, 0.0, 0.0))
    np.testing.assert_array_equal(box.distance([[0, 0, 0], [3, 0, 0], [4, 6, 3]]), [-1, 2, 5])
    capsule = lt.Capsule(1.0, 4.0, (0.0, 0.0, 0.0))
    np.testing.assert_array_equal(capsule.distance([[0, 0, 0], [3, 0, 1], [0, 0, 5]]), [-1, 2, 2])
    cylinder = lt.Cylinder(1.0, 4.0, (0.0, 0.0, 0.0))
    around = [[0, 0, 0], [3, 0, 1], [0, 0, 5], [0, 5, 5], [0, 0, 1.5]]
    np.testing.assert_array_equal(cylinder.distance(around), [-1, 2, 3, 5, -0.5])


@EACH
@given(a=points, b=points)
def test_distance_changes_no_faster_than_the_point_moves(shape, a, b):
    change = np.abs(shape.distance(a) - shape.distance(b))
    assert (change <= np.linalg.norm(a - b, axis=1) + 1e-12).all()


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


@EACH
def test_bounds_of_a_shape_touch_its_surface(shape):
    on_it = surface(shape) - shape.position
    reached = np.abs(on_it).max(axis=0)
    assert (reached <= shape.half_extents + 1e-9).all()
    np.testing.assert_allclose(reached, shape.half_extents, rtol=0.1)
    farthest = np.linalg.norm(on_it, axis=1).max()
    assert farthest <= shape.bounding_radius + 1e-9
    assert farthest == pytest.approx(shape.bounding_radius, rel=0.1)


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


@EACH
def test_a_moved_shape_is_the_same_at_another_place(shape):
    queries = np.random.default_rng(5).uniform(-1, 1, (50, 3))
    before = shape.distance(queries)
    away = shape.at(shape.position + 0.25)
    np.testing.assert_allclose(away.distance(queries + 0.25), before, atol=1e-15)
    np.testing.assert_allclose(away._compiled.distances(queries + 0.25), before, atol=1e-15)
    upright = shape.at(np.zeros(3), (1.0, 0.0, 0.0, 0.0))
    local = (queries - PLACE) @ rotations.to_matrix(TURN[None])[0]
    np.testing.assert_allclose(upright.distance(local), before, atol=1e-14)
    refused("position: ", shape.at, (0.0, 0.0))
