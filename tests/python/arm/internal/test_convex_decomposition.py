"""Convex parts of meshes."""

import numpy as np
from hypothesis import given, settings, strategies as st
from scipy.spatial import ConvexHull
from shapes.meshes import mesh_of

import leadthrough as lt
from leadthrough.arm.convex_decomposition import convex_parts


def outside(parts, points):
    """Distances (n,) of points from the nearest part, at most 0 inside."""
    planes = [ConvexHull(part).equations for part in parts]
    return np.min([(points @ p[:, :3].T + p[:, 3]).max(axis=1) for p in planes], axis=0)


def random_star(rng, size):
    """A closed surface around the origin with dents, and points on it."""
    directions = rng.normal(size=(size, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    faces = ConvexHull(directions).simplices
    vertices = directions * rng.uniform(0.03, 0.2, (size, 1)) * rng.uniform(0.5, 1.5, 3)
    corners = vertices[faces[rng.integers(len(faces), size=500)]]
    return vertices, faces, np.einsum("nk,nkj->nj", rng.dirichlet(np.ones(3), 500), corners)


@settings(max_examples=20)
@given(st.integers(0, 2**32), st.sampled_from([60, 60, 3000]))
def test_the_surface_and_the_inside_of_a_mesh_lie_in_its_parts(seed, size):
    rng = np.random.default_rng(seed)
    vertices, faces, points = random_star(rng, size)
    parts = convex_parts(vertices, faces)
    assert (size == 60) < len(parts) <= 8  # spikes everywhere are not worth a cut
    assert outside(parts, points).max() < 1e-9
    assert outside(parts, points * rng.uniform(size=(500, 1))).max() < 1e-9


def test_an_angle_bracket_leaves_its_corner_free():
    along, across = lt.Box((0.4, 0.1, 0.1), (0.15, 0, 0)), lt.Box((0.1, 0.4, 0.1), (0, 0.15, 0))
    bracket = mesh_of(along, across)
    parts = convex_parts(bracket.vertices, bracket.faces)
    assert sum(ConvexHull(part).volume for part in parts) < 1.2 * 7e-3  # of the bracket
    assert outside(parts, np.array([[0.15, 0.15, 0.0]])) > 0.05


def test_a_spike_of_few_triangles_is_cut_off_a_mesh_of_many():
    ball = np.random.default_rng(1).normal(size=(3000, 3))
    ball *= 0.1 / np.linalg.norm(ball, axis=1)[:, None]
    last = np.argsort(ball[:, 0])[-3:]
    spike = np.column_stack([last, np.roll(last, 1), np.full(3, len(ball))])
    vertices = np.concatenate([ball, [[0.9, 0.0, 0.0]]])
    parts = convex_parts(vertices, np.concatenate([ConvexHull(ball).simplices, spike[:1]]))
    assert outside(parts, np.array([[0.5, 0.04, 0.0]])) > 0.0


def test_a_convex_mesh_is_its_own_hull():
    ball = mesh_of(lt.Sphere(0.1, np.zeros(3)))
    (part,) = convex_parts(ball.vertices, ball.faces)
    assert len(part) == len(np.unique(ball.vertices, axis=0))
