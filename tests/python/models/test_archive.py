"""Skills in files: of earlier versions, damaged, foreign or from the future."""

import json
from pathlib import Path

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough.models import archive


@pytest.fixture
def saved(tmp_path):
    shown = lt.Demonstration(lt.Trajectory([0.0, 1.0, 2.0], [[0, 0], [1, 0.2], [2, 0]]))
    path = tmp_path / "skill.npz"
    lt.FastMarching().fit([shown]).save(path)
    return path


def rewritten(path, **changes):
    with np.load(path) as file:
        arrays = dict(file)
    head = json.loads(str(arrays.pop("head"))) | changes
    np.savez(path, head=np.array(json.dumps(head)), **arrays)
    return path


def test_learned_paths_and_orientations_are_kept(tmp_path):
    times = np.linspace(0.0, 1.0, 50)
    positions = np.column_stack([times, 0.1 * times, 0 * times])
    turned = lt.rotations.exp(np.outer(times, [0.0, 0.0, 1.0]))
    skill = lt.FastMarching(saturation=0.1).fit([lt.PoseTrajectory(times, positions, turned)])
    skill = skill.with_experience(positions + np.array([0.0, 0.3, 0.0]))
    skill.save(tmp_path / "skill.npz")
    loaded = lt.load_skill(tmp_path / "skill.npz")
    assert loaded.model == skill.model
    assert (len(loaded.demonstrated), len(loaded.learned)) == (1, 1)
    assert loaded.generate().orientations.tobytes() == skill.generate().orientations.tobytes()


def test_missing_foreign_and_damaged_files_are_refused(saved, tmp_path):
    refused("no such file", lt.load_skill, tmp_path / "nothing.npz")
    foreign = tmp_path / "foreign.npz"
    np.savez(foreign, times=np.arange(3.0))
    refused("saved skill", lt.load_skill, foreign)
    content = saved.read_bytes()
    for end in (0, 10, len(content) // 2, len(content) - 5):
        saved.write_bytes(content[:end])
        refused("saved skill", lt.load_skill, saved)


def test_later_format_says_so(saved):
    refused("version 9", lt.load_skill, rewritten(saved, version=archive.VERSION + 8))


def test_unknown_kind_and_wrong_settings_are_refused(saved):
    refused("'oracle'", lt.load_skill, rewritten(saved, kind="oracle"))
    refused("damaged", lt.load_skill, rewritten(saved, kind="fast_marching", settings={"shown": 1}))


def test_folder_that_does_not_exist_is_named(saved):
    skill = lt.load_skill(saved)
    refused("no such folder", skill.save, saved.parent / "missing" / "skill.npz")


FOLDER = Path(__file__).parent / "saved_before"
# Positions at steps of 0.1 s, by the version that saved; those of Fast Marching are of a later one,
# which follows the middle of the tube instead of marching through it, up to 5 mm from before.
MOTIONS = np.load(FOLDER / "motions.npz")


@pytest.mark.parametrize("name", MOTIONS.files)
def test_a_skill_saved_by_an_earlier_version_generates_the_same_motion(name):
    skill = lt.load_skill(FOLDER / f"{name}.npz")
    np.testing.assert_allclose(skill.generate(dt=0.1).positions, MOTIONS[name], atol=1e-12)


def test_a_library_saved_by_an_earlier_version_still_has_its_skill():
    library = lt.SkillLibrary.load(FOLDER / "library.npz")
    motion = library.nearest("t", "s", [0.0]).generate(dt=0.1)
    np.testing.assert_allclose(motion.positions, MOTIONS["dmp"], atol=1e-12)
