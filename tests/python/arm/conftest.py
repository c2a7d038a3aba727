"""Arms of three makers, from the URDFs of example-robot-data, and a motion to follow."""

import numpy as np
import pytest
from foreign_arms import urdf_in_package
from motions import urdf

import leadthrough as lt

# name: file, base, tip, a comfortable posture
ROBOTS = {
    "panda": ("panda.urdf", "panda_link0", "panda_hand", [0, -0.5, 0, -2, 0, 1.6, 0.7]),
    "ur3": ("ur3_robot.urdf", "base_link", "tool0", [0, -1.2, 1.4, -1.7, -1.5, 0.3]),
    "tiago": (
        "tiago_no_hand.urdf",
        "base_link",
        "arm_7_link",
        [0.15, 1.3, 0.2, -0.5, 1.6, 0.3, 0.4, 0.2],
    ),
}


@pytest.fixture(params=ROBOTS)
def robot(request):
    """Name, arm, URDF path, posture."""
    file, base, tip, posture = ROBOTS[request.param]
    path = urdf_in_package("example-robot-data", file)
    return request.param, lt.Arm.from_urdf(path, base=base, tip=tip), path, np.array(posture, float)


@pytest.fixture
def arm(robot):
    return robot[1]


@pytest.fixture
def posture(robot):
    return robot[3]


@pytest.fixture(scope="session")
def robots_by_name():
    """The bundled robots' arms with the paths of their URDFs."""
    return [(lt.Arm.load(name), urdf(name)) for name in ROBOTS]


@pytest.fixture(scope="session")
def sweep():
    """The tip goes 0.4 m across in front of the arm, pointing down."""
    share = np.linspace(0.0, 1.0, 81)[:, None]
    way = [0.45, -0.2, 0.35] + share * [0.0, 0.4, 0.0]
    return lt.PoseTrajectory(4.0 * share[:, 0], way, np.tile([0.0, 1.0, 0.0, 0.0], (81, 1)))
