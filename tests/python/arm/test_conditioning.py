import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import leadthrough as lt
from leadthrough.errors import InvalidInput

PANDA = lt.Arm.load("panda")
angles = st.lists(st.floats(-3.0, 3.0), min_size=7, max_size=7)


def test_manipulability_is_the_volume_of_the_velocities(arm, posture):
    jacobian = arm.jacobian(posture)
    volume = np.sqrt(np.linalg.det(jacobian @ jacobian.T))
    np.testing.assert_allclose(arm.manipulability(posture), volume, rtol=1e-9)


def test_the_condition_number_weighs_rotations(arm, posture):
    jacobian = arm.jacobian(posture)
    weighted = np.diag([1, 1, 1, 0.3, 0.3, 0.3]) @ jacobian
    np.testing.assert_allclose(arm.condition_number(posture), np.linalg.cond(weighted))
    np.testing.assert_allclose(
        arm.condition_number(posture, rotation_weight=1.0), np.linalg.cond(jacobian)
    )


@given(angles)
def test_both_hold_at_any_configuration(q):
    assert PANDA.manipulability(q) >= 0.0
    assert PANDA.condition_number(q) >= 1.0


def test_at_a_singularity_the_one_is_zero_and_the_other_infinite():
    ur3 = lt.Arm.load("ur3")
    straight = [0.3, -1.0, 0.0, -0.4, 0.0, 0.2]  # elbow stretched, wrist aligned
    assert ur3.manipulability(straight) < 1e-15
    assert ur3.condition_number(straight) == np.inf


def test_an_arm_of_one_joint_is_as_well_conditioned_as_can_be():
    document = (
        '<robot name="one"><link name="a"/><link name="b"/><joint name="j" type="continuous">'
        '<parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint></robot>'
    )
    one = lt.Arm.from_urdf(document)
    assert one.condition_number([0.2]) == 1.0
    assert one.manipulability([0.2]) == 1.0


def test_batches_are_their_rows(arm, random_configurations):
    q = random_configurations(arm, 5, 1)
    np.testing.assert_allclose(
        arm.condition_number(q), [arm.condition_number(row) for row in q], rtol=1e-9
    )
    np.testing.assert_allclose(
        arm.manipulability(q), [arm.manipulability(row) for row in q], rtol=1e-9
    )
    assert arm.condition_number(q[:0]).shape == (0,)


@pytest.mark.parametrize("weight", [0.0, -1.0, np.nan, np.inf, "heavy", None])
def test_a_weight_that_is_none_is_refused(arm, posture, weight):
    with pytest.raises(InvalidInput):
        arm.condition_number(posture, rotation_weight=weight)


@pytest.mark.parametrize("bad", [np.zeros(3), "q", None, [[1.0], [1.0, 2.0]], np.nan])
def test_a_wrong_configuration_is_refused(arm, bad):
    for measure in (arm.condition_number, arm.manipulability):
        with pytest.raises(InvalidInput, match="q: "):
            measure(bad)
