"""Motions that every writer is tested with, and damage for readers."""

import numpy as np
import pytest
from motions import minimum_jerk

import leadthrough as lt

UR = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
GRIPPER = (lt.Event(0.25, "close gripper"), lt.Event(0.9, 'say "done"'))


def _joints_of(names, count=101):
    """One second at 100 Hz from rest to rest, with exact derivatives and two events."""
    s = np.linspace(0.0, 1.0, count)
    shape = minimum_jerk(s)
    first = 30 * s**2 - 60 * s**3 + 30 * s**4
    second = 60 * s - 180 * s**2 + 120 * s**3
    way = np.linspace(-1.0, 1.2, len(names))
    start = np.linspace(0.3, -0.7, len(names))
    return lt.JointTrajectory(
        s,
        start + np.outer(shape, way),
        np.outer(first, way),
        np.outer(second, way),
        names,
        GRIPPER,
    )


@pytest.fixture(scope="session")
def joints_of():
    return _joints_of


@pytest.fixture(scope="session")
def ur_motion():
    return _joints_of(tuple(f"{name}_joint" for name in UR))


@pytest.fixture(scope="session")
def panda_motion():
    return _joints_of(tuple(f"panda_joint{i}" for i in range(1, 8)))


@pytest.fixture(scope="session")
def poses():
    s = np.linspace(0.0, 1.0, 51)
    turned = lt.rotations.exp(np.column_stack([np.sin(s), s**2, 0.5 - s]))
    return lt.PoseTrajectory(s, np.column_stack([s, s**2, np.cos(s)]), turned, GRIPPER)


@pytest.fixture
def write(tmp_path):
    def to_file(text, name="recording.csv"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return to_file
