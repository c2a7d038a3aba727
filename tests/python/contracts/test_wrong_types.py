"""A wrong type, or a value that nothing can be made of, is refused by name in every part."""

import numpy as np
import pytest
from motions import arm, minimum_jerk, reach
from refusals import refused

import leadthrough as lt
from leadthrough import arm as arms, trajectories
from leadthrough.errors import FitError, IkFailure, InvalidInput, LimitsInfeasible

LINE = lt.Trajectory(np.linspace(0.0, 1.0, 50), np.outer(np.linspace(0.0, 1.0, 50), [1.0, 0.5]))
TURNS = lt.rotations.exp([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
REST = np.array([0.0, -1.6, 1.9, -1.9, -1.6, 0.0])


def test_what_is_no_path_is_named():
    refused("path: expected a path, got 3", lt.read_point_cloud, 3, radius=0.01)
    refused("path: expected a path, got None", lt.read_mesh, None)


def test_what_is_no_arm_is_named():
    refused("arm: expected an Arm, got None", arms.TaskStack, None, [])
    refused("arm: expected an Arm, got None", lt.DifferentialIk, None)


@pytest.mark.parametrize("model", [lt.DMP(weights=10), lt.RhythmicDMP(weights=10)])
def test_what_is_no_state_is_named(model):
    refused("state: expected one from begin or step, got str", model.fit([LINE]).step, "x", 0.01)


@pytest.mark.parametrize(
    "curve",
    [
        trajectories.Bezier([[0.0, 0.0], [1.0, 1.0]]),
        trajectories.Lagrange([0.0, 1.0], [[0.0], [1.0]]),
        trajectories.Spline([0.0, 1.0], np.ones((1, 2, 1))),
        trajectories.Slerp([0.0, 1.0], TURNS),
    ],
)
def test_ragged_times_of_a_curve_are_refused(curve):
    refused("t: expected a regular array", curve.evaluate, [[1, 2, 3], [4, 5]])


def test_times_whose_rates_overflow_are_refused():
    refused(
        "times: expected steps of at least 1e-60 s",
        lt.JointTrajectory,
        [0.0, 1e-300, 2e-300],
        [[0.0], [1.0], [2.0]],
    )


def test_a_fast_marching_file_with_an_empty_path_is_refused(tmp_path):
    lt.FastMarching().fit([LINE]).save(tmp_path / "skill.npz")
    with np.load(tmp_path / "skill.npz") as file:
        np.savez(tmp_path / "empty.npz", **{**file, "path_0": np.empty((0, 2))})
    with pytest.raises(InvalidInput, match="path"):
        lt.load_skill(tmp_path / "empty.npz")


def test_a_motion_smaller_than_squares_can_hold_is_refused():
    with pytest.raises(FitError, match="use another unit"):
        lt.FastMarching().fit([lt.Trajectory(LINE.times, 1e-160 * LINE.positions)])


def test_a_folder_of_recordings_is_read_whole(tmp_path):
    for number in range(3):
        lt.write_motion(reach("poses", number), tmp_path / f"reach{number}.csv")
    (tmp_path / "notes.pdf").write_text("nothing to read")
    found = lt.read_demonstrations(tmp_path)
    assert [each.name for each in found] == ["reach0", "reach1", "reach2"]
    (tmp_path / "empty").mkdir()
    refused("nothing to read in this folder", lt.read_demonstrations, tmp_path / "empty")


def test_joints_in_degrees_are_asked_for():
    ur3 = arm("ur3")
    moved = np.degrees(REST + np.outer([0.0, 1.0], [0.1, 0.2, 0.1, 0.0, 0.1, 0.0]))
    with pytest.raises(LimitsInfeasible, match=r"degrees\?"):
        lt.retime(moved, ur3.limits)
    with pytest.warns(UserWarning, match=r"degrees\?"):
        ur3.check(moved)


def test_a_start_without_room_is_reported_of_an_arm_with_an_endless_joint():
    ur3, times = arm("ur3"), np.linspace(0.0, 2.0, 40)
    q = REST + np.outer(minimum_jerk(times / 2.0), [0.6, 0.2, -0.3, 0.25, 0.15, 0.8])
    tip = ur3.poses(lt.JointTrajectory(times, q))
    shown = lt.PoseTrajectory(times, tip.positions, tip.orientations)
    skill = lt.ProMP(weights=5).fit([shown])
    assert not np.isfinite(ur3.limits.upper).all()
    with pytest.raises(IkFailure, match="no collision-free configuration found at the start"):
        lt.plan_motion(skill, ur3, [lt.Sphere(0.05, tip.positions[0])])
