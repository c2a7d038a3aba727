"""Motions that ProMPs are fitted to, and skills fitted to them."""

import numpy as np
import pytest
from motions import minimum_jerk

import leadthrough as lt


def _shown(count=8, *, joints=3, noise=0.0, seed=0, duration=2.0):
    rng = np.random.default_rng(seed)
    u = np.linspace(0.0, 1.0, 200)
    swing = minimum_jerk(u)
    demonstrations = []
    for _ in range(count):
        ends = np.arange(1, joints + 1) * (1.0 + 0.2 * rng.standard_normal(joints))
        bump = 0.3 * rng.standard_normal(joints)
        q = np.outer(swing, ends) + np.outer(np.sin(np.pi * u), bump)
        q = q + noise * rng.standard_normal(q.shape)
        motion = lt.JointTrajectory(duration * u, q, joint_names=tuple("abcdefg"[:joints]))
        demonstrations.append(motion)
    return demonstrations


@pytest.fixture(scope="session")
def shown():
    """Makes smooth joint motions whose amplitudes and offsets vary."""
    return _shown


@pytest.fixture(scope="session")
def skill():
    """A ProMP of three joints, fitted to eight demonstrations of 2 s."""
    return lt.ProMP().fit(_shown())


def _family(height, *, count=8, seed=0, duration=2.0, spread=0.02):
    rng = np.random.default_rng(seed)
    u = np.linspace(0.0, 1.0, 150)
    demonstrations = []
    for _ in range(count):
        peak = height + spread * rng.standard_normal()
        goal = 0.3 + spread * rng.standard_normal()
        points = np.column_stack([goal * u, peak * np.sin(np.pi * u)])
        demonstrations.append(lt.Trajectory(duration * u, points))
    return demonstrations


@pytest.fixture(scope="session")
def family():
    """Makes bumps in the plane whose heights and goals vary a little."""
    return _family


@pytest.fixture(scope="session")
def skills():
    """Two ProMPs of bumps, one upwards and one downwards, of 2 s."""
    return [lt.ProMP(weights=10).fit(_family(height)) for height in (0.1, -0.1)]
