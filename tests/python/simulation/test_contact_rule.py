"""Contacts in simulation are those that collision checks report: the same pairs and tolerance."""

import mujoco
import numpy as np
import pytest

import leadthrough as lt
from leadthrough.simulation import SimulatedArm


@pytest.mark.parametrize("name", ["panda", "ur3", "tiago"])
def test_the_arm_touches_itself_where_a_check_reports_a_collision(name):
    """Shapes that are flush, as those of the Panda's links 5 and 7, do not touch by rounding."""
    arm = lt.Arm.load(name)
    low, high = np.maximum(arm.limits.lower, -3.0), np.minimum(arm.limits.upper, 3.0)
    real = SimulatedArm(arm, 0.5 * (low + high))
    found = []
    for q in np.random.default_rng(0).uniform(low, high, (300, len(low))):
        real.data.qpos[:] = real.plant.coordinates(q)
        mujoco.mj_forward(real.plant.model, real.data)
        report = arm.check(q[None], tolerance=1e-6)
        pairs = {each.bodies for each in real.touches}
        assert bool(pairs) == (not report.ok), (q, pairs, report)
        assert pairs <= set(arm.collision_pairs.checked)
        found.append(bool(pairs))
    assert 0 < sum(found) < len(found)


@pytest.mark.parametrize("kind", [lt.Box, lt.Mesh])
@pytest.mark.parametrize(("depth", "touches"), [(-1e-6, False), (0.5e-6, False), (3e-6, True)])
def test_an_obstacle_is_touched_from_the_overlap_on_at_which_a_check_reports_it(
    kind, depth, touches
):
    """A box is held 0.3 m above the arm's shoulder, and the obstacle beside it."""
    q = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
    free = lt.Arm.load("panda")
    at, turned = free.forward_kinematics(q)
    arm = free.with_attached(lt.Box((0.1, 0.1, 0.1), (0.0, 0.0, 0.1)), mass=0.1)
    rotation = lt.rotations.to_matrix(turned[None])[0]
    beside = at + rotation @ [0.1 - depth, 0.0, 0.1]
    box = lt.Box((0.1, 0.1, 0.1), beside, turned)
    if kind is lt.Mesh:
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.05
        faces = [[0, 1, 3], [0, 3, 2], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4]]
        faces += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 3, 7], [1, 7, 5]]
        box = lt.Mesh(corners, faces, beside, turned)
    assert arm.check(q[None], lt.Scene([box], 0.0), tolerance=1e-6).ok is not touches
    assert bool(SimulatedArm(arm, q, [box]).touches) is touches
