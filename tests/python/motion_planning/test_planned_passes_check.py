"""Planned motions pass a check with the same scene, before and after the time law."""

import numpy as np
import pytest

import leadthrough as lt

# Configuration, length of the sweep and offset of the obstacle from its middle, m.
STARTS = {
    "panda": ([0.0, -0.5, 0.0, -2.2, 0.0, 1.8, 0.8], 0.35, (0.0, 0.0, 0.07)),
    "ur3": ([0.0, -1.2, 1.4, -1.7, -1.5, 0.3], 0.25, (0.08, 0.0, 0.0)),
    "tiago": ([0.15, 0.6, 0.2, -1.0, 1.4, 0.0, 0.3, 0.0], 0.2, (0.0, 0.0, 0.07)),
}
SHAPES = {
    "sphere": lambda middle: [lt.Sphere(0.04, middle)],
    "boxes": lambda middle: [
        lt.Box((0.06, 0.06, 0.06), middle),
        lt.Box((0.1, 0.1, 0.1), np.add(middle, (0.0, 0.0, 0.3))),
    ],
    "cloud": lambda middle: [
        lt.PointCloud(0.02 * np.random.default_rng(0).normal(size=(50, 3)) + middle, 0.01)
    ],
}


def sweep(arm, name):
    """A motion of the tip, sideways along y."""
    q, reach, _ = STARTS[name]
    position, orientation = arm.forward_kinematics(np.array(q))
    phase = np.linspace(0.0, 1.0, 41)
    rise = lt.trajectories.minimum_jerk_time_scaling(phase)[:, None]
    line = position + (rise - 0.5) * [0.0, reach, 0.0]
    return lt.PoseTrajectory(3.0 * phase, line, np.tile(orientation, (41, 1))), np.array(q)


@pytest.mark.parametrize("margin", [0.0, 0.005, 0.01])
@pytest.mark.parametrize("shapes", SHAPES)
@pytest.mark.parametrize("name", STARTS)
def test_planned_motion_passes_check_with_same_scene(name, shapes, margin):
    arm = lt.Arm.load(name)
    motion, q0 = sweep(arm, name)
    beside = motion.positions[20] + STARTS[name][2]
    scene = lt.Scene(SHAPES[shapes](beside), margin)
    skill = lt.DMP().fit([motion])
    joints = lt.plan_motion(skill, arm, scene, lt.Query(dt=0.05), q0=q0).joints
    assert arm.check(joints, scene).ok
    assert arm.check(joints, scene, tolerance=1e-4).ok
    timed = lt.retime(joints, arm.limits, rate=250.0)
    report = arm.check(timed, scene)
    assert report.ok, str(report)
