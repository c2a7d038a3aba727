import math

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput

PANDA_JOINTS = [f"joint_{i}" for i in range(1, 8)]
PANDA_POSE = {
    "positions": [f"current_pos_{axis}" for axis in "xyz"],
    "orientations": [f"current_orientation_{axis}" for axis in "wxyz"],
}


def test_several_files_keep_their_order_and_names(tmp_path):
    paths = [tmp_path / name for name in ("second.csv", "first.csv")]
    for i, path in enumerate(paths):
        path.write_text(f"t,x,y\n0,{i},0\n")
    demonstrations = lt.read_demonstrations([paths[0], str(paths[1])])
    assert [d.name for d in demonstrations] == ["second", "first"]
    assert [d.motion.positions[0, 0] for d in demonstrations] == [0, 1]


@pytest.mark.parametrize(
    ("paths", "message"),
    [
        ([], "paths: expected at least one path"),
        (None, "paths: expected a path"),
        (3, "paths: expected a path"),
        ([3], "paths: expected a path"),
        ("missing.csv", "missing.csv: no such file"),
        ("*.csv", r"\*.csv: no such file"),
        ("recording.xlsx", r"expected .csv, .* or .parquet, got '.xlsx'"),
        (".", "nothing to read in this folder"),
        ("nul\0byte.csv", "no such file"),
    ],
)
def test_paths_that_name_no_recording_are_refused(tmp_path, monkeypatch, paths, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "recording.xlsx").write_text("t,x,y\n0,1,2\n")
    refused(message, lt.read_demonstrations, paths)


def test_a_real_pose_recording_turns_by_half_a_turn_without_a_jump(recordings):
    path = recordings / "panda_execution" / "trial1.csv"
    (demonstration,) = lt.read_demonstrations(path, columns=PANDA_POSE, rate=20)
    motion = demonstration.motion
    assert type(motion) is lt.PoseTrajectory
    assert motion.duration == pytest.approx(285, abs=10)
    steps = np.diff(motion.orientations, axis=0)
    assert np.linalg.norm(steps, axis=1).max() < 0.2
    first = np.repeat(motion.orientations[:1], len(motion.times), axis=0)
    assert lt.rotations.distance(first, motion.orientations).max() > np.pi - 1e-4


def test_a_real_joint_recording_keeps_its_joints(recordings):
    path = recordings / "panda_execution" / "trial2.csv"
    (demonstration,) = lt.read_demonstrations(path, columns={"joints": PANDA_JOINTS}, rate=20)
    assert demonstration.motion.joint_names == tuple(PANDA_JOINTS)
    assert np.abs(demonstration.motion.positions).max() < 3.8


def test_a_real_recording_of_poses_and_joints_needs_a_choice(recordings):
    with pytest.raises(InvalidInput, match="both poses and joints"):
        lt.read_demonstrations(recordings / "panda_execution" / "trial1.csv", rate=20)


def reach(*, noise=0.0):
    """A reach of 2.5 s between rests of 0.8 and 0.9 s, with an event in each rest."""
    times = np.arange(0.0, 4.2, 0.01)
    rise = lt.trajectories.minimum_jerk_time_scaling(np.clip((times - 0.8) / 2.5, 0.0, 1.0))
    q = np.outer(rise, [0.3, -0.2, 0.5, 0.1, 0.4, 0.2])
    q += np.random.default_rng(3).normal(0.0, noise, q.shape)
    names = [f"joint_{i}" for i in range(1, 7)]
    happened = [lt.Event(0.1, "open"), lt.Event(4.0, "close")]
    return lt.JointTrajectory(times, q, joint_names=names, events=happened)


@pytest.mark.parametrize("noise", [0.0, 5e-4])
@pytest.mark.parametrize("file", ["shown.csv", "shown.npz"])
def test_standing_still_before_and_after_is_left_out(tmp_path, file, noise):
    whole = reach(noise=noise)
    lt.write_motion(whole, tmp_path / file)
    (shown,) = lt.read_demonstrations(tmp_path / file)
    motion = shown.motion
    assert shown.name == "shown"
    assert motion.times[[0, -1]] == pytest.approx([0.8, 3.3], abs=0.12)  # as recorded
    kept = np.isin(whole.times, motion.times)
    assert np.array_equal(motion.positions, whole.positions[kept])
    assert [event.name for event in motion.events] == ["open", "close"]
    learned = lt.DMP().fit([shown]).generate()
    speeds = np.linalg.norm(np.diff(learned.positions, axis=0), axis=1)
    assert (speeds < 0.01 * speeds.max()).sum() * 0.01 < 0.2  # 1.7 s of 4.2 s without


def test_standing_still_is_kept_on_demand_and_by_motions(tmp_path):
    whole = reach()
    lt.write_motion(whole, tmp_path / "shown.csv")
    (some,) = lt.read_demonstrations(tmp_path / "shown.csv", rest=0.3)
    assert some.motion.times[[0, -1]] == pytest.approx([0.5, 3.6], abs=0.12)
    (shown,) = lt.read_demonstrations(tmp_path / "shown.csv", rest=math.inf)
    for found in (shown.motion, lt.read_motion(tmp_path / "shown.csv")):
        assert np.array_equal(found.times, whole.times)
        assert np.array_equal(found.positions, whole.positions)
        assert found.events == whole.events
    refused("rest: ", lt.read_demonstrations, tmp_path / "shown.csv", rest=-1.0)


def test_a_motion_is_the_only_one_in_its_file(tmp_path, recordings):
    with pytest.raises(InvalidInput, match=r"symbol17.mat: .* one motion, got 6"):
        lt.read_motion(recordings / "panda_symbol" / "symbol17.mat", rate=500)
    for path in (["a.csv"], None, 3):
        refused("path: expected the path of one file", lt.read_motion, path)
    refused(r"missing.csv: no such file", lt.read_motion, tmp_path / "missing.csv")


def test_real_matlab_demonstrations_are_six_of_one_symbol(recordings):
    path = recordings / "panda_symbol" / "symbol17.mat"
    demonstrations = lt.read_demonstrations(path, rate=500, rest=math.inf)
    assert [d.name for d in demonstrations] == [f"symbol17[{i}]" for i in range(6)]
    assert [len(d.motion.times) for d in demonstrations] == [5520, 5471, 8647, 9637, 17703, 15523]
    assert all(d.motion.positions.shape[1] == 3 for d in demonstrations)
