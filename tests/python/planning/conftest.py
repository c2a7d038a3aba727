from types import SimpleNamespace

import numpy as np
import pytest

import leadthrough as lt


@pytest.fixture
def divided():
    """A map that a wall divides, with times from the first cell; points without a path, and why."""
    speed = np.ones((7, 7))
    speed[3] = 0.0
    return SimpleNamespace(
        grid=lt.Grid((0.0, 0.0), 1.0, (7, 7)),
        speed=speed,
        times=lt.arrival_times(speed, (0, 0)),
        pathless={
            (9.0, 0.0): "start_outside",
            (3.0, 3.0): "start_unreached",
            (5.0, 5.0): "start_unreached",
        },
    )
