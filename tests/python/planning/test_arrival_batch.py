import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.planning import arrival_times_batch


def problems(count):
    rng = np.random.default_rng(3)
    speeds = [
        np.where(rng.random((17, 18, 12)) < 0.1, 0.0, rng.uniform(0.3, 1.0)) for _ in range(count)
    ]
    for k, speed in enumerate(speeds):
        speed[k % 17, 3, 4] = 1.0
    return speeds, [(k % 17, 3, 4) for k in range(count)]


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_a_batch_has_the_bits_of_single_marches_whatever_the_threads(order, dtype):
    speeds, sources = problems(9)
    options = {"spacing": (1.0, 0.5, 2.0), "order": order, "dtype": dtype}
    expected = [
        lt.arrival_times(*problem, **options) for problem in zip(speeds, sources, strict=True)
    ]
    for threads in (1, 2, 5, 64):
        times = arrival_times_batch(speeds, sources, threads=threads, **options)
        np.testing.assert_array_equal(times, expected)


def test_one_map_serves_many_sources_and_one_source_many_maps():
    speeds, sources = problems(4)
    speed = np.ones_like(speeds[0])
    for k, times in enumerate(arrival_times_batch([speed], sources, threads=2)):
        np.testing.assert_array_equal(times, lt.arrival_times(speed, sources[k]))
    maps = [speed, 0.5 * speed]
    for k, times in enumerate(arrival_times_batch(np.array(maps), [[(1, 2, 3), (4, 4, 4)]])):
        np.testing.assert_array_equal(times, lt.arrival_times(maps[k], [(1, 2, 3), (4, 4, 4)]))


def test_bad_input_is_refused():
    speed = np.ones((5, 6))
    for name, arguments in {
        "sources: expected as many": ([speed] * 3, [(0, 0)] * 2),
        "sources": ([speed], [(9, 9)]),
        "speeds": ([speed, np.ones((6, 5))], [(0, 0)]),
        "speed: ": ([speed, -speed], [(0, 0)]),
        "speeds: expected a sequence": ([], []),
        "sources: expected a sequence": ([speed], None),
    }.items():
        with pytest.raises(InvalidInput, match=name):
            arrival_times_batch(*arguments)
    for name in ("threads", "order", "source_radius"):
        with pytest.raises(InvalidInput, match=name):
            arrival_times_batch([speed], [(0, 0)], **{name: -1})
