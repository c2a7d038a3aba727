"""The registry of models: its rows, and models that other packages add."""

from pathlib import Path

import kinds
import numpy as np
import pytest
from cli.command_line import run
from cli.test_completion import offered
from refusals import refused

import leadthrough as lt
from leadthrough.models import model_entry, model_names, registry

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


def test_a_package_that_cannot_be_imported_disturbs_no_other_model(theirs):
    refused(r"broken.*cannot be imported", model_entry, "broken")
    refused("expected a skill of", registry.entry_of_skill, "no such kind")


def test_an_unknown_model_is_refused_with_the_names_that_there_are():
    refused(r"expected one of dmp, .*, got 'dpm'", model_entry, "dpm")
