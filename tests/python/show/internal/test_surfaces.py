"""Surfaces: closed, the right way round, of the right size."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

import leadthrough as lt
from leadthrough.shapes import surface
from leadthrough.show import animation as surfaces
from leadthrough.show.animation import creased


def volume(mesh):
    """By the divergence theorem: right only where every triangle faces outwards."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def is_closed(mesh):
    """Whether each edge has one triangle on either side."""
    _, points = np.unique(np.round(mesh.vertices, 9), axis=0, return_inverse=True)
    faces = points.ravel()[mesh.faces]
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    there = {tuple(edge) for edge in edges.tolist()}
    return len(there) == len(edges) and all((b, a) in there for a, b in there)


LINE = np.linspace((0.0, 0.0, 0.0), (0.0, 0.0, 2.0), 30)

SOLIDS = {
    "box": (surface.box(np.array([1.0, 2.0, 3.0])), 6.0),
    "cylinder": (surface.cylinder(0.5, 2.0), np.pi * 0.25 * 2.0),
    "sphere": (surface.sphere(0.5), 4.0 / 3.0 * np.pi * 0.125),
    "capsule": (surface.capsule(0.5, 2.0), np.pi * 0.5 + 4.0 / 3.0 * np.pi * 0.125),
    "tube": (surfaces.tube(LINE, 0.1, sides=60), np.pi * 0.01 * 2.0),
}


@pytest.mark.parametrize("name", SOLIDS)
def test_solid_is_closed_faces_outwards_and_has_its_volume(name):
    mesh, wanted = SOLIDS[name]
    assert is_closed(mesh)
    assert volume(mesh) == pytest.approx(wanted, rel=0.02)


@given(st.integers(0, 2**32 - 1))
def test_shape_stands_where_it_says(seed):
    rng = np.random.default_rng(seed)
    turned = lt.rotations.exp(rng.normal(size=(1, 3)))[0]
    place = rng.normal(size=3)
    for shape in (
        lt.Box(rng.uniform(0.1, 1.0, 3), place, turned),
        lt.Capsule(0.1, 0.5, place, turned),
        lt.Cylinder(0.1, 0.5, place, turned),
        lt.Sphere(0.3, place),
    ):
        points = shape.placed_surface().vertices
        assert np.abs(shape.distance(points)).max() < 1e-9


def test_tube_keeps_its_radius_around_a_knot():
    t = np.linspace(0.0, 2.0 * np.pi, 600)
    knot = np.column_stack(
        [np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)]
    )
    mesh = surfaces.tube(knot, 0.05)
    away = np.linalg.norm(mesh.vertices[:-2, None] - knot[None], axis=2).min(axis=1)
    assert np.allclose(away, 0.05, atol=2e-3)


def test_tube_of_a_path_that_stands_still_is_a_ball():
    mesh = surfaces.tube(np.tile([1.0, 2.0, 3.0], (5, 1)), 0.1)
    assert np.allclose(np.linalg.norm(mesh.vertices - (1.0, 2.0, 3.0), axis=1), 0.1)


def test_cross_sections_of_a_path_that_turns_back_stay_unit_and_across():
    path = np.array([[0.0, 0, 0], [1, 0, 0], [0, 0, 0], [0, 0, 0], [0, 1, 0]])
    frames = surfaces.cross_sections(path)
    assert np.allclose(np.linalg.norm(frames, axis=2), 1.0)
    assert np.allclose(np.einsum("ni,ni->n", frames[:, 0], frames[:, 1]), 0.0)


def test_uncertainty_tube_has_two_standard_deviations_across_the_path():
    covariance = np.diag([0.01, 0.04, 0.09])
    mesh = surfaces.uncertainty_tube(LINE, np.tile(covariance, (len(LINE), 1, 1)))
    reach = np.abs(mesh.vertices).max(axis=0)
    assert reach[:2] == pytest.approx([0.2, 0.4], rel=0.01)
    assert reach[2] == pytest.approx(2.0)  # along the path nothing is added


def test_creases_of_a_box_are_sharp_and_its_faces_flat():
    mesh, normals = creased(surface.box(np.array([1.0, 2.0, 3.0])))
    assert len(mesh.vertices) == 24
    assert np.allclose(np.abs(normals).max(axis=1), 1.0)


def test_normals_of_a_ball_point_away_from_its_centre():
    mesh, normals = creased(surface.sphere(0.7))
    outwards = mesh.vertices / np.linalg.norm(mesh.vertices, axis=1, keepdims=True)
    assert np.einsum("ij,ij->i", normals, outwards).min() > 0.99


def test_creases_keep_the_surface():
    before = surface.cylinder(0.2, 1.0)
    after, normals = creased(before)
    assert volume(after) == pytest.approx(volume(before))
    assert np.allclose(np.linalg.norm(normals, axis=1), 1.0)


def test_rows_are_numbered_in_their_order():
    rng = np.random.default_rng(0)
    rows = rng.integers(-1_000_000, -999_990, (500, 3))
    wanted = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    got = np.unique(surfaces._numbered(rows), return_index=True, return_inverse=True)
    assert np.array_equal(got[1], wanted[1])
    assert np.array_equal(got[2], wanted[2].ravel())


def test_path_is_thinned_evenly_and_keeps_its_ends():
    path = np.column_stack([np.linspace(0.0, 1.0, 1000) ** 3, np.zeros(1000), np.zeros(1000)])
    thin = surfaces.thinned(path, 11)
    assert np.allclose(thin[:, 0], np.linspace(0.0, 1.0, 11))
    assert surfaces.thinned(path[:5], 11) is not None
