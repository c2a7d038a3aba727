import numpy as np
import pytest
from hypothesis import given, strategies as st
from refusals import refused
from scipy.spatial.transform import Rotation

import leadthrough as lt
from leadthrough.errors import InvalidInput

TURN = np.array([0.8, 0.0, 0.6, 0.0])
Q = np.array([0.1, -0.5, 0.2, -2.0, 0.3, 1.6, 0.7])

lengths = st.floats(-0.5, 0.5)
positions = st.tuples(lengths, lengths, lengths)
orientations = st.tuples(lengths, lengths, lengths).map(
    lambda vector: lt.rotations.exp([vector])[0]
)


def matrix(position, orientation):
    w, x, y, z = orientation
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat([x, y, z, w]).as_matrix()
    pose[:3, 3] = position
    return pose


@given(positions, orientations, positions, orientations)
def test_tools_compose(panda, p1, o1, p2, o2):
    arm = panda.with_tool(p1, o1).with_tool(p2, o2)
    expected = matrix(*panda.forward_kinematics(Q)) @ matrix(p1, o1) @ matrix(p2, o2)
    np.testing.assert_allclose(matrix(*arm.forward_kinematics(Q)), expected, atol=1e-12)
    np.testing.assert_allclose(matrix(*arm.tool), matrix(p1, o1) @ matrix(p2, o2), atol=1e-12)


def test_the_jacobian_and_the_inverse_are_those_of_the_moved_tip(panda):
    arm = panda.with_tool((0.1, 0.2, 0.3), TURN)
    position, orientation = arm.forward_kinematics(Q)
    lever = position - panda.forward_kinematics(Q)[0]
    jacobian = panda.jacobian(Q)
    moved = jacobian[:3] + np.cross(jacobian[3:], lever, axis=0)
    np.testing.assert_allclose(arm.jacobian(Q), np.vstack([moved, jacobian[3:]]), atol=1e-12)
    assert arm.inverse_kinematics(position, orientation).success


def test_the_arm_without_a_tool_stays_as_it_was(panda):
    panda.with_tool((0.1, 0.2, 0.3)).with_payload(1.0).with_attached(lt.Sphere(0.1, (0, 0, 0)))
    np.testing.assert_array_equal(panda.tool[0], [0, 0, 0])
    np.testing.assert_array_equal(panda.tool[1], [1, 0, 0, 0])
    assert panda.attached == ()
    with pytest.raises(ValueError, match="read-only"):
        panda.tool[0][0] = 1.0


def test_an_attached_object_stays_on_the_link_when_the_tool_moves(panda):
    box = lt.Box((0.1, 0.2, 0.3), (0.0, 0.0, 0.05), TURN)
    arm = panda.with_tool((0.1, 0.0, 0.2), TURN).with_attached(box).with_tool((0.0, 0.0, 0.4))
    (held,) = arm.attached
    expected = matrix((0.1, 0.0, 0.2), TURN) @ matrix(box.position, box.orientation)
    np.testing.assert_allclose(matrix(held.position, held.orientation), expected, atol=1e-12)
    np.testing.assert_array_equal(held.size, box.size)


def test_an_attached_object_weighs_as_a_solid_body(panda):
    for shape in (
        lt.Box((0.1, 0.25, 0.4), (0.02, 0.03, 0.1), TURN),
        lt.Capsule(0.08, 0.0, (0, 0, 1)),
    ):
        (load,) = panda.with_attached(shape, 2.0).attachment.loads
        center, inertia = shape.unit_inertia()
        assert load.mass == 2.0
        np.testing.assert_allclose(load.center, center, atol=1e-12)
        np.testing.assert_allclose(load.inertia, 2.0 * inertia, atol=1e-12)


def test_a_load_is_what_the_same_pieces_weigh(panda):
    whole = panda.with_payload(2.0, (0.0, 0.0, 0.1), np.diag([0.02, 0.02, 0.0]))
    halves = panda.with_payload(1.0, (0.0, 0.1, 0.1)).with_payload(1.0, (0.0, -0.1, 0.1))
    pieces = np.diag([0.02, 0.0, 0.02])
    same = panda.with_payload(2.0, (0.0, 0.0, 0.1), pieces)
    np.testing.assert_allclose(halves.mass_matrix(Q), same.mass_matrix(Q), atol=1e-12)
    np.testing.assert_allclose(halves.gravity_torques(Q), whole.gravity_torques(Q), atol=1e-12)


BALL = lt.Sphere(0.1, (0, 0, 0))
NO_PLACES = (np.nan, "here", None, (0, 0), [[0], [0, 1]], (0, np.inf, 0))
NO_MASSES = (-1.0, np.nan, np.inf, "heavy", None)
NO_INERTIAS = (
    np.eye(2),
    np.full((3, 3), np.nan),
    np.diag([1.0, 1.0, -1.0]),
    np.diag([1.0, 1.0, 3.0]),
    [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]],
    None,
)


def test_bad_tools_loads_and_shapes_are_refused(panda):
    for method, arguments, wrong, name in [
        ("with_tool", (), NO_PLACES, "position"),
        ("with_tool", ((0, 0, 0),), NO_PLACES, "orientation"),
        ("with_payload", (1.0,), NO_PLACES, "center"),
        ("with_payload", (), NO_MASSES, "mass"),
        ("with_attached", (BALL,), NO_MASSES, "mass"),
        ("with_payload", (1.0, (0, 0, 0)), NO_INERTIAS, "inertia"),
        ("with_attached", (), (None, "box", (0, 0, 0), lt.Box), "shape"),
    ]:
        for bad in wrong:
            refused(name, getattr(panda, method), *arguments, bad)
    with pytest.raises(InvalidInput):
        panda.with_payload(1e308, (1e200, 0, 0)).mass_matrix(Q)
