"""Demonstrations misaligned in time: a warning names them and the remedy."""

import numpy as np
import pytest
from kinds import kind
from motions import motion_of

import leadthrough as lt
from leadthrough.models import MisalignmentWarning
from leadthrough.preprocess import align_by_time_warping

T = np.linspace(0.0, 3.0, 300)


def paused(at):
    """A reach that rests for a second at a fraction of its length."""
    u = np.interp(T, [0.0, 2.0 * at, 2.0 * at + 1.0, 3.0], [0.0, at, at, 1.0])
    return np.column_stack([u, np.sin(6.0 * u), 0.2 * u])


def demonstration(at, motion="points"):
    path = paused(at)
    return motion_of(motion, T, path, np.outer(path[:, 0], [0.0, 0.5, 1.0]))


LEARNERS = (
    kind("ProMP"),
    kind("ProMP", "poses"),
    kind("GMR", starts=1),
    kind("DMP"),
    kind("DMP", "poses"),
)


@pytest.mark.parametrize("learner", LEARNERS, ids=str)
def test_a_warning_names_the_demonstrations_and_the_cure_once_and_here(learner):
    model = learner.build()
    shown = [demonstration(at, learner.motion) for at in (0.5, 0.5, 0.5, 0.9, 0.5)]
    cure = r"demonstrations \[3\]: .* preprocess.align_by_time_warping"
    with pytest.warns(MisalignmentWarning, match=cure) as told:
        model.fit(shown)
    assert [warning.filename for warning in told] == [__file__]
    model.fit(align_by_time_warping(shown))  # warnings are errors: this one has none


def test_demonstrations_that_all_differ_are_all_named():
    with pytest.warns(MisalignmentWarning, match=r"\[0, 2\]: .* 22% of the duration"):
        lt.ProMP().fit([demonstration(at) for at in (0.2, 0.5, 0.8)])


def test_given_phases_say_what_belongs_together():
    at = (0.2, 0.8)
    u = [np.interp(T, [0.0, 2.0 * a, 2.0 * a + 1.0, 3.0], [0.0, a, a + 1e-3, 1.0]) for a in at]
    lt.ProMP().fit([demonstration(a) for a in at], phases=u)


def test_handwriting_and_single_motions_are_in_step():
    for name in lt.io.lasa.motions()[::3]:
        lt.ProMP().fit(lt.io.lasa.load(name))
    lt.DMP().fit([demonstration(0.2)])
