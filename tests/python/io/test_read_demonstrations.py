import numpy as np
import pytest

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
        (".", "expected a file, .* got another folder"),
        ("nul\0byte.csv", "no such file"),
    ],
)
def test_paths_that_name_no_recording_are_refused(tmp_path, monkeypatch, paths, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "recording.xlsx").write_text("t,x,y\n0,1,2\n")
    with pytest.raises(InvalidInput, match=message):
        lt.read_demonstrations(paths)


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


def test_real_matlab_demonstrations_are_six_of_one_symbol(recordings):
    demonstrations = lt.read_demonstrations(recordings / "panda_symbol" / "symbol17.mat", rate=500)
    assert [d.name for d in demonstrations] == [f"symbol17[{i}]" for i in range(6)]
    assert [len(d.motion.times) for d in demonstrations] == [5520, 5471, 8647, 9637, 17703, 15523]
    assert all(d.motion.positions.shape[1] == 3 for d in demonstrations)
