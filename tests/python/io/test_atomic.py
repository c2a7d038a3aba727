"""Files that are written appear whole or not at all, in the place of a file and of nothing else."""

import json
import os
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.io.files import replacing

SUFFIXES = ("csv", "npz", "json", "yaml", "mcap", "db3", "script")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_link_stays_one_and_its_target_is_written(tmp_path, ur_motion, suffix):
    target, link = tmp_path / "deep" / "target", tmp_path / f"link.{suffix}"
    target.parent.mkdir()
    target.write_bytes(b"before")
    target.chmod(0o640)
    link.symlink_to(target)
    lt.write_motion(ur_motion, link)
    assert link.is_symlink()
    assert target.read_bytes() != b"before"
    assert stat.S_IMODE(target.stat().st_mode) == 0o640
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["deep", f"link.{suffix}", "target"]


def test_a_link_to_nothing_makes_its_target(tmp_path, ur_motion):
    (tmp_path / "link.csv").symlink_to(tmp_path / "new.csv")
    lt.write_motion(ur_motion, tmp_path / "link.csv")
    assert (tmp_path / "new.csv").is_file()
    assert (tmp_path / "link.csv").is_symlink()


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_pipe_is_not_replaced(tmp_path, ur_motion, suffix):
    pipe = tmp_path / f"pipe.{suffix}"
    os.mkfifo(pipe)
    refused(r"cannot be written: it is a device, pipe or socket", lt.write_motion, ur_motion, pipe)
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert list(tmp_path.iterdir()) == [pipe]


def test_a_device_is_not_replaced(ur_motion):
    refused("device", lt.write_motion, ur_motion, "/dev/null", format="csv")
    assert stat.S_ISCHR(Path("/dev/null").stat().st_mode)


@pytest.mark.parametrize(
    "path", ["a\0b.csv", "a" * 300 + ".csv", "x" * 5000 + "/a.csv", 3, None, b"a.csv"]
)
def test_paths_that_no_file_can_have_are_refused(tmp_path, monkeypatch, ur_motion, path):
    monkeypatch.chdir(tmp_path)
    refused("path", lt.write_motion, ur_motion, path)
    with pytest.raises(InvalidInput):
        lt.read_demonstrations(path)
    with pytest.raises(InvalidInput):
        lt.Arm.from_urdf(path)
    with pytest.raises(InvalidInput):
        lt.load_skill(path)
    with pytest.raises(InvalidInput, match="path"), replacing(path) as temporary:
        temporary.touch()
    refused("path", lt.write_motion, ur_motion, path, format="rosbag")
    assert list(tmp_path.iterdir()) == []


def test_links_that_lead_in_a_circle_are_refused(tmp_path, ur_motion):
    (tmp_path / "a.csv").symlink_to(tmp_path / "b.csv")
    (tmp_path / "b.csv").symlink_to(tmp_path / "a.csv")
    refused("path", lt.write_motion, ur_motion, tmp_path / "a.csv")


FULL_DISK = """
import json, resource, signal, sys
from pathlib import Path
import numpy as np
import leadthrough as lt
from leadthrough.io import rosbag
folder, suffixes = Path(sys.argv[1]), sys.argv[2:]
times = np.linspace(0.0, 1.0, 2001)
shape = 10 * times**3 - 15 * times**4 + 6 * times**5
rate = 30 * times**2 - 60 * times**3 + 30 * times**4
names = [f"{part}_joint" for part in
         ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")]
motion = lt.JointTrajectory(times, np.outer(shape, np.ones(6)), np.outer(rate, np.ones(6)),
                            joint_names=names)
skill = lt.ProMP().fit([lt.Demonstration(motion)] * 3)
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (8192, 8192))
told = {}
for suffix in suffixes:
    try:
        if suffix == "skill":
            skill.save(folder / "motion.skill")
        elif suffix == "db3":
            rosbag.write_joint_states(motion, folder / "motion.db3")
        else:
            lt.write_motion(motion, folder / f"motion.{suffix}")
        told[suffix] = "written"
    except Exception as error:
        told[suffix] = f"{type(error).__name__}: {error}"
print(json.dumps(told))
"""


def test_a_full_disk_leaves_what_was_there(tmp_path):
    suffixes = ("csv", "npz", "json", "yaml", "mcap", "db3", "skill")
    for suffix in suffixes:
        (tmp_path / f"motion.{suffix}").write_text("before")
    command = [sys.executable, "-c", FULL_DISK, str(tmp_path), *suffixes]
    run = subprocess.run(command, capture_output=True, text=True, check=True)
    told = json.loads(run.stdout)
    assert all(
        each.startswith("InvalidInput: path: ") and "cannot be written" in each
        for each in told.values()
    ), told
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        f"motion.{suffix}" for suffix in suffixes
    )
    assert {path.read_text() for path in tmp_path.iterdir()} == {"before"}


WITHOUT_END = """
import itertools, sys
from pathlib import Path
import numpy as np
import leadthrough as lt
from leadthrough.io import rosbag
folder = Path(sys.argv[1])
times = np.linspace(0.0, 1.0, 301)
for i in itertools.count(1):
    names = ("joint_1", "joint_2")
    motion = lt.JointTrajectory(times, np.full((301, 2), float(i)), joint_names=names)
    lt.write_motion(motion, folder / "motion.csv")
    lt.write_motion(motion, folder / "motion.npz")
    rosbag.write_joint_states(motion, folder / "motion.mcap")
    rosbag.write_joint_states(motion, folder / "motion.db3")
    print(i, flush=True)
"""


@pytest.mark.parametrize("later", [0.0, 0.05, 0.1])
def test_a_program_that_is_killed_leaves_whole_files(tmp_path, later):
    command = [sys.executable, "-c", WITHOUT_END, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        process.stdout.readline()
        time.sleep(later)
        process.send_signal(signal.SIGKILL)
    for suffix in ("csv", "npz", "mcap", "db3"):
        found = lt.read_motion(tmp_path / f"motion.{suffix}")
        assert len(found.times) == 301
        assert len(np.unique(found.positions)) == 1


@pytest.fixture
def synced(monkeypatch):
    """The files and folders that are brought onto the disk, and what was in their folder then."""
    found = []

    def sync(number):
        path = Path(f"/proc/self/fd/{number}").readlink()
        found.append((path, {each.name for each in path.parent.iterdir()}))

    monkeypatch.setattr(os, "fsync", sync)
    return found


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_is_on_the_disk_before_it_takes_its_name(tmp_path, ur_motion, synced, suffix):
    lt.write_motion(ur_motion, tmp_path / f"motion.{suffix}")
    (file, beside), (folder, _) = synced[-2:]
    assert file.parent == tmp_path
    assert f"motion.{suffix}" not in beside
    assert folder == tmp_path  # its new name
    (tmp_path / "plain").touch()
    modes = {stat.S_IMODE(path.stat().st_mode) for path in tmp_path.iterdir()}
    assert len(modes) == 1


def test_a_bag_s_folder_is_on_the_disk_before_it_takes_its_name(tmp_path, ur_motion, synced):
    lt.write_motion(ur_motion, tmp_path / "bag", format="rosbag")
    written = {path.name for path in (tmp_path / "bag").iterdir()}
    assert written <= {path.name for path, _ in synced[:-2]}
    folder, beside = synced[-2]
    assert folder.parent == tmp_path
    assert "bag" not in beside
    assert synced[-1][0] == tmp_path


def test_what_a_killed_writer_left_is_cleared_by_the_next(tmp_path):
    killed = """
import os, signal, sys
from leadthrough.io.files import making_folder, replacing
with replacing("a.csv") as file, making_folder("b") as folder:
    file.write_text("half")
    folder.mkdir()
    os.kill(os.getpid(), signal.SIGKILL)
"""
    subprocess.run([sys.executable, "-c", killed], cwd=tmp_path, check=False)
    other = tmp_path / ".leadthrough-0123456789ab-1-other"
    other.write_text("of another computer")
    assert len(list(tmp_path.iterdir())) == 3
    with replacing(tmp_path / "own.csv") as own:
        own.write_text("whole")
        with replacing(tmp_path / "next.csv") as file:
            file.write_text("whole")
    left = sorted(path.name for path in tmp_path.iterdir())
    assert left == [other.name, "next.csv", "own.csv"]
