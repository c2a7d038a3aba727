"""Files with flipped bytes, cut off or of another kind: a reader reads them or says what is wrong.

The flips are drawn from a fixed seed; any other exception than InvalidInput is a bug.
"""

import shutil
import struct
import zipfile

import h5py
import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from scipy.io import savemat

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.io import bounds, rosbag_writer

SUFFIXES = ("csv", "npz", "mat", "json", "yaml", "mcap", "db3", "hdf5", "parquet")
ROUNDS = 60
OPTIONS = {"hdf5": {"columns": {"joints": ["robot0_joint_pos"]}, "rate": 20.0}}


@pytest.fixture(scope="module")
def whole(tmp_path_factory, ur_motion):
    """A folder with a good file of each format."""
    folder = tmp_path_factory.mktemp("whole")
    for suffix in ("csv", "npz", "json", "yaml"):
        lt.write_motion(ur_motion, folder / f"motion.{suffix}")
    for suffix in ("mcap", "db3"):
        rosbag_writer.write_joint_states(ur_motion, folder / f"motion.{suffix}")
    savemat(folder / "motion.mat", {"t": ur_motion.times, "pos": ur_motion.positions[:, :3]})
    with h5py.File(folder / "motion.hdf5", "w") as file:
        file["data/demo_0/obs/robot0_joint_pos"] = ur_motion.positions
    table = {
        "timestamp": ur_motion.times,
        "observation.state": pa.array(ur_motion.positions.tolist()),
    }
    parquet.write_table(pa.table(table), folder / "motion.parquet")
    return folder


def read(path):
    return lt.read_demonstrations(path, **OPTIONS.get(path.suffix[1:], {}))


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_flipped_bytes_are_read_or_refused(whole, tmp_path, suffix):
    content = (whole / f"motion.{suffix}").read_bytes()
    assert read(whole / f"motion.{suffix}")
    rng = np.random.default_rng(7)
    path = tmp_path / f"damaged.{suffix}"
    for i in range(ROUNDS):
        damaged = np.frombuffer(content, np.uint8).copy()
        # Headers lie at both ends; half of the flips go there.
        reach = len(content) if i % 2 else min(len(content), 512)
        places = rng.integers(0, reach, rng.integers(1, 5)) * rng.choice([1, -1])
        damaged[places] = rng.integers(0, 256, len(places))
        path.write_bytes(damaged.tobytes())
        try:
            read(path)
        except InvalidInput as error:
            assert "damaged" in str(error)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_that_are_cut_off_are_read_or_refused(whole, tmp_path, suffix):
    content = (whole / f"motion.{suffix}").read_bytes()
    path = tmp_path / f"cut.{suffix}"
    for fraction in np.linspace(0.0, 1.0, 20, endpoint=False):
        path.write_bytes(content[: int(fraction * len(content))])
        try:
            read(path)
        except InvalidInput as error:
            assert "cut" in str(error)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_of_another_kind_are_refused(whole, tmp_path, suffix):
    for other in SUFFIXES:
        if {suffix, other} not in ({suffix}, {"json", "yaml"}):
            path = tmp_path / f"other.{suffix}"
            shutil.copy(whole / f"motion.{other}", path)
            with pytest.raises(InvalidInput):
                read(path)


def test_an_archive_that_inflates_too_far_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(bounds, "MOST_BYTES", 10_000_000)
    path = tmp_path / "bomb.npz"
    np.savez_compressed(path, joints=np.zeros((1_300_000, 1)))
    assert path.stat().st_size < 20_000
    with pytest.raises(InvalidInput, match=r"the archive: .* it claims 10,400,128"):
        read(path)


def test_a_chunk_of_a_bag_that_inflates_too_far_is_refused(whole, tmp_path):
    content = (whole / "motion.mcap").read_bytes()
    at, kind = 8, 0
    while kind != 6:  # records: a kind, a length, and of a chunk two times and its size
        kind, length = struct.unpack_from("<BQ", content, at)
        at += 9 + length
    size = at - length + 16
    bomb = content[:size] + struct.pack("<Q", 10**10) + content[size + 8 :]
    (tmp_path / "bomb.mcap").write_bytes(bomb)
    with pytest.raises(InvalidInput, match=r"a chunk: .* it claims 10,000,000,000"):
        read(tmp_path / "bomb.mcap")


def test_a_header_of_ten_gigabytes_is_refused(tmp_path):
    path = tmp_path / "header.npz"
    with zipfile.ZipFile(path, "w") as archive, archive.open("joints.npy", "w") as file:
        header = {"descr": "<f8", "fortran_order": False, "shape": (10**9, 10)}
        np.lib.format.write_array_header_1_0(file, header)
    with pytest.raises(InvalidInput, match=r"joints.npy: .* it claims 10,000,000,000"):
        read(path)
