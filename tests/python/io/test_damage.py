"""Files with flipped bytes, cut off or of another kind: a reader reads them or says what is wrong.

The damage is drawn from fixed seeds; any other exception than a typed one is a bug. For each format
`robustness/damage.py` does it 2,000 times.
"""

import re
import shutil
import zipfile

import numpy as np
import pytest
from refusals import refused
from robustness import bombs, damage, measured

from leadthrough.errors import InvalidInput, LeadthroughError
from leadthrough.io import files

SUFFIXES = damage.RECORDINGS
ROUNDS = 60


@pytest.fixture(scope="module")
def whole(tmp_path_factory, ur_motion):
    """A folder with a good file of each format."""
    folder = tmp_path_factory.mktemp("whole")
    damage.write_all(folder, ur_motion)
    return folder


@pytest.mark.parametrize("suffix", (*SUFFIXES, *damage.OTHERS))
def test_damaged_files_are_read_or_refused(whole, tmp_path, suffix):
    content = (whole / f"whole.{suffix}").read_bytes()
    damage.read(whole / f"whole.{suffix}")
    shutil.copy(whole / "whole.urdf", tmp_path)  # limits are read for a robot
    path = tmp_path / f"damaged.{suffix}"
    for seed in range(ROUNDS):
        path.write_bytes(damage.damaged(content, np.random.default_rng(seed)))
        try:
            damage.read(path)
        except LeadthroughError as error:
            assert str(error)
            assert suffix != "npz" or path.name in str(error)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_that_are_cut_off_are_read_or_refused(whole, tmp_path, suffix):
    content = (whole / f"whole.{suffix}").read_bytes()
    path = tmp_path / f"cut.{suffix}"
    for fraction in np.linspace(0.0, 1.0, 20, endpoint=False):
        path.write_bytes(content[: int(fraction * len(content))])
        try:
            damage.read(path)
        except InvalidInput as error:
            assert "cut" in str(error)


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_files_of_another_kind_are_refused(whole, tmp_path, suffix):
    for other in SUFFIXES:
        if {suffix, other} not in ({suffix}, {"json", "yaml"}):
            path = tmp_path / f"other.{suffix}"
            shutil.copy(whole / f"whole.{other}", path)
            with pytest.raises(InvalidInput):
                damage.read(path)


def test_an_archive_that_inflates_too_far_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "MAX_BYTES", 10_000_000)
    path = tmp_path / "bomb.npz"
    np.savez_compressed(path, joints=np.zeros((1_300_000, 1)))
    assert path.stat().st_size < 20_000
    refused(r"the archive: .* it claims 10,400,128", damage.read, path)


def test_a_header_of_ten_gigabytes_is_refused(tmp_path):
    path = tmp_path / "header.npz"
    with zipfile.ZipFile(path, "w") as archive, archive.open("joints.npy", "w") as file:
        header = {"descr": "<f8", "fortran_order": False, "shape": (10**9, 10)}
        np.lib.format.write_array_header_1_0(file, header)
    refused(r"joints.npy: .* it claims 10,000,000,000", damage.read, path)


MAX_MEMORY = 1.5 * 2**30  # bytes
MAX_SECONDS = 20.0  # of processor time, for all of a format
ALL = [(suffix, makers) for suffix, makers in {**bombs.RECORDINGS, **bombs.MESHES}.items()]


@pytest.mark.parametrize(("suffix", "makers"), ALL, ids=[suffix for suffix, _ in ALL])
def test_bombs_are_refused_within_the_bounds(tmp_path, suffix, makers):
    paths = [tmp_path / f"{maker.__name__}.{suffix}" for maker in makers]
    for maker, path in zip(makers, paths, strict=True):
        maker(path)
    told, seconds, memory = measured.read(*paths)
    for path, answer in zip(paths, told, strict=True):
        assert path.name in answer
        if path.stem == "mcap_that_says_so":
            assert re.search("a chunk: .* it claims 10,000,000,000", answer)
    assert seconds < MAX_SECONDS
    assert memory < MAX_MEMORY
