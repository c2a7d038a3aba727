"""The numbers of a skill that a person may drag, and the settings that stay as they are."""

from dataclasses import fields

import numpy as np
import pytest
from kinds import kind

import leadthrough as lt
from leadthrough.models import TaskGMR

T = np.linspace(0.0, 1.0, 150)
ARCHES = [
    lt.Trajectory(1.5 * T, np.column_stack([0.3 * T, 0.1 * np.sin(np.pi * T) + shift * (1 - T)]))
    for shift in (-0.02, 0.0, 0.02)
]
TURNS = lt.rotations.exp(np.outer(T, [0.5, 0.0, 0.2]))
POSES = [
    lt.PoseTrajectory(each.times, np.column_stack([each.positions, T]), TURNS) for each in ARCHES
]
ROUND = np.column_stack([np.cos(4 * np.pi * T), np.sin(4 * np.pi * T), 0.0 * T])
STILL = np.repeat(TURNS[:1], len(T), axis=0)

# Models none of whose settings is the default one, what they learn from, and what may be dragged.
DMP = {"weights": 30, "form": "hoffmann", "regression": "ridge", "orientation": "log"}
RHYTHM = {"weights": 20, "period": 0.5}
PROMP = {"basis": "gaussian", "width": 0.8, "estimator": "em", "regularization": 1e-4}
MARCHING = {"area_of_influence": 0.02, "saturation": 0.1, "resolution": 0.01, "method": "map"}
SPACE = ((-0.5, -0.5), (0.8, 0.8))
LEARNERS = {
    "DMP": (kind("DMP", **DMP), ARCHES, {"weights"}),
    "DMP of poses": (kind("DMP", "poses", **DMP), POSES, {"weights"}),
    "RhythmicDMP": (kind("RhythmicDMP", **RHYTHM), [lt.Trajectory(T, ROUND)], {"weights"}),
    "RhythmicDMP of poses": (
        kind("RhythmicDMP", "poses", **RHYTHM),
        [lt.PoseTrajectory(T, ROUND, STILL)],
        {"weights"},
    ),
    "ProMP": (kind("ProMP", weights=12, **PROMP), ARCHES, {"weights"}),
    "GMR": (kind("GMR", components=5, seed=3), ARCHES, {"components"}),
    "TaskGMR": (kind("TaskGMR", components=5, seed=3), ARCHES, {"components"}),
    "FastMarching": (
        kind("FastMarching", timing="constant", workspace=SPACE, **MARCHING),
        ARCHES,
        {"saturation", "area of influence, m"},
    ),
}


@pytest.fixture(params=LEARNERS)
def case(request):
    learner, motions, labels = LEARNERS[request.param]
    return learner.build(), motions, labels


def settings(model):
    return {field.name: getattr(model, field.name) for field in fields(model)}


def test_a_skill_has_all_settings_that_it_was_fitted_with(case, tmp_path):
    model, motions, _ = case
    skill = model.fit(motions)
    assert skill.model == model
    skill.save(tmp_path / "skill.npz")
    assert lt.load_skill(tmp_path / "skill.npz").model == model


def test_a_dragged_parameter_changes_its_own_setting_and_no_other(case):
    model, motions, labels = case
    skill = model.fit(motions)
    parameters = skill.parameters(motions)
    assert {each.label for each in parameters} == labels
    for parameter in parameters:
        assert parameter.lower <= parameter.value <= parameter.upper
        changed = settings(parameter.apply(parameter.lower).model)
        name = parameter.label.removesuffix(", m").replace(" ", "_")
        assert changed.pop(name) == pytest.approx(parameter.lower)
        assert changed.items() <= settings(model).items()


def test_a_parameter_set_to_its_present_value_gives_the_same_motion(case):
    model, motions, _ = case
    skill = model.fit(motions)
    for parameter in skill.parameters(motions):
        again = parameter.apply(parameter.value)
        assert np.array_equal(again.generate().positions, skill.generate().positions)


def test_what_needs_a_new_fit_cannot_be_dragged_without_demonstrations(case):
    model, motions, labels = case
    kept = {each.label for each in model.fit(motions).parameters()}
    assert kept == (labels if isinstance(model, lt.FastMarching) else set())


def test_a_promp_keeps_its_duration_and_limits_while_a_parameter_is_dragged():
    skill = lt.ProMP().fit(ARCHES).lasting(4.0).within((-0.1, -0.1), (0.35, 0.08))
    (weights,) = skill.parameters(ARCHES)
    changed = weights.apply(30)
    assert changed.generate().duration == pytest.approx(4.0)
    assert changed.generate().positions[:, 1].max() <= 0.08 + 1e-9


def test_the_number_of_weights_is_found_by_the_number_that_was_chosen():
    u = np.linspace(0.0, 1.0, 2000)
    shown = [lt.Trajectory(u, np.column_stack([u, np.sin(300.0 * u)]))]
    skill = lt.DMP(weights=None).fit(shown)
    count = skill.model.weights
    assert count > 100
    (weights,) = skill.parameters(shown)
    assert (weights.value, weights.upper) == (count, count)


def test_frames_of_its_own_are_not_in_the_demonstrations():
    frames = [[lt.models.Frame(each.positions[0])] for each in ARCHES]
    skill = TaskGMR(4).fit(ARCHES, frames=frames)
    assert list(skill.parameters(ARCHES)) == []


def test_a_planner_without_demonstrations_has_no_radius_to_drag():
    assert [each.label for each in lt.FastMarching().fit([]).parameters()] == ["saturation"]
