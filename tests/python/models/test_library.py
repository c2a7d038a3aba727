"""A library of skills."""

import warnings

import numpy as np
import pytest
from kinds import kind
from motions import minimum_jerk
from refusals import refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.models import OutsideTargets

TIMES = np.linspace(0.0, 2.0, 200)
S = minimum_jerk(TIMES / 2.0)
GRID = [(x, y, 0.1) for x in (0.2, 0.3, 0.4) for y in (-0.1, 0.0, 0.1)]


def reach(target, *, turned=1.0):
    """A bow to a target, higher for farther ones, that turns the tool."""
    points = np.outer(S, target)
    points[:, 2] += 0.5 * target[0] * np.sin(np.pi * S)
    return lt.PoseTrajectory(TIMES, points, rotations.exp(np.outer(S, [0.0, 0.0, turned])))


def filled(model=None):
    library = lt.SkillLibrary()
    for target in GRID:
        skill = (model or pose_primitive(weights=20)).fit([reach(target, turned=5.0 * target[0])])
        library = library.with_skill(skill, task="digging", subtask="reach", target=target)
    return library


def pose_primitive(**settings):
    return kind("DMP", "poses", **settings).build()


@pytest.fixture(scope="module")
def library():
    return filled()


def test_nearest_target_is_found(library):
    skill = library.nearest("digging", "reach", (0.31, 0.08, 0.0))
    np.testing.assert_allclose(skill.generate().positions[-1], (0.3, 0.1, 0.1), atol=1e-9)


def test_tasks_and_subtasks_are_kept_apart(library):
    other = lt.DMP().fit([lt.Trajectory([0, 1], [[0.0], [1.0]])])
    both = library.with_skill(other, task="digging", subtask="home", target=(0.0,))
    assert both.subtasks("digging") == ("reach", "home")
    assert library.subtasks("digging") == ("reach",)
    assert both.subtasks("seeding") == ()
    assert both.nearest("digging", "home", (5.0,)) is other


def test_same_target_is_replaced(library):
    skill = pose_primitive().fit([reach((0.9, 0.9, 0.9))])
    library = library.with_skill(skill, task="digging", subtask="reach", target=GRID[0])
    assert len(library.entries) == len(GRID)
    assert library.nearest("digging", "reach", GRID[0]) is skill


@pytest.mark.parametrize("target", [(0.25, 0.05, 0.1), (0.35, -0.02, 0.1), (0.3, 0.1, 0.1)])
def test_skills_between_targets_are_interpolated(library, target):
    made = library.interpolated("digging", "reach", target).generate(dt=2.0 / 199)
    truth = reach(target, turned=5.0 * target[0])
    np.testing.assert_allclose(made.positions, truth.positions, atol=1e-4)
    assert rotations.distance(made.orientations, truth.orientations).max() < 1e-3
    from_nearest = library.nearest("digging", "reach", target).generate(dt=2.0 / 199)
    assert np.abs(made.positions - truth.positions).max() <= (
        np.abs(from_nearest.positions - truth.positions).max() + 1e-4
    )


def test_targets_on_a_line_are_enough():
    library = lt.SkillLibrary()
    for x in (0.4, 0.2):
        motion = lt.JointTrajectory(TIMES, np.outer(S, [x, -x]), joint_names=("a", "b"))
        skill = lt.DMP().fit([motion])
        library = library.with_skill(skill, task="t", subtask="s", target=(x, 0.0))
    made = library.interpolated("t", "s", (0.25, 0.0)).generate()
    np.testing.assert_allclose(made.positions[-1], (0.25, -0.25), atol=1e-9)
    assert made.joint_names == ("a", "b")


def test_outside_of_all_targets_the_nearest_is_taken(library):
    with pytest.warns(OutsideTargets, match=r"lies 0\.2 outside .* 'reach'"):
        far = library.interpolated("digging", "reach", (0.6, 0.0, 0.1))
    assert far is library.nearest("digging", "reach", (0.6, 0.0, 0.1))
    one = lt.SkillLibrary().with_skill(far, task="t", subtask="s", target=(0.0, 0.0))
    with pytest.warns(OutsideTargets, match=r"lies 1\.41 outside"):
        assert one.interpolated("t", "s", (1.0, 1.0)) is far


@pytest.mark.parametrize(
    ("target", "outside"),
    [
        ((0.3, 0.02, 0.1), 0.0),
        ((0.2, -0.1, 0.1), 0.0),
        ((0.4, 0.03, 0.1), 0.0),
        ((0.45, 0.03, 0.1), 0.05),
        ((0.43, 0.14, 0.1), 0.05),
        ((0.3, 0.0, 0.13), 0.03),
        ((0.1, 0.0, -0.1), np.sqrt(0.05)),
    ],
)
def test_distance_tells_how_far_outside_a_target_is(library, target, outside):
    assert library.distance("digging", "reach", target) == pytest.approx(outside, abs=1e-12)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        library.interpolated("digging", "reach", target)
    assert [each.category for each in told] == ([OutsideTargets] if outside else [])


def test_distance_from_targets_in_space_or_at_one_place(library):
    rng = np.random.default_rng(0)
    skill, library = library.entries[0].skill, lt.SkillLibrary()
    corners = rng.standard_normal((12, 3))
    for corner in corners:
        library = library.with_skill(skill, task="t", subtask="s", target=corner)
    for _ in range(20):
        inside = rng.dirichlet(np.ones(12)) @ corners
        assert library.distance("t", "s", inside) == 0.0
        normal = rng.standard_normal(3)
        normal /= np.linalg.norm(normal)
        highest = corners[np.argmax(corners @ normal)]
        away = library.distance("t", "s", highest + 0.7 * normal)
        assert away == pytest.approx(0.7, rel=1e-9)
    one = lt.SkillLibrary().with_skill(skill, task="t", subtask="s", target=(1.0, 2.0))
    assert one.distance("t", "s", (4.0, 6.0)) == 5.0
    refused("target", one.distance, "t", "s", (4.0,))


def test_library_comes_back_from_its_file(library, tmp_path):
    points = [lt.Trajectory(TIMES, np.outer(S, [0.3, 0.1]))]
    library = library.with_skill(
        lt.FastMarching().fit(points), task="draw", subtask="line", target=(0.3, 0.1)
    )
    library.save(tmp_path / "skills.npz")
    loaded = lt.SkillLibrary.load(tmp_path / "skills.npz")
    assert [file.name for file in tmp_path.iterdir()] == ["skills.npz"]
    assert len(loaded.entries) == len(GRID) + 1
    for before, after in zip(library.entries, loaded.entries, strict=True):
        assert (after.task, after.subtask) == (before.task, before.subtask)
        np.testing.assert_array_equal(after.target, before.target)
        expected = before.skill.generate().positions
        assert after.skill.generate().positions.tobytes() == expected.tobytes()


def test_what_cannot_be_averaged_is_refused():
    library = lt.SkillLibrary()
    points = [lt.Trajectory(TIMES, np.outer(S, [0.3, 0.1]))]
    for target, turned in (((0.0, 0.0), 0.0), ((1.0, 0.0), np.pi)):
        drawn = lt.FastMarching().fit(points)
        library = library.with_skill(drawn, task="t", subtask="drawn", target=target)
        skill = pose_primitive().fit([reach((1, 1, 1), turned=turned)])
        library = library.with_skill(skill, task="t", subtask="far", target=target)
    for subtask in ("drawn", "far"):
        library.nearest("t", subtask, (0.5, 0.0))
        with pytest.raises(UnsupportedQuery):
            library.interpolated("t", subtask, (0.5, 0.0))


def test_bad_input_is_refused(library, tmp_path):
    skill = library.entries[0].skill
    for change in ({"task": 3}, {"subtask": None}, {"target": (0.0,)}, {"target": "x"}):
        query = {"task": "digging", "subtask": "reach", "target": (0.0, 0.0, 0.0), **change}
        refused(next(iter(change)), library.with_skill, skill, **query)
        with pytest.raises(InvalidInput):
            library.nearest(**query)
    refused("skill", library.with_skill, None, task="a", subtask="b", target=(0.0,))
    skill.save(tmp_path / "skill.npz")
    library.save(tmp_path / "library.npz")
    refused("library", lt.SkillLibrary.load, tmp_path / "skill.npz")
    refused("library", lt.load_skill, tmp_path / "library.npz")
    refused("path", lt.SkillLibrary.load, tmp_path / "nothing.npz")
