"""The fastest motion within a tolerance at the tip; the arm stays as clear as it was planned."""

import numpy as np
import pytest
from refusals import refused
from scipy.spatial import cKDTree

import leadthrough as lt
from leadthrough import rotations
from leadthrough.timing import TipTolerance

PANDA = lt.Arm.load("panda")
U = np.linspace(0.0, 1.0, 400)
HOME = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
SHAKEN = (
    HOME
    + 0.3 * np.sin(3.0 * U[:, None] + np.arange(7))
    + 2e-5 * np.sin(np.outer(150.0 * U, np.arange(1, 8)))
)
PATH = lt.JointTrajectory(4.0 * U, SHAKEN, joint_names=PANDA.joint_names)


def tolerance(position, orientation=1e-2):
    return TipTolerance(position, orientation, PANDA.levers)


def test_the_tip_stays_within_the_tolerance_and_more_never_takes_longer():
    durations = [lt.retime(PATH, PANDA.limits, path_tolerance=tolerance(1e-6)).duration]
    fine = np.linspace(0.0, len(U) - 1.0, 40 * len(U))
    between = np.stack([np.interp(fine, np.arange(len(U)), column) for column in SHAKEN.T], axis=1)
    positions, orientations = PANDA.forward_kinematics(between)
    for allowed in (3e-5, 1e-4, 3e-4):
        timed = lt.retime(PATH, PANDA.limits, path_tolerance=tolerance(allowed))
        durations.append(timed.duration)
        found, turned = PANDA.forward_kinematics(timed.positions)
        # The nearest of the points on chords, which lie 2e-6 m off the path.
        away, nearest = cKDTree(positions).query(found)
        assert away.max() < allowed + 2e-5
        assert rotations.distance(turned, orientations[nearest]).max() < 1e-2
    assert (np.diff(durations) <= 1e-3).all()
    assert durations[-1] < 0.8 * durations[0]


def test_the_bound_counts_every_joint_and_the_orientation():
    one = TipTolerance(1e-3, 1e-2, [1.0, 0.5])
    assert one.allows(np.array([[5e-4, 9e-4]]))
    assert not one.allows(np.array([[5e-4, 1.1e-3]]))
    assert not TipTolerance(1.0, 1e-3, [1.0, 0.5]).allows(np.array([[6e-4, 6e-4]]))
    assert TipTolerance(1.0, 1e-3, [1.0, 0.5], [False, True]).allows(np.array([[0.5, 9e-4]]))
    refused("position", TipTolerance, 0.0, 1e-3, [1.0])
    refused("path_tolerance: levers", lt.retime, PATH, PANDA.limits, path_tolerance=one)


@pytest.mark.parametrize("name", ["panda", "ur3", "tiago"])
def test_no_point_up_to_the_tip_moves_by_more_than_the_levers_say(name):
    arm = lt.Arm.load(name)
    rng = np.random.default_rng(0)
    q = rng.uniform(
        np.maximum(arm.limits.lower, -3.0),
        np.minimum(arm.limits.upper, 3.0),
        (200, len(arm.levers)),
    )
    columns = np.linalg.norm(arm.jacobian(q)[:, :3], axis=1)
    assert (columns <= arm.levers + 1e-9).all()


def test_an_arm_that_was_planned_5_mm_clear_is_so_after_retime():
    down = [0.0, 1.0, 0.0, 0.0]
    sweep = np.column_stack([np.full(81, 0.45), np.linspace(-0.2, 0.2, 81), np.full(81, 0.35)])
    motion = lt.PoseTrajectory(np.linspace(0.0, 4.0, 81), sweep, np.tile(down, (81, 1)))
    joints = PANDA.follow(motion)
    timed = lt.retime(joints, PANDA.limits, rate=200, path_tolerance=tolerance(1e-4, 1e-3))
    for centre in ([0.2, 0.45, 0.8], [0.45, -0.5, 0.5], [0.75, 0.0, 0.3], [-0.4, 0.2, 0.7]):
        away = PANDA.check(joints, [lt.Sphere(0.02, centre)]).obstacles.minimum_distance
        # As near as planning comes: the margin and the reserve.
        scene = lt.Scene([lt.Sphere(0.02 + away - 5.2e-3, centre)], margin=0.005)
        assert PANDA.check(joints, scene).obstacles.minimum_distance < 5.3e-3
        assert PANDA.check(timed, scene).ok
