"""Reached poses are those of forward kinematics; an arm at a found base runs the motion."""

import numpy as np
import pytest
from cli.command_line import facts
from refusals import refused

import leadthrough as lt
from leadthrough.reachability import place_base, reach_map, spread_orientations
from leadthrough.reachability.reach_map import reached
from leadthrough.tasks import Execution
from leadthrough.validation import TargetRegion


@pytest.fixture(scope="module")
def poses(panda):
    phase = np.linspace(0.0, 1.0, 21)[:, None]
    home = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
    rows = home + phase * [0.5, 0.3, 0.0, 0.3, 0.0, 0.1, 0.2]
    shown = panda.poses(lt.JointTrajectory(2.0 * phase[:, 0], rows))
    return lt.PoseTrajectory(shown.times, shown.positions, shown.orientations)


def test_orientations_are_spread_evenly():
    turned = spread_orientations(200)
    assert np.linalg.norm(turned, axis=1) == pytest.approx(1.0)
    near = np.abs(turned @ turned.T) - 2.0 * np.eye(200)
    nearest = 2.0 * np.arccos(np.clip(near.max(axis=1), 0.0, 1.0))
    # The ball of rotations has the volume 8 pi^2; each has as much of it for itself.
    radius = (3.0 * 8.0 * np.pi**2 / (4.0 * np.pi * 200)) ** (1.0 / 3.0)
    assert 0.5 * radius < nearest.min() and nearest.max() < 2.0 * radius


def test_poses_of_clear_configurations_are_reached_and_others_are_not(panda):
    rng = np.random.default_rng(0)
    q = rng.uniform(panda.limits.lower, panda.limits.upper, (300, 7))
    q = q[panda.is_clear(q)]
    positions, orientations = panda.forward_kinematics(q)
    found, joints = reached(panda, positions, orientations, lt.Scene(), 0)
    assert found.mean() > 0.97
    there, _ = panda.forward_kinematics(joints[found])
    assert np.linalg.norm(there - positions[found], axis=1).max() < 2e-4
    assert panda.is_clear(joints[found]).all()
    wall = lt.Box((0.1, 4.0, 4.0), (-0.3, 0.0, 0.0))
    behind = positions[:, 0] < -0.45
    assert not reached(
        panda, positions[behind], orientations[behind], lt.Scene([wall], margin=0.0), 0
    )[0].any()


def test_a_map_is_the_same_on_processes_and_ends_at_the_reach(panda, tmp_path):
    asked = {"volume": TargetRegion([0.0, -1.2, 0.0], [1.2, 1.2, 0.4]), "spacing": 0.4}
    half = reach_map(panda, **asked)
    same = reach_map(panda, **asked, execution=Execution("local:1"))
    assert (half.fraction == same.fraction).all()
    assert (half.manipulability == same.manipulability).all()
    places = np.stack(np.meshgrid(*half.axes, indexing="ij"), axis=-1)
    away = np.linalg.norm(places - [0.0, 0.0, 0.333], axis=-1)  # of the shoulder
    assert (half.fraction[away > 0.96] == 0.0).all()
    assert (half.fraction[(away > 0.35) & (away < 0.6)] > 0.3).all()
    assert ((half.manipulability > 0.0) == (half.fraction > 0.0)).all()
    half.save(tmp_path / "map.npz")
    with np.load(tmp_path / "map.npz") as saved:
        assert (saved["fraction"] == half.fraction).all()


def test_the_arm_runs_the_motion_from_where_it_is_to_stand(panda, poses):
    area = TargetRegion([-0.5, 0.0, 0.0], [1.0, 0.5, 0.0])
    found = place_base(poses, panda, area=area, spacing=0.5, yaws=4)
    assert len(found.bases) == 4 * 2 * 4
    home = np.flatnonzero((found.bases == 0.0).all(axis=1))
    assert found.fraction[home] == 1.0  # the demonstrated base
    x, y, _, yaw = found.best
    tips = panda.poses(found.joints)
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    flat = tips.positions[:, :2] @ turn.T + [x, y]
    assert np.abs(flat[[0, -1]] - poses.positions[[0, -1], :2]).max() < 1e-4
    far = place_base(poses, panda, area=TargetRegion([3.0, 0.0, 0.0], [3.0, 0.0, 0.0]), yaws=1)
    assert far.best is None and far.fraction.tolist() == [0.0]


def test_a_joint_that_turns_without_end_is_drawn_from_a_turn():
    ur3 = lt.Arm.load("ur3")
    assert np.isinf(ur3.limits.upper).any()
    found = reach_map(ur3, spacing=0.5, orientations=2)
    assert 0.0 < found.fraction.mean() < 0.5


def test_too_fine_a_grid_is_refused(panda):
    refused("spacing", reach_map, panda, spacing=0.001)


def test_the_command_writes_a_map_and_a_picture(poses, tmp_path):
    out = tmp_path / "reach.npz"
    volume = ("--volume", "0.3,0,0.3:0.7,0,0.7", "--spacing", 0.2, "--orientations", 4)
    found = facts("reach", "--robot", "panda", *volume, "-o", out)
    assert found["places"] == 9 and found["reached"] > 5
    assert out.with_suffix(".png").read_bytes().startswith(b"\x89PNG")
    skill = tmp_path / "skill.npz"
    lt.DMP(weights=10).fit([poses]).save(skill)
    words = ("--skill", skill, "--area", "0,0,0:0,0,0", "--yaws", 1, "-o", tmp_path / "stand.npz")
    assert facts("reach", "--robot", "panda", *words)["best_base"] == [0.0, 0.0, 0.0]
    far = ("--skill", skill, "--area", "3,0,0:3,0,0", "-o", tmp_path / "stand.npz")
    assert facts("reach", "--robot", "panda", *far, code=1)["best_base"] is None
