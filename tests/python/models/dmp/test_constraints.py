"""Primitives around obstacles and inside limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motions import minimum_jerk

import leadthrough as lt
from leadthrough.errors import InvalidInput, NoPath, UnsupportedQuery

TIMES = np.linspace(0.0, 2.0, 200)
S = minimum_jerk(TIMES / 2.0)
BOW = np.column_stack([0.4 * S, 0.05 * np.sin(np.pi * S), 0.2 + 0.0 * S])
SKILL = lt.DMP().fit([lt.Demonstration(lt.Trajectory(TIMES, BOW))])
FLAT = lt.DMP().fit([lt.Demonstration(lt.Trajectory(TIMES, BOW[:, :2]))])
WALL = lt.Box((0.1, 0.1, 0.3), (0.2, 0.05, 0.2))  # its middle lies on the way


def shape_of(kind, seed):
    rng = np.random.default_rng(seed)
    middle = (rng.uniform(0.12, 0.28), rng.uniform(-0.05, 0.1), rng.uniform(0.15, 0.25))
    turn = lt.rotations.exp(rng.normal(size=(1, 3)))[0]
    if kind == "sphere":
        return lt.Sphere(rng.uniform(0.02, 0.08), middle)
    if kind == "box":
        return lt.Box(rng.uniform(0.02, 0.12, 3), middle, turn)
    if kind == "cylinder":
        return lt.Cylinder(rng.uniform(0.01, 0.05), rng.uniform(0.02, 0.1), middle, turn)
    return lt.Capsule(rng.uniform(0.01, 0.05), rng.uniform(0.0, 0.1), middle, turn)


@pytest.mark.parametrize("kind", ["sphere", "box", "capsule", "cylinder"])
@given(seed=st.integers(0, 2**32 - 1))
def test_obstacles_are_cleared_or_refused_and_the_goal_is_met(kind, seed):
    obstacle = shape_of(kind, seed)
    try:
        made = SKILL.generate(obstacles=[obstacle], dt=0.005)
    except NoPath as error:
        assert error.reason in {"not_cleared", "start_in_wall", "goal_in_wall"}
        return
    assert obstacle.distance(made.positions).min() > 0.0
    np.testing.assert_allclose(made.positions[[0, -1]], BOW[[0, -1]], atol=1e-9)


@pytest.mark.parametrize("kind", ["sphere", "box", "capsule", "cylinder"])
def test_one_obstacle_never_holds_the_motion_up(kind):
    for seed in range(100):
        obstacle = shape_of(kind, seed)
        made = SKILL.generate(obstacles=[obstacle], dt=0.01)
        assert obstacle.distance(made.positions).min() > 0.0


@pytest.mark.parametrize("turn", [np.pi, 2.0 * np.pi], ids=["half circle", "circle"])
def test_obstacles_on_a_curved_way_are_passed_too(turn):
    way = np.column_stack([0.2 - 0.2 * np.cos(turn * S), 0.2 * np.sin(turn * S)])
    skill = lt.DMP().fit([lt.Demonstration(lt.Trajectory(TIMES, way))])
    length = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
    for middle in way[70:130:10]:
        obstacle = lt.Box((0.05, 0.1, 0.1), (*middle, 0.0), lt.rotations.exp([(0, 0, 0.5)])[0])
        made = skill.generate(obstacles=[obstacle], dt=0.01)
        assert np.linalg.norm(np.diff(made.positions, axis=0), axis=1).sum() < 1.5 * length


def test_flat_wall_across_the_way_is_passed():
    made = SKILL.generate(obstacles=[WALL], dt=0.005)
    assert WALL.distance(made.positions).min() > 0.004
    np.testing.assert_allclose(made.positions[-1], BOW[-1], atol=1e-9)


def test_drawings_pass_obstacles_in_their_plane():
    ball = lt.Sphere(0.06, (0.2, 0.05, 0.0))
    made = FLAT.generate(obstacles=[ball], dt=0.005)
    assert np.linalg.norm(made.positions - (0.2, 0.05), axis=1).min() > 0.06
    np.testing.assert_allclose(made.positions[-1], BOW[-1, :2], atol=1e-9)


def test_far_obstacles_hardly_matter():
    made = SKILL.generate(obstacles=[lt.Sphere(0.05, (0.2, 1.5, 0.2))], dt=0.01)
    np.testing.assert_allclose(made.positions, SKILL.generate(dt=0.01).positions, atol=1e-3)


def test_ends_in_an_obstacle_are_named():
    for reason, query in (
        ("start_in_wall", {"start": (0.2, 0.05, 0.2)}),
        ("goal_in_wall", {"goal": (0.2, 0.05, 0.2)}),
    ):
        with pytest.raises(NoPath) as caught:
            SKILL.generate(obstacles=[WALL], **query)
        assert caught.value.reason == reason


def test_tool_turns_as_shown_while_its_position_passes_an_obstacle():
    turned = lt.rotations.exp(np.outer(S, [0.0, 0.0, 2.0]))
    skill = lt.DMP().fit([lt.Demonstration(lt.PoseTrajectory(TIMES, BOW, turned))])
    made = skill.generate(obstacles=[WALL], dt=0.005)
    assert WALL.distance(made.positions).min() > 0.004
    plain = skill.generate(dt=0.005)
    np.testing.assert_allclose(made.orientations, plain.orientations, atol=1e-12)


def test_steps_keep_clear_too():
    state = SKILL.begin()
    for _ in range(400):
        state = SKILL.step(state, 0.005, obstacles=[WALL])
        assert WALL.distance(state.position[None])[0] > 0.003
    assert np.linalg.norm(state.position - BOW[-1]) < 0.03
    state = SKILL.step(state, 4.0)
    np.testing.assert_allclose(state.position, BOW[-1], atol=1e-9)


@given(st.floats(0.012, 0.2), st.integers(1, 100))
def test_limits_are_kept(ceiling, milliseconds):
    lower, upper = (-1.0, -0.01, 0.0), (1.0, ceiling, 1.0)
    made = SKILL.generate(limits=(lower, upper), dt=0.001 * milliseconds)
    assert made.positions[:, 1].max() <= ceiling
    np.testing.assert_allclose(made.positions[-1], BOW[-1], atol=1e-9)


def test_joints_keep_limits_and_know_no_obstacles():
    joints = lt.JointTrajectory(TIMES, np.hstack([BOW, -BOW]))
    skill = lt.DMP().fit([lt.Demonstration(joints)])
    assert "obstacles" not in skill.supports
    limits = (np.full(6, -0.45), np.array([1.0, 0.03, 1.0, 1.0, 1.0, 1.0]))
    assert skill.generate(limits=limits).positions[:, 1].max() <= 0.03
    state = skill.begin()
    for _ in range(400):
        state = skill.step(state, 0.005, limits=limits)
        assert state.position[1] <= 0.03 + 1e-9
    with pytest.raises(UnsupportedQuery, match="obstacles"):
        skill.generate(obstacles=[WALL])


def test_ends_outside_the_limits_are_refused_by_name():
    limits = ((-1.0, -1.0, 0.0), (0.3, 1.0, 1.0))
    with pytest.raises(InvalidInput, match="goal"):
        SKILL.generate(limits=limits)
    with pytest.raises(InvalidInput, match="start"):
        SKILL.generate(limits=limits, start=(0.5, 0.0, 0.5), goal=(0.0, 0.0, 0.5))
