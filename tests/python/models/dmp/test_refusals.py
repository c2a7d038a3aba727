"""Arguments that movement primitives refuse, by name."""

import pickle
from functools import cache

import numpy as np
import pytest
from models.dmp.turns import demonstration, turn
from motions import arch, ring
from refusals import refused

import leadthrough as lt
from leadthrough.errors import FitError, UnsupportedQuery


@cache
def skill(kind):
    if kind == "rhythm":
        return lt.RhythmicDMP().fit([ring("points")])
    return lt.DMP().fit([arch("poses" if kind == "poses" else "joints")])


@pytest.mark.parametrize(
    ("model", "settings"),
    [
        (lt.DMP, {"weights": 1}),
        (lt.DMP, {"weights": 2.0}),
        (lt.DMP, {"form": "other"}),
        (lt.DMP, {"form": "lauretti"}),
        (lt.DMP, {"regression": None}),
        (lt.DMP, {"orientation": "quaternion"}),
        (lt.RhythmicDMP, {"weights": 2}),
        (lt.RhythmicDMP, {"period": 0.0}),
        (lt.RhythmicDMP, {"period": "1"}),
    ],
)
def test_bad_settings_are_refused_by_name(model, settings):
    refused(next(iter(settings)), model, **settings)


@pytest.mark.parametrize(
    ("kind", "query"),
    [
        ("joints", {"via": [(0.5, (0.0, 0.0))]}),
        ("joints", {"via": [(1.5, (0.0, 0.0, 0.0))]}),
        ("joints", {"via": [0.5]}),
        ("joints", {"via": 3}),
        ("joints", {"via": np.array([[0.5, 0.0]])}),
        ("joints", {"start_velocity": (np.inf, 0.0, 0.0)}),
        ("joints", {"final_velocity": 1.0}),
        ("joints", {"goal": (1e308, 0.0, 0.0), "start": (-1e308, 0.0, 0.0)}),
        ("joints", {"duration": 5e-324}),
        ("joints", {"obstacles": [None]}),
        ("joints", {"obstacles": 3}),
        ("joints", {"limits": 3}),
        ("joints", {"limits": (0.0, 1.0)}),
        ("joints", {"limits": ((0, 0, 0), (1, 1))}),
        ("joints", {"limits": ((1, 1, 1), (0, 0, 0))}),
        ("joints", {"limits": ((0, 0, np.nan), (1, 1, 1))}),
        ("poses", {"goal": ((0, 0, 0), (1, 1, 1, 1))}),
        ("poses", {"goal": ((0, 0, 0), (0, 0, 0, 0))}),
        ("poses", {"goal": (0, 0)}),
        ("poses", {"start": ((0, 0), (1, 0, 0, 0))}),
        ("poses", {"start": (0, 0, np.nan)}),
        ("poses", {"duration": 0.0}),
        ("poses", {"dt": -1.0}),
        ("poses", {"obstacles": [1]}),
        ("poses", {"via": [(0.5, (0, 0))]}),
        ("rhythm", {"amplitude": -1, "duration": 1.0}),
        ("rhythm", {"period": 0.0, "duration": 1.0}),
        ("rhythm", {"period": 1e-9, "duration": 1.0}),
        ("rhythm", {"start": (0,), "duration": 1.0}),
        ("rhythm", {"goal": "x", "duration": 1.0}),
    ],
)
def test_a_bad_query_is_refused_by_name(kind, query):
    refused("|".join(query), skill(kind).generate, **query)


@pytest.mark.parametrize(
    ("kind", "change"),
    [
        ("joints", {"dt": 0.0}),
        ("joints", {"dt": np.nan}),
        ("joints", {"dt": 1e9}),
        ("joints", {"dt": "1"}),
        ("joints", {"goal": (0.0,)}),
        ("joints", {"goal": (1e300, 0.0, 0.0)}),
        ("joints", {"lag": -1.0}),
        ("joints", {"coupling": (0.0, 0.0)}),
        ("joints", {"coupling": (1e300, 0.0, 0.0)}),
        ("joints", {"coupling": (np.nan, 0.0, 0.0)}),
        ("joints", {"measured": (1e300, 0.0, 0.0)}),
        ("poses", {"dt": np.inf}),
        ("poses", {"goal": ((0, 0, 0), (2, 0, 0, 0))}),
        ("poses", {"coupling": (0, 0)}),
        ("poses", {"measured": ((0, 0, np.nan), (1, 0, 0, 0))}),
        ("poses", {"lag": np.nan}),
        ("rhythm", {"dt": 1e6}),
    ],
)
def test_a_bad_step_is_refused_by_name(kind, change):
    learned = skill(kind)
    refused(next(iter(change)), learned.step, learned.begin(), **{"dt": 0.01, **change})


@pytest.mark.parametrize(
    ("kind", "query"),
    [
        ("joints", {"obstacles": [lt.Sphere(0.1, (0, 0, 0))]}),
        ("poses", {"limits": (-np.ones(3), np.ones(3))}),
        ("rhythm", {"obstacles": [lt.Sphere(0.1, (0, 0, 0))]}),
    ],
)
def test_parts_that_a_skill_does_not_support_are_refused_by_name(kind, query):
    (name,) = query
    assert name not in skill(kind).supports
    with pytest.raises(UnsupportedQuery, match=name):
        skill(kind).generate(**query)


@pytest.mark.parametrize(
    ("model", "motion", "told"),
    [
        (lt.DMP(), lt.Trajectory([0, 1, 2], [[-1e308], [0], [1e308]]), "beyond"),
        (
            lt.DMP(),
            lt.PoseTrajectory([0, 1], np.zeros((2, 3)), [(1, 0, 0, 0), (-1, 0, 0, 0)]),
            "not move",
        ),
        (lt.RhythmicDMP(period=2.0), ring("points"), "period"),
        (lt.RhythmicDMP(period=1e-9), ring("points"), "samples"),
    ],
)
def test_a_demonstration_that_cannot_be_learned_is_refused(model, motion, told):
    with pytest.raises(FitError, match=told):
        model.fit([motion])


CASES = {
    "joints": (lt.DMP(20, form="hoffmann"), lambda: arch("joints")),
    "anchored": (lt.DMP(20, orientation="anchored"), lambda: demonstration(*turn(120, 100))),
    "lifted": (lt.DMP(20, orientation="lifted"), lambda: demonstration(*turn(120, 100))),
    "log": (lt.DMP(20, orientation="log"), lambda: demonstration(*turn(120, 100))),
    "euler": (lt.DMP(20, orientation="euler"), lambda: demonstration(*turn(120, 100))),
    "lauretti": (lt.DMP.lauretti(20), lambda: demonstration(*turn(120, 100))),
    "rhythm": (lt.RhythmicDMP(), lambda: ring("points")),
    "rhythm of poses": (lt.RhythmicDMP(), lambda: ring("poses")),
}


@pytest.mark.parametrize("name", CASES)
def test_a_skill_survives_pickling_and_saving(name, tmp_path):
    model, demonstrated = CASES[name]
    skill = model.fit([demonstrated()])
    first = skill.generate()
    goal = first.positions[-1] + 0.1
    query = {"goal": goal, "duration": 4.0}
    expected = skill.generate(**query)
    skill.save(tmp_path / "skill.npz")
    for again in (pickle.loads(pickle.dumps(skill)), lt.load_skill(tmp_path / "skill.npz")):
        assert type(again) is type(skill)
        assert again.model == skill.model
        made = again.generate(**query)
        for part in ("positions", "orientations", "velocities"):
            if getattr(expected, part, None) is not None:
                assert getattr(made, part).tobytes() == getattr(expected, part).tobytes()
        assert getattr(made, "joint_names", None) == getattr(expected, "joint_names", None)
