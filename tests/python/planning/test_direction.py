import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import leadthrough as lt
from leadthrough.errors import InvalidInput, NoPath
from leadthrough.planning import direction


@settings(max_examples=100, deadline=None)
@given(
    st.integers(0, 2**32), st.lists(st.integers(2, 14), min_size=2, max_size=3), st.floats(0.0, 0.4)
)
def test_policies_by_small_steps_reach_the_source_and_enter_no_wall(seed, shape, share):
    rng = np.random.default_rng(seed)
    d = len(shape)
    grid = lt.Grid(rng.normal(size=d), rng.uniform(0.5, 1.5, d), tuple(shape))
    start, goal = rng.integers(0, shape, (2, d))
    speed = np.where(rng.random(shape) < share, 0.0, 10.0 ** rng.uniform(-1, 0, shape))
    speed[tuple(goal)] = 1.0
    times = lt.arrival_times(speed, goal, spacing=grid.spacing, dtype=np.float32)
    if np.isinf(times[tuple(start)]):
        return
    p, end = grid.points_at([start, goal])
    length = 0.2 * grid.spacing.min()
    for _ in range(200 * times.size):
        vector = direction(times, grid, p[None])[0]
        if np.linalg.norm(p - end) < length:
            break
        assert np.linalg.norm(vector) == pytest.approx(1.0)
        p = p + length * vector
        assert np.isfinite(times[tuple(grid.cells_of(p[None])[0])])
    assert np.linalg.norm(p - end) < length
    assert not direction(times, grid, end[None]).any()


def test_in_free_space_directions_point_to_the_source():
    grid = lt.Grid((-1.0, 2.0), (0.1, 0.2), (60, 50))
    times = lt.arrival_times(np.ones(grid.shape), (20, 30), spacing=grid.spacing, order=2)
    goal = grid.points_at([(20.0, 30.0)])[0]
    points = grid.points_at(np.random.default_rng(1).uniform(0, np.array(grid.shape) - 1, (300, 2)))
    towards = (goal - points) / np.linalg.norm(goal - points, axis=1, keepdims=True)
    cosines = (direction(times, grid, points) * towards).sum(axis=1)
    assert np.quantile(cosines, 0.05) > 0.995
    assert cosines.min() > 0.8


def test_where_fronts_meet_there_is_a_direction_all_the_same():
    grid = lt.Grid((0.0, 0.0), 1.0, (21, 9))
    times = lt.arrival_times(np.ones(grid.shape), [(0, 4), (20, 4)])
    vectors = direction(times, grid, [(10.0, 4.0), (9.5, 4.0), (10.0, 4.3)])
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), 1.0)


def test_no_positions_have_no_directions():
    grid = lt.Grid((0.0, 0.0), 1.0, (5, 5))
    assert direction(np.zeros((5, 5)), grid, np.empty((0, 2))).shape == (0, 2)


def test_positions_without_a_direction_say_why(divided):
    for point, reason in divided.pathless.items():
        with pytest.raises(NoPath) as caught:
            direction(divided.times, divided.grid, [(1.0, 1.0), point])
        assert caught.value.reason == reason
        assert "positions[1]" in str(caught.value)


def test_bad_input_is_refused():
    grid = lt.Grid((0.0, 0.0), 1.0, (5, 5))
    times = lt.arrival_times(np.ones((5, 5)), (2, 2))
    bad = times.copy()
    bad[1, 1] = np.nan
    for name, arguments in {
        "positions": (times, grid, [(np.nan, 0.0)]),
        "arrival": (times[1:], grid, [(1.0, 1.0)]),
        "times >= 0": (bad, grid, [(1.2, 1.0)]),
    }.items():
        with pytest.raises(InvalidInput, match=name):
            direction(*arguments)
    with pytest.raises(InvalidInput, match="times >= 0"):
        direction(-times - 1.0, grid, [(1.2, 1.0)])
