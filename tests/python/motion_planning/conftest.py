"""Reaches across the table in front of a Panda, and what stands in the way of its hand."""

import numpy as np
import pytest

import leadthrough as lt

DOWN = np.array([0.0, 1.0, 0.0, 0.0])


def across(side=0.05, height=0.1, *, width=0.6, low=0.25, events=()):
    """A reach of 2 s in a bow to the side and upwards, m; the tool points down."""
    u = np.linspace(0.0, 1.0, 61)
    rise, bow = lt.trajectories.minimum_jerk_time_scaling(u), np.sin(np.pi * u)
    way = np.column_stack([0.45 + side * bow, width * (rise - 0.5), low + height * bow])
    return lt.PoseTrajectory(2.0 * u, way, np.tile(DOWN, (61, 1)), events)


@pytest.fixture(scope="module")
def box():
    """On the way of the hand, and beside that of the tool."""
    return lt.Box([0.08, 0.06, 0.1], [0.42, 0.0, 0.44])


@pytest.fixture(scope="module")
def roof():
    """Box around the hand at the goal."""
    return lt.Box([0.3, 0.1, 0.1], [0.45, 0.3, 0.4])
