"""A skill of poses of a Panda, shown once, for the tests of validations."""

import numpy as np
import pytest
from motions import minimum_jerk

import leadthrough as lt

HOME = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])  # rad


@pytest.fixture(scope="session")
def reach(panda):
    phase = np.linspace(0.0, 1.0, 51)[:, None]
    eased = minimum_jerk(phase)
    rows = HOME + eased * [0.6, 0.4, 0.0, 0.3, 0.0, 0.1, 0.2]
    shown = lt.JointTrajectory(3.0 * phase[:, 0], rows, joint_names=panda.joint_names)
    return lt.DMP(weights=20).fit([panda.poses(shown)])
