"""A short motion of a Panda with a payload, and what it is in simulation."""

from dataclasses import replace

import numpy as np
import pytest

import leadthrough as lt

HOME = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
IDEAL = lt.simulation.Disturbances.ideal()
AWAY = np.array([0.6, -0.1, -0.3, -1.6, 0.3, 1.3, 1.2])


@pytest.fixture(scope="session")
def loaded():
    """A Panda with 1 kg at its tip."""
    return lt.Arm.load("panda").with_payload(1.0, (0.0, 0.0, 0.03))


@pytest.fixture(scope="session")
def swing(loaded):
    """From rest to rest, as fast as the limits allow."""
    way = lt.trajectories.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, 101))
    return lt.retime(HOME + np.outer(way, AWAY - HOME), loaded.limits)


@pytest.fixture(scope="session")
def simulated(loaded, swing):
    """The motion of an ideal arm with the default controller."""
    return lt.simulate(loaded, swing, disturbances=IDEAL)


def disturbed(**only):
    """Disturbances of an arm that is ideal otherwise."""
    return replace(IDEAL, **only)
