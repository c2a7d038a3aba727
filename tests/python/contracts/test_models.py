"""Promises of every model for every type of motion. A new one joins with one line in `kinds`."""

from dataclasses import replace
from xml.etree import ElementTree

import kinds
import motions
import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough import rotations
from leadthrough.errors import FitError, InvalidInput, NotFitted


def rows(motion):
    """(n, columns) of all that the motion says."""
    if isinstance(motion, lt.PoseTrajectory):
        return np.hstack([motion.positions, motion.orientations])
    return motion.positions


def assert_at(motion, index, wanted):
    """That the motion has a pose, or a point, at one of its samples."""
    position = wanted[0] if isinstance(motion, lt.PoseTrajectory) else wanted
    np.testing.assert_allclose(motion.positions[index], position, atol=1e-8)
    if isinstance(motion, lt.PoseTrajectory):
        gap = rotations.distance(motion.orientations[[index]], wanted[1][None])
        np.testing.assert_allclose(gap, 0.0, atol=1e-7)


@pytest.fixture(params=kinds.KINDS)
def role(request):
    return request.param


@pytest.fixture
def kind(role):
    return kinds.KINDS[role]


@pytest.fixture
def model(kind):
    return kind.build()


@pytest.fixture
def query(kind):
    return kind.query


@pytest.fixture
def demonstrated(kind):
    return kinds.demonstrations(kind)


@pytest.fixture
def skill(role):
    return kinds.learned(role)


def test_fit_leaves_model_and_demonstrations_alone_and_returns_a_frozen_skill(kind, model):
    given = kinds.demonstrations(kind)
    skill = model.fit(given)
    assert skill is not model
    for motion, untouched in zip(given, kinds.demonstrations(kind), strict=True):
        np.testing.assert_array_equal(rows(motion), rows(untouched))
    with pytest.raises(AttributeError):
        skill.model = ()


def test_a_demonstration_that_runs_backwards_is_named_and_dropped_on_request(model, demonstrated):
    first, second, third = demonstrated
    shown = [first, motions.backwards(second), third]
    with pytest.raises(FitError, match=r"demonstrations\[1\]: runs backwards"):
        model.fit(shown)
    kept = model.fit(shown, outliers="drop").generate()
    assert rows(kept).tobytes() == rows(model.fit([first, third]).generate()).tobytes()


def test_generated_motion_is_of_the_demonstrated_type_and_like_it(skill, demonstrated):
    motion, middle = skill.generate(), demonstrated[1]
    assert type(motion) is type(middle)
    gaps = np.linalg.norm(middle.positions[:, None] - motion.positions[None], axis=2)
    assert gaps.min(axis=1).max() < 0.03
    assert motion.duration == pytest.approx(1.5, rel=0.1)
    if isinstance(motion, lt.JointTrajectory):
        assert motion.joint_names == middle.joint_names
    if isinstance(motion, lt.PoseTrajectory):
        there = rotations.interpolate(
            middle.times / middle.duration, middle.orientations, motion.times / motion.duration
        )
        assert rotations.distance(motion.orientations, there).max() < 0.3


def test_generated_arrays_are_finite_contiguous_and_read_only(skill):
    motion = skill.generate()
    assert (np.diff(motion.times) > 0.0).all()
    for array in (value for value in vars(motion).values() if isinstance(value, np.ndarray)):
        assert np.isfinite(array).all()
        assert array.flags.c_contiguous
        assert not array.flags.writeable
    if isinstance(motion, lt.PoseTrajectory):
        np.testing.assert_allclose(np.linalg.norm(motion.orientations, axis=1), 1.0, atol=1e-14)
        assert (np.einsum("ij,ij->i", motion.orientations[1:], motion.orientations[:-1]) > 0).all()


def test_velocities_and_accelerations_are_the_derivatives_of_the_motion(skill, kind):
    motion = skill.generate(dt=0.002)
    below = motion.positions
    for name in ("velocities", "accelerations"):
        rates = getattr(motion, name, None)
        if rates is None or (kind.family == "AlignedMean" and name == "accelerations"):
            return  # those of the aligned mean are differences over other steps
        expected = np.gradient(below, motion.times, axis=0)
        largest = np.abs(rates).max()
        np.testing.assert_allclose(rates[5:-5], expected[5:-5], atol=1e-2 * largest)
        below = rates


def test_new_start_goal_and_duration_are_met(skill, query):
    assert {"start", "goal", "duration"} <= skill.supports
    motion = skill.generate(start=query.start, goal=query.goal, duration=4.0, dt=0.02)
    assert_at(motion, 0, query.start)
    if query.ends_at_goal:
        assert_at(motion, -1, query.goal)
    assert motion.times[0] == 0.0
    assert motion.duration == pytest.approx(4.0)
    assert np.diff(motion.times).max() <= 0.02 + 1e-12


def test_same_query_gives_the_same_bits(model, skill, query, demonstrated):
    asked = {"start": query.start}
    if "obstacles" in skill.supports:
        asked["obstacles"] = [lt.Box((0.03, 0.03, 0.1), (0.15, 0.1, 0.05))]
    again = model.fit(demonstrated).generate(**asked)
    assert rows(again).tobytes() == rows(skill.generate(**asked)).tobytes()


def test_saved_skill_comes_back_with_the_same_bits(skill, tmp_path):
    path = tmp_path / "skill.npz"
    skill.save(path)
    loaded = lt.load_skill(path)
    assert type(loaded) is type(skill)
    assert rows(loaded.generate()).tobytes() == rows(skill.generate()).tobytes()
    assert [file.name for file in tmp_path.iterdir()] == ["skill.npz"]


def test_events_come_where_they_were_demonstrated_and_are_saved(
    model, query, demonstrated, tmp_path
):
    with_events = [
        replace(motion, events=(lt.Event(0.6 + late, "shut"), lt.Event(1.4, "opened")))
        for motion, late in zip(demonstrated, (0.0, 0.1, 0.2), strict=True)
    ]
    skill = model.fit(with_events)
    made = skill.generate(goal=query.goal, **query.half_speed)
    assert [event.name for event in made.events] == ["shut", "opened"]
    assert made.events[0].time == pytest.approx(1.4, abs=0.06)  # the mean, in twice the time
    assert made.events[1].time == pytest.approx(2.8, abs=0.06)
    skill.save(tmp_path / "skill.npz")
    assert lt.load_skill(tmp_path / "skill.npz").generate().events == skill.generate().events


def test_one_demonstration_is_enough(model, demonstrated):
    motion = model.fit(demonstrated[:1]).generate()
    np.testing.assert_allclose(motion.positions[-1], demonstrated[0].positions[-1], atol=1e-5)


def test_scale_of_the_data_does_not_matter(kind, model, skill):
    millimetres = model.fit(kinds.demonstrations(kind, scale=1000.0)).generate()
    np.testing.assert_allclose(millimetres.positions, 1000 * skill.generate().positions, atol=1e-2)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("start", lambda query: with_nan(query.start)),
        ("goal", lambda query: query.wrong),
        ("duration", lambda _: -1.0),
        ("dt", lambda _: 0.0),
        ("start", lambda _: "here"),
    ],
    ids=["start not a number", "wrong goal", "negative duration", "no step", "text"],
)
def test_bad_query_is_refused_by_name(skill, query, name, value):
    refused(name, skill.generate, **{name: value(query)})


def with_nan(wanted):
    """A point, or a pose, one of whose coordinates is not a number."""
    if isinstance(wanted[0], tuple):
        return with_nan(wanted[0]), wanted[1]
    return (np.nan, *wanted[1:])


def test_bad_demonstrations_are_refused(model, demonstrated):
    motion = demonstrated[0]
    for times in ([0.0, 1.0], [0.0]):  # one that does not move, one of a single sample
        held = [motion.positions[[0] * len(times)]]
        if isinstance(motion, lt.PoseTrajectory):
            held.append(motion.orientations[[0] * len(times)])
        with pytest.raises(FitError):
            model.fit([type(motion)(times, *held)])
    for bad in ([None], demonstrated[0], 3):
        with pytest.raises(InvalidInput):
            model.fit(bad)


def test_skill_is_described_in_a_few_lines(skill):
    text = repr(skill)
    assert text.startswith(f"{type(skill).__name__}({type(skill.model).__name__}(")
    assert "supports" in text
    assert len(text.splitlines()) <= 5
    assert max(map(len, text.splitlines())) <= 100


def test_skill_draws_its_motion(skill):
    page = ElementTree.fromstring(skill._repr_html_())
    (picture,) = page.iter("{http://www.w3.org/2000/svg}svg")
    assert picture.get("aria-label") == type(skill).__name__
    assert len(ElementTree.tostring(page)) < 120_000
    axes = skill.plot().axes
    assert sum(len(each.lines) for each in axes) >= 2
    assert any("position" in each.get_title(loc="left") for each in axes)


@pytest.mark.parametrize("name", ["generate", "plot", "save", "supports"])
def test_model_says_that_it_is_to_be_fitted_first(name):
    for each in kinds.KINDS.values():
        model = each.build()
        kind = type(model).__name__
        with pytest.raises(NotFitted, match=rf"{name}: {kind} .* {kind}\(\)\.fit\(demonstrations"):
            getattr(model, name)
        assert not hasattr(model, name)
    with pytest.raises(AttributeError, match="no attribute"):
        getattr(model, name[:3])
