"""Refusals of Fast Marching Learning, by argument, and queries without a path, by reason."""

import numpy as np
import pytest
from motions import minimum_jerk

import leadthrough as lt
from leadthrough.errors import InvalidInput, NoPath

NAN = np.nan
T = np.linspace(0.0, 1.0, 200)
ARCH = np.column_stack([0.4 * minimum_jerk(T), 0.1 * np.sin(np.pi * minimum_jerk(T))])
BALL = lt.Sphere(1.0, (0.0, 0.0, 0.0))
SPACE = ((-0.1, -0.1), (0.5, 0.3))


@pytest.fixture(scope="module")
def skill():
    return lt.FastMarching().fit([lt.Trajectory(2.0 * T, ARCH)])


SETTINGS = [
    *((name, bad) for name in ("area_of_influence", "saturation", "resolution")
      for bad in (0.0, -1.0, NAN, "wide")),
    *(("workspace", bad) for bad in (((0.0, 0.0), (0.0, 1.0)), ((0.0,), (1.0, 2.0)), "all",
                                     ((0, NAN), (1, 1)))),
    ("obstacle_map", "sum"),
]  # fmt: skip


@pytest.mark.parametrize(("argument", "bad"), SETTINGS)
def test_wrong_setting_is_named(argument, bad):
    with pytest.raises(InvalidInput) as error:
        lt.FastMarching(**{argument: bad})
    assert error.value.argument == argument


def test_motions_of_one_dimension_are_refused():
    with pytest.raises(InvalidInput, match="two or three dimensions"):
        lt.FastMarching().fit([lt.Trajectory([0.0, 1.0], [[0.0], [1.0]])])


QUERIES = [
    *(("start", bad) for bad in ((0.0, NAN), (0.0, 0.0, 0.0))),
    *(("goal", bad) for bad in ("there", (1e6, 0.0))),
    *(("duration", 0.0), ("obstacles", [1])),
    *(("dt", bad) for bad in (-1.0, 1e-9, {"duration": 1e300})),
    (None, {"start": (-39.0, -39.0), "goal": (39.0, 39.0), "obstacles": [BALL]}),
]


@pytest.mark.parametrize(("argument", "bad"), QUERIES)
def test_wrong_query_is_named(skill, argument, bad):
    with pytest.raises(InvalidInput) as error:
        skill.generate(**(bad if isinstance(bad, dict) else {argument: bad}))
    assert argument is None or error.value.argument == argument


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("position", lambda skill: skill.policy((NAN, 0.0))),
        ("position", lambda skill: skill.policy_to().around([], position=(9.0, 9.0))),
        ("obstacles", lambda skill: skill.policy_to().around([1])),
        ("skill", lambda _: lt.FastMarching().fit([]).policy((0.0, 0.0))),
        ("goal", lambda skill: skill.live_map(SPACE).route((0.0, 0.0), (5.0, 0.0), ())),
        ("start", lambda skill: skill.live_map(SPACE).route((NAN, 0.0), (0.4, 0.0), ())),
        ("goal", lambda skill: skill.live_map(SPACE).route((0.0, 0.0), (0.1,) * 3, ())),
        ("obstacles", lambda skill: skill.live_map(SPACE).route((0.0, 0.0), (0.4, 0.0), ["box"])),
        ("workspace", lambda skill: skill.live_map(((0.2, 0.0), (0.5, 0.3)))),
        ("workspace", lambda skill: skill.live_map(SPACE[::-1])),
        ("workspace", lambda skill: skill.live_map((0.0, 1.0))),
        ("cells", lambda skill: skill.live_map(SPACE, cells=10)),
    ],
)
def test_wrong_argument_of_a_policy_or_a_live_map_is_named(skill, argument, call):
    with pytest.raises(InvalidInput) as error:
        call(skill)
    assert error.value.argument == argument


@pytest.mark.parametrize(
    ("reason", "obstacle"),
    [
        ("start_in_wall", lt.Box((0.05, 0.05, 0.1), (0.0, 0.0, 0.0))),
        ("goal_in_wall", lt.Box((0.05, 0.05, 0.1), (0.4, 0.0, 0.0))),
        ("goal_enclosed", lt.Box((0.05, 9.0, 0.1), (0.2, 0.0, 0.0))),
    ],
)
def test_no_path_has_its_reason(skill, reason, obstacle):
    with pytest.raises(NoPath) as error:
        skill.generate(start=(0.0, 0.0), obstacles=[obstacle])
    assert error.value.reason == reason
    if reason != "goal_enclosed":
        with pytest.raises(NoPath) as error:
            skill.live_map(SPACE).route((0.0, 0.0), (0.4, 0.0), [obstacle])
        assert error.value.reason == reason


def test_position_without_a_way_to_the_goal_is_no_path(skill):
    policy = skill.policy_to()
    for call in (
        lambda: skill.policy((5.0, 5.0)),
        lambda: policy.around([lt.Sphere(0.05, (0.1, 0.1, 0.0))], position=(0.1, 0.1)),
        lambda: policy.around([lt.Sphere(0.05, (0.4, 0.0, 0.0))]),
    ):
        with pytest.raises(NoPath):
            call()
    with pytest.raises(NoPath) as error:
        skill.policy_to(obstacles=[lt.Box((0.1, 0.1, 0.1), (0.4, 0.0, 0.0))])
    assert error.value.reason == "goal_in_wall"
