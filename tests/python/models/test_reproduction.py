"""Distances of a skill's motions from demonstrations, for skills that err by a known distance."""

from dataclasses import dataclass

import motions
import numpy as np
import pytest

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import NoPath

U = np.linspace(0.0, 1.0, 100)
LINE = lt.Trajectory(2.0 * U, np.outer(U, [0.3, 0.4, 0.0]))


@dataclass
class Offset:
    """A skill whose motions lie beside a given one, and which keeps what it was asked for."""

    motion: lt.Trajectory
    aside: float
    supports: frozenset = frozenset({"start", "goal"})

    def generate(self, **query):
        self.asked = query
        moved = self.motion.positions + np.array([0.0, 0.0, self.aside])
        return type(self.motion)(self.motion.times**2, moved)  # other timing does not count


def test_a_parallel_path_lies_at_its_distance():
    found = lt.models.reproduction(Offset(LINE, 0.007), [LINE, LINE])
    np.testing.assert_allclose(found.positions, 0.007, rtol=1e-3)
    assert found.position == pytest.approx(0.007, rel=1e-3)
    assert found.fraction == pytest.approx(0.007 / 0.5, rel=1e-3)
    assert found.orientation is None


def test_only_supported_parts_are_asked_for():
    skill = Offset(LINE, 0.0)
    lt.models.reproduction(skill, [LINE])
    np.testing.assert_array_equal(skill.asked["start"], LINE.positions[0])
    np.testing.assert_array_equal(skill.asked["goal"], LINE.positions[-1])
    assert "duration" not in skill.asked


def test_a_path_that_is_reversed_is_as_far_as_its_ends():
    back = lt.Trajectory(LINE.times, LINE.positions[::-1])
    found = lt.models.reproduction(Offset(back, 0.0), [LINE])
    assert found.position == pytest.approx(0.5, rel=1e-3)


def test_orientations_are_compared_by_their_angle():
    shown = motions.arch("poses")
    tilt = rotations.exp(np.tile([0.05, 0.0, 0.0], (len(shown), 1)))

    class Tilted(Offset):
        def generate(self, **_):
            turned = rotations.compose(shown.orientations, tilt)
            return lt.PoseTrajectory(shown.times, shown.positions, rotations.align_signs(turned))

    found = lt.models.reproduction(Tilted(shown, 0.0), [shown])
    assert found.position < 1e-9
    assert found.orientation == pytest.approx(0.05, rel=1e-2)


def test_a_skill_without_a_motion_is_infinitely_far():
    class Lost(Offset):
        def generate(self, **_):
            raise NoPath("no path", reason="obstacles")

    found = lt.models.reproduction(Lost(LINE, 0.0), [LINE])
    assert found.position == np.inf
    assert found.as_dict() == {"position": None, "orientation": None, "fraction": None}


def test_a_rhythm_is_compared_with_its_own_round():
    skill = lt.RhythmicDMP().fit([motions.ring("points")])
    assert lt.models.reproduction(skill, [motions.ring("points")]).fraction < 0.01
