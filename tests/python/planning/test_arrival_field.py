import threading

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import leadthrough as lt
from leadthrough.planning import ArrivalField

SHAPES = [(24, 31), (1, 40), (11, 13, 12), (7, 1, 9)]


def random_speed(rng, shape):
    if rng.random() < 0.3:
        return np.ones(shape)
    speed = 10.0 ** rng.uniform(-1.5, 0, shape)
    return np.where(rng.random(shape) < 0.1, 0.0, speed)


def random_part(rng, shape):
    ends = [np.sort(rng.choice(n + 1, 2, replace=False)) for n in shape]
    return tuple(slice(int(a), int(b)) for a, b in ends)


def assert_is_the_full_march(field, speed, cells, *, rtol, atol):
    times = lt.arrival_times(speed, cells, spacing=field.grid.spacing, dtype=field.times.dtype)
    np.testing.assert_allclose(field.times, times, rtol=rtol, atol=atol)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32))
def test_any_sequence_of_changes_gives_the_field_of_a_full_march(dtype, seed):
    rng = np.random.default_rng(seed)
    shape = SHAPES[seed % len(SHAPES)]
    grid = lt.Grid(np.zeros(len(shape)), rng.choice([1.0, 0.5, 1.7], len(shape)), shape)
    cells = np.array([[int(rng.integers(n)) for n in shape] for _ in range(1 + seed % 3)])
    speed = random_speed(rng, shape)
    speed[tuple(cells.T)] = 1.0
    field = ArrivalField(speed, grid, grid.points_at(cells.astype(float)), dtype=dtype)
    free = speed.copy()
    for _ in range(6):
        part = random_part(rng, shape)
        kind = rng.integers(4)
        if kind == 0:
            speed[part] = 0.0  # an obstacle appears
        elif kind == 1:
            speed[part] = free[part]  # one vanishes
        elif kind == 2:
            speed[part] *= rng.uniform(0.2, 6.0)
        else:  # one moves
            speed = np.where(speed == 0.0, free, speed)
            speed[part] = 0.0
        speed[tuple(cells.T)] = 1.0
        if rng.random() < 0.5:
            field.update(speed)
        else:
            whole = (slice(None),) * len(shape)
            field.update_part(part if kind < 3 else whole, speed[part if kind < 3 else whole])
            field.update(speed)
        unit = grid.spacing.min() / speed.max()  # the time over a cell
        rtol, atol = (1e-6, 0.0) if dtype == np.float64 else (1e-6, 2e-3 * unit)
        assert_is_the_full_march(field, speed, cells, rtol=rtol, atol=atol)


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_a_box_that_moves_through_a_large_map_is_repaired_every_time(dtype):
    shape, source = (200, 210), (30, 40)
    grid = lt.Grid((0.0, 0.0), 1.0, shape)
    x, y = np.moveaxis(grid.centres(), -1, 0)
    free = (0.6 + 0.4 * np.sin(0.05 * x) * np.cos(0.07 * y)).astype(dtype)
    field = ArrivalField(free, grid, source, dtype=dtype)
    kinds = set()
    for k in range(12):
        speed = free.copy()
        speed[100 + 5 * k : 115 + 5 * k, 150 - 5 * k : 170 - 5 * k] = 0.0
        kinds.add(field.update(speed).kind)
        assert_is_the_full_march(
            field, speed, source, rtol=1e-6 if dtype == np.float64 else 0.0, atol=2e-3
        )
    assert kinds == {"repair"}
    field.update(free)
    assert_is_the_full_march(field, free, source, rtol=1e-6, atol=0.0)


def test_a_wall_beside_the_source_is_marched_in_full_and_no_change_costs_nothing():
    grid = lt.Grid((0.0, 0.0), 1.0, (60, 60))
    field = ArrivalField(np.ones((60, 60)), grid, (5.0, 30.0))
    assert field.update(np.ones((60, 60))).kind == "none"
    speed = np.ones((60, 60))
    speed[8, 5:55] = 0.0
    assert field.update(speed).kind == "full_march"
    assert_is_the_full_march(field, speed, (5, 30), rtol=0.0, atol=0.0)


def test_a_few_invalid_cells_are_all_that_a_small_box_far_away_costs():
    grid = lt.Grid((0.0, 0.0, 0.0), 1.0, (40, 40, 40))
    field = ArrivalField(np.ones(grid.shape), grid, (2.0, 2.0, 2.0))
    update = field.update_part((slice(34, 37),) * 3, 0.0)
    assert update.kind == "repair"
    assert 27 <= update.invalidated < 400


def test_much_faster_cells_may_appear():
    grid = lt.Grid((0.0, 0.0), 1.0, (50, 50))
    speed = np.ones(grid.shape)
    field = ArrivalField(speed, grid, (5.0, 5.0))
    for factor in (3.0, 1e3, 1e9):
        speed[20:25, 10:40] = factor
        field.update(speed)
        assert_is_the_full_march(field, speed, (5, 5), rtol=1e-6, atol=0.0)


def test_arrays_handed_out_stay_as_they_are():
    grid = lt.Grid((0.0, 0.0), 1.0, (20, 20))
    speed = np.ones(grid.shape)
    field = ArrivalField(speed, grid, (2.0, 2.0))
    before, kept = field.times, field.times.copy()
    given = speed.copy()
    field.update_part((slice(10, 12), slice(0, 19)), 0.0)
    np.testing.assert_array_equal(before, kept)
    np.testing.assert_array_equal(speed, given)
    assert not before.flags.writeable
    assert field.times is not before
    assert (field.speed == 0.0).sum() == 38


def test_threads_may_share_a_field():
    grid = lt.Grid((0.0, 0.0), 1.0, (60, 60))
    field = ArrivalField(np.ones(grid.shape), grid, (2.0, 2.0))

    def blink(row):
        for value in (0.0, 1.0) * 10:
            field.update_part((slice(row, row + 3), slice(20, 40)), value)

    threads = [threading.Thread(target=blink, args=(row,)) for row in (20, 30, 40)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert_is_the_full_march(field, np.ones(grid.shape), (2, 2), rtol=1e-9, atol=0.0)
