"""Demonstrations and measures that the tests of Fast Marching Learning share."""

import numpy as np

import leadthrough as lt
from leadthrough.preprocess import by_arc_length, frechet_distance

SHARE = np.linspace(0.0, 1.0, 150)


def arcs(heights, *, spread=0.005, gap=0.0, count=3):
    """Motions of 0.5 m over a hill and through a valley, whose starts are a gap apart."""
    rng = np.random.default_rng(1)
    made = []
    for height in heights:
        for _ in range(count):
            path = np.column_stack([0.5 * SHARE, height * np.sin(np.pi * SHARE)])
            path[:, 1] += (1.0 - SHARE) * np.sign(height) * 0.5 * gap
            path += rng.normal(0.0, spread, 2) * np.array([0.2, 1.0])
            made.append(lt.Trajectory(2.0 * SHARE, path))
    return made


def size_of(skill):
    """The diagonal of the box around a skill's demonstrations."""
    return float(np.linalg.norm(np.ptp(np.concatenate(skill.experience), axis=0)))


def gaps_to(path, points):
    """The distances of points (n, d) from the nearest point of a path."""
    return np.linalg.norm(points[:, None] - path[None], axis=2).min(axis=1)


def lead_out(skill, path):
    """How far a path leads out of the box around the demonstrations and its own ends."""
    region = np.concatenate([*skill.experience, path[[0, -1]]])
    return np.maximum(region.min(axis=0) - path, path - region.max(axis=0)).max()


def assert_bounded(skill, nominal, route, offset):
    """That ends moved by an offset move a route by 1.5 times as much and an area of influence.

    A route of another method stays in the box around the demonstrations and its own ends.
    """
    if route.method == nominal.method:
        assert apart(nominal.path, route.path) <= 1.5 * offset + skill.area_of_influence
    else:
        assert lead_out(skill, route.path) <= offset


def apart(one, other, count=200):
    """The Fréchet distance of two paths."""
    return frechet_distance(by_arc_length(one, count), by_arc_length(other, count))
