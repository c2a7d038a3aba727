"""The registry of models: its rows, and models that other packages add."""

import json
from pathlib import Path

import kinds
import numpy as np
import pytest
from cli.command_line import run
from cli.test_completion import offered
from refusals import refused

import leadthrough as lt
from leadthrough.models import archive, model_entry, model_names, registry

THEIRS = Path(__file__).parent / "theirs"  # as pip installs a package with entry points


@pytest.fixture
def theirs(monkeypatch):
    """Somebody else's package is installed: one of its models works, the other has no module."""
    monkeypatch.syspath_prepend(THEIRS)
    registry._others.cache_clear()
    yield
    registry._others.cache_clear()


@pytest.mark.parametrize("name", model_names())
def test_every_model_has_a_name_a_class_and_kinds_that_are_tested(name):
    entry = model_entry(name)
    assert entry.name == name
    built = {type(of.build()) for of in kinds.KINDS.values()}
    assert entry.load() in built


@pytest.mark.parametrize("role", kinds.KINDS)
def test_a_row_names_the_motions_and_the_skills_of_its_model(role):
    of, skill = kinds.KINDS[role], kinds.learned(role)
    entry = registry.entry_of_class(type(skill.model).__name__)
    assert of.motion in entry.motions
    assert skill.kind == entry.skills[0]


def test_a_model_of_another_package_is_learned_by_the_command_line_and_its_skill_loads(
    theirs, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    times = np.linspace(0.0, 2.0, 50)
    lt.write_motion(lt.Trajectory(times, np.outer(times, [0.1, 0.2])), "demonstrated.csv")
    assert "straight" in model_names()
    assert offered("leadthrough learn demonstrated.csv --model str") == ["straight"]
    run("learn", "demonstrated.csv", "--model", "straight", "--set", "pace=2", "-o", "skill.npz")
    skill = lt.load_skill("skill.npz")
    assert skill.model == model_entry("straight").load()(pace=2)
    motion = skill.generate(goal=(0.5, 0.5))
    assert motion.duration == pytest.approx(4.0)
    np.testing.assert_allclose(motion.positions[[0, -1]], [[0.0, 0.0], [0.5, 0.5]])
    run("plan", "skill.npz", "-o", "motion.csv")


def test_a_skill_whose_package_is_not_installed_is_refused(theirs, tmp_path, monkeypatch):
    straight = model_entry("straight").load()
    line = lt.Trajectory([0.0, 1.0], [[0.0, 0.0], [1.0, 1.0]])
    straight().fit([lt.Demonstration(line)]).save(tmp_path / "skill.npz")
    monkeypatch.undo()
    registry._others.cache_clear()
    refused(r"expected a skill of .* got 'straight'", lt.load_skill, tmp_path / "skill.npz")


def test_unknown_models_are_refused_with_the_names_that_there_are(theirs):
    refused(r"broken.*cannot be imported", model_entry, "broken")
    refused("expected a skill of", registry.entry_of_skill, "no such kind")
    refused(r"expected one of dmp, .*, got 'dpm'", model_entry, "dpm")


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


def test_files_of_other_versions_kinds_and_settings_are_refused(saved):
    skill = lt.load_skill(saved)
    refused("no such folder", skill.save, saved.parent / "missing" / "skill.npz")
    refused("'oracle'", lt.load_skill, rewritten(saved, kind="oracle"))
    refused("damaged", lt.load_skill, rewritten(saved, kind="fast_marching", settings={"shown": 1}))
    refused("version 9", lt.load_skill, rewritten(saved, version=archive.VERSION + 8))


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
