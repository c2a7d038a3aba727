"""Motions that mixtures are fitted to."""

import numpy as np
import pytest

import leadthrough as lt


def _family(count=6, *, seed=0, spread=0.05, height=0.4):
    u = np.linspace(0.0, 1.0, 160)
    rng = np.random.default_rng(seed)
    shown = []
    for _ in range(count):
        bump = height + spread * rng.standard_normal()
        points = np.column_stack([u, bump * np.sin(np.pi * u) ** 2])
        points += 0.002 * rng.standard_normal(points.shape)
        shown.append(lt.Trajectory(2.0 * u, points))
    return shown


@pytest.fixture(scope="session")
def family():
    """Makes bumps in the plane that vary in the middle and agree at both ends, of 2 s."""
    return _family
