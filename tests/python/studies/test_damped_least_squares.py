"""The plain damped least squares of Yang et al., for poses and along paths."""

import numpy as np
from motions import minimum_jerk
from refusals import refused

import leadthrough as lt
from leadthrough_studies.damped_least_squares import (
    DampedLeastSquares,
    damped_inverse_kinematics,
    follow_path,
)

PANDA = lt.Arm.load("panda")
UR3 = lt.Arm.load("ur3")
READY = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
TIMES = np.linspace(0.0, 3.0, 301)


def outwards(distance):
    """A straight motion of the Panda's tool away from the base, from rest to rest."""
    position, orientation = PANDA.forward_kinematics(READY)
    s = TIMES / TIMES[-1]
    way = distance * minimum_jerk(s)
    positions = position + way[:, None] * np.array([1.0, 0.0, 0.0])
    return lt.PoseTrajectory(TIMES, positions, np.tile(orientation, (len(s), 1)))


def speeds(path):
    return np.abs(np.diff(path.joints.positions, axis=0)) / np.diff(TIMES)[:, None]


def test_a_comfortable_path_is_followed_with_any_damping():
    motion = outwards(0.05)
    for damping in (0.0, 0.1):
        path = follow_path(PANDA, motion, q0=READY, settings=DampedLeastSquares(damping))
        reached, _ = PANDA.forward_kinematics(path.joints.positions)
        errors = np.linalg.norm(reached - motion.positions, axis=1)
        np.testing.assert_allclose(path.position_error, errors, atol=1e-12)
        assert errors.max() < 1e-4
        assert (path.damping == 0).all()


def test_the_settings_are_by_default_those_that_the_reference_prints():
    assert DampedLeastSquares() == DampedLeastSquares(0.1, 0.0, 10.0, 0.5, 0.3)


def test_each_step_tells_its_condition_and_damping():
    settings = DampedLeastSquares(damping=0.05, condition_threshold=5.0)
    path = follow_path(PANDA, outwards(0.3), q0=READY, settings=settings)
    before = np.vstack([READY, path.joints.positions[:-1]])
    np.testing.assert_allclose(path.condition, PANDA.condition_number(before), rtol=1e-6)
    share = np.minimum(5.0 / path.condition, 1.0)
    np.testing.assert_allclose(path.damping, 0.05 * np.sqrt(1 - share**2), atol=1e-9)
    assert path.condition.min() < 5 < path.condition.max()


def test_damping_calms_the_joints_beside_a_singularity_and_leaves_the_path():
    motion = outwards(0.45)  # beyond the stretched arm
    plain, damped = (
        follow_path(PANDA, motion, q0=READY, settings=DampedLeastSquares(damping))
        for damping in (0.0, 0.1)
    )
    assert speeds(plain).max() > 10 * speeds(damped).max()
    assert damped.position_error.max() > 1e-3
    assert (damped.joints.positions >= PANDA.limits.lower).all()
    assert (damped.joints.positions <= PANDA.limits.upper).all()


def test_the_null_space_pulls_to_the_middle_and_leaves_the_tool():
    motion = outwards(0.0)
    path = follow_path(PANDA, motion, q0=READY, settings=DampedLeastSquares(nullspace_gain=0.5))
    middle = 0.5 * (PANDA.limits.lower + PANDA.limits.upper)
    away = np.linalg.norm(path.joints.positions - middle, axis=1)
    assert away[-1] < away[0] - 0.01
    assert path.position_error.max() < 1e-5


def test_points_leave_the_orientation_free():
    poses = outwards(0.05)
    path = follow_path(PANDA, lt.Trajectory(TIMES, poses.positions), q0=READY)
    assert path.position_error.max() < 1e-4
    assert (path.orientation_error == 0).all()


def test_poses_nearby_are_reached_by_steps_alone():
    rng = np.random.default_rng(1)
    q = np.array([0.1, -1.2, 1.4, -1.7, -1.5, 0.3]) + rng.uniform(-0.2, 0.2, (50, 6))
    targets = UR3.forward_kinematics(q)
    batch = damped_inverse_kinematics(
        UR3,
        *targets,
        q0=[0.1, -1.2, 1.4, -1.7, -1.5, 0.3],
        settings=DampedLeastSquares(condition_threshold=100.0),
    )
    assert batch.success.all()
    np.testing.assert_allclose(UR3.forward_kinematics(batch.q)[0], targets[0], atol=1e-5)


def test_positions_alone_are_reached_too():
    position, _ = PANDA.forward_kinematics(READY)
    result = damped_inverse_kinematics(PANDA, [position], max_iterations=500)
    assert result.success.all()
    assert result.orientation_error == 0.0


def test_bad_settings_motions_and_starts_are_refused():
    for numbers in (
        {"damping": -1.0},
        {"alpha": np.nan},
        {"condition_threshold": 0.5},
        {"nullspace_gain": np.inf},
        {"rotation_weight": 0.0},
    ):
        refused(next(iter(numbers)), DampedLeastSquares, **numbers)
    for motion in ("circle", lt.Trajectory([0.0, 1.0], [[0, 0], [1, 1]])):
        refused("motion", follow_path, PANDA, motion, q0=READY)
    refused("q0", follow_path, PANDA, outwards(0.1), q0=READY[:3])
    refused("settings", follow_path, PANDA, outwards(0.1), q0=READY, settings=0.1)
    refused("settings", damped_inverse_kinematics, PANDA, [[0.3, 0.0, 0.3]], settings={})
