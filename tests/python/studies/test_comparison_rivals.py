"""Models of other libraries behind the comparison's interface; those not installed are skipped."""

import numpy as np
import pytest
from motions import minimum_jerk

import leadthrough as lt
from leadthrough import rotations
from leadthrough_studies.comparison import material, rivals
from leadthrough_studies.comparison.methods import NearestShifted

U = np.linspace(0.0, 1.0, 120)
RIVALS = {
    "gmr": rivals.TimeRegression(components=10),
    "movement_primitives": rivals.ConditionedPrimitive(weights=10),
    "mp_pytorch": rivals.ProDMP(weights=15),
}


def bow(offset):
    progress = minimum_jerk(U)
    columns = [0.4 * progress, offset * (1.0 - progress) + 0.2 * np.sin(np.pi * progress)]
    return lt.Demonstration(lt.Trajectory(2.0 * U, np.column_stack(columns)))


@pytest.mark.parametrize("library", RIVALS)
def test_rival_predicts_a_demonstration_between_those_shown(library):
    if rivals.LIBRARIES[library] in rivals.MISSING:
        pytest.skip(f"{library} is not installed")
    tested = bow(0.0).motion
    skill = RIVALS[library].fit([bow(x) for x in (-0.06, -0.02, 0.02, 0.06)])
    made = skill.generate(start=tested.positions[0], goal=tested.positions[-1])
    assert made.duration == pytest.approx(2.0)
    np.testing.assert_allclose(made.positions[[0, -1]], tested.positions[[0, -1]], atol=2e-3)
    wanted = np.column_stack([np.interp(made.times, tested.times, x) for x in tested.positions.T])
    assert np.abs(made.positions - wanted).max() < 0.015


def test_columns_of_poses_lead_back_to_the_poses_that_were_shown():
    down = np.tile([0.0, 1.0, 0.0, 0.0], (len(U), 1))
    turned = rotations.compose(rotations.exp(np.outer(U - 1.0, [0.0, 0.5, 2.5])), down)
    shown = lt.PoseTrajectory(U, np.outer(U, [0.1, 0.2, 0.3]), rotations.align_signs(turned))
    skill = rivals.OfPoses(NearestShifted()).fit([lt.Demonstration(shown)])
    start, goal = ((shown.positions[i], shown.orientations[i]) for i in (0, -1))
    made = skill.generate(start=start, goal=goal)
    assert rotations.distance(made.orientations, shown.orientations).max() < 1e-7
    np.testing.assert_allclose(made.positions, shown.positions, atol=1e-12)


def test_simulated_motions_are_the_same_for_the_same_seed():
    first, again = (material.poses("reach by hand", None, 3) for _ in range(2))
    assert len(first) == 6
    assert (first[0].motion.orientations == again[0].motion.orientations).all()
    other = material.course("reach over a box", None, 4)
    assert (
        other[0].motion.positions
        != material.course("reach over a box", None, 5)[0].motion.positions
    ).any()
