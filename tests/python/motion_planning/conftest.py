"""The arm of these tests."""

import pytest

import leadthrough as lt


@pytest.fixture(scope="session")
def panda():
    return lt.Arm.load("panda")
