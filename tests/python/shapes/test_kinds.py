"""Every shape answers all that planners, the simulation, pages and the command line ask."""

import pickle
from typing import get_args

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.cli import options, parse
from leadthrough.shapes import surface
from leadthrough.shapes.primitives import PRIMITIVES
from leadthrough.shapes.scene import SHAPES, check_shapes
from leadthrough.shapes.shape import Primitive, Shape, Solid

TURN = rotations.exp([[0.3, -0.7, 1.1]])[0]
PLACE = np.array([0.4, -0.2, 0.9])
SIZES = np.array([0.3, 0.5, 0.2])
C, S = np.cos(0.4), np.sin(0.4)
ABOUT_Z = np.array([[C, -S, 0.0], [S, C, 0.0], [0.0, 0.0, 1.0]])


def example(kind):
    if issubclass(kind, Primitive):
        sizes = SIZES[: kind.size_names.count(",") + 1]
        return kind.from_sizes(sizes, PLACE).at(PLACE, TURN)
    if kind is lt.Mesh:
        box = surface.box(SIZES)
        return lt.Mesh(box.vertices, box.faces, PLACE, TURN)
    return lt.PointCloud(np.random.default_rng(1).uniform(-0.3, 0.3, (200, 3)), 0.05, PLACE, TURN)


@pytest.fixture(params=SHAPES, ids=lambda kind: kind.__name__)
def shape(request):
    return example(request.param)


def concrete(kind):
    subclasses = [each for own in kind.__subclasses__() for each in concrete(own)]
    return subclasses or [kind]


def test_all_shapes_are_listed():
    assert set(concrete(Shape)) == set(SHAPES)
    assert all(hasattr(lt, kind.__name__) for kind in SHAPES)


def test_every_shape_has_a_form_on_the_command_line():
    kinds = [form.partition(":")[0] for form in parse.FORMS]
    assert sorted(kinds) == sorted([*PRIMITIVES, "mesh", "cloud"])
    assert len(kinds) == len(SHAPES)
    (_, option) = get_args(options.Obstacles)
    for name, kind in PRIMITIVES.items():
        assert f"{name}:{kind.size_names}@X,Y,Z" in option.help


@pytest.mark.parametrize("name", PRIMITIVES)
def test_a_primitive_is_parsed_with_its_sizes_and_pose(name):
    kind = PRIMITIVES[name]
    count = kind.size_names.count(",") + 1
    text = ",".join(map(str, SIZES[:count]))
    read = parse.obstacle(f"{name}:{text}@0.4,-0.2,0.9")
    assert type(read) is kind
    np.testing.assert_array_equal(read.sizes, SIZES[:count])
    np.testing.assert_array_equal(read.position, PLACE)
    refused("sizes", parse.obstacle, f"{name}:{text},1@0.4,-0.2,0.9")


def test_the_surface_of_a_shape_is_at_distance_zero(shape):
    vertices = shape.placed_surface().vertices
    atol = 0.06 if isinstance(shape, lt.PointCloud) else 1e-7  # dots overlap
    np.testing.assert_allclose(shape.distance(vertices), 0.0, atol=atol)


def test_the_bounds_of_a_shape_hold_its_surface_and_touch_it(shape):
    away = shape.placed_surface().vertices - shape.middle
    for reached, bound in (
        (np.abs(away).max(axis=0), shape.half_extents),
        (np.linalg.norm(away, axis=1).max(), shape.bounding_radius),
    ):
        assert (reached <= bound + 1e-9).all()
        np.testing.assert_allclose(reached, bound, rtol=0.1)


def test_the_convex_parts_of_a_shape_lie_in_its_bounds(shape):
    for part in shape.convex_parts():
        assert part.kind in (*PRIMITIVES, "mesh")
        assert (np.abs(part.position - shape.middle) <= shape.half_extents + 1e-9).all()
        assert (part.vertices is None) == (part.kind != "mesh")


def test_a_shape_is_the_same_elsewhere_and_after_pickling(shape):
    queries = np.random.default_rng(2).uniform(-1, 1, (50, 3))
    before = shape.distance(queries)
    there = shape.at(shape.position + 0.25)
    np.testing.assert_allclose(there.middle, shape.middle + 0.25)
    np.testing.assert_allclose(there.distance(queries + 0.25), before, atol=1e-8)
    upright = shape.at(np.zeros(3), (1.0, 0.0, 0.0, 0.0))
    local = (queries - PLACE) @ rotations.to_matrix(TURN[None])[0]
    np.testing.assert_allclose(upright.distance(local), before, atol=1e-8)
    back = shape.turned((0.0, 0.0, 0.4)).turned((0.0, 0.0, -0.4))
    np.testing.assert_allclose(back.distance(queries), before, atol=1e-8)
    about = shape.position + (queries - shape.position) @ ABOUT_Z.T
    np.testing.assert_allclose(shape.turned((0.0, 0.0, 0.4)).distance(about), before, atol=1e-8)
    refused("position: ", shape.at, (0.0, 0.0))
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(shape)).distance(queries), before)
    assert there.form() == shape.form() == pickle.loads(pickle.dumps(shape)).form()


def test_solids_weigh_as_the_points_inside(shape):
    if not isinstance(shape, Solid):
        return
    steps = np.linspace(-0.5, 0.5, 61)
    cells = PLACE + np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
    inside = cells[shape.distance(cells) <= 0.0]
    centre, inertia = shape.unit_inertia()
    np.testing.assert_allclose(centre, inside.mean(axis=0), atol=2e-3)
    away = inside - centre
    expected = ((away**2).sum() * np.eye(3) - away.T @ away) / len(inside)
    np.testing.assert_allclose(inertia, expected, atol=3e-3)


def test_what_is_no_shape_is_refused_with_the_list():
    refused("Box, Sphere, Capsule, Cylinder, Mesh or PointCloud", check_shapes, ["box"])
