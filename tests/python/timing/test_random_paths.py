"""Random and hostile paths: none is refused, none exceeds a limit; what nearly coincides is one."""

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.arm.limits import JointLimits
from leadthrough.errors import InvalidInput, LimitsInfeasible
from leadthrough.timing import check_limits

BENCHMARKS = Path(__file__).parents[3] / "python" / "benchmarks"
PANDA = lt.Arm.load("panda").limits


@pytest.fixture(scope="module")
def random_paths():
    spec = importlib.util.spec_from_file_location("random_paths", BENCHMARKS / "random_paths.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["random_paths"] = module  # where its dataclass looks for it
    spec.loader.exec_module(module)
    return module


def limits_of(joints, velocity=1.0, acceleration=2.0, jerk=20.0):
    full = np.ones(joints)
    names = tuple(f"j{i}" for i in range(joints))
    return JointLimits(
        names, -100 * full, 100 * full, velocity * full, acceleration * full, jerk * full
    )


@pytest.mark.parametrize("first", [0, 100, 200])
def test_random_paths_are_timed_and_keep_their_limits(random_paths, first):
    for seed in range(first, first + 100):
        one = random_paths.case(seed)
        motion = lt.retime(one.path, one.limits, **one.options)
        assert random_paths.excess(motion, one.limits) <= 1e-6, seed
        np.testing.assert_allclose(np.diff(motion.times), 1.0 / one.options["rate"], rtol=1e-6)
        if isinstance(one.path, np.ndarray):
            blend = one.options.get("blend", 0.0)
            between = np.abs(np.diff(motion.positions, axis=0)).max() if blend else 0.0
            miss = missed(one.path, motion.positions, in_order=not blend)
            assert miss <= blend + between + 4e-9, seed  # those merged lie that far apart


def missed(way, q, *, in_order):
    """How far from the samples, joined by straight lines, the way-points lie at most."""
    first, worst = 0, 0.0
    for point in way:
        begin, step = q[first:-1], np.diff(q[first:], axis=0)
        squared = np.maximum(np.sum(step * step, axis=1), 1e-300)
        share = np.clip(np.sum((point - begin) * step, axis=1) / squared, 0.0, 1.0)
        away = np.abs(begin + share[:, None] * step - point).max(axis=1)
        away = np.append(away, np.abs(q[-1] - point).max())
        worst = max(worst, away.min())
        if in_order:
            first += min(int(np.argmax(away <= max(away.min(), 4e-9))), len(away) - 2)
    return worst


@pytest.mark.parametrize("seed", [22, 303, 325, 389, 609, 1153, 1469, 1863])
def test_paths_that_were_once_refused_exceeded_or_crept_along(random_paths, seed):
    one = random_paths.case(seed)
    motion = lt.retime(one.path, one.limits, **one.options)
    assert random_paths.excess(motion, one.limits) <= 1e-6


@pytest.mark.parametrize("blend", [0.0, 0.01])
@pytest.mark.parametrize("offset", [0.0, 1e-16, 1e-12, 9e-10])
def test_way_points_that_nearly_coincide_are_one(offset, blend):
    way = [[0.0, 0.0], [offset, 0.0], [1.0, 1.0], [1.0, 1.0 + offset]]
    limits = limits_of(2)
    motion = lt.retime(way, limits, blend=blend, dwell_times={1: 0.2, 3: 0.1})
    plain = lt.retime([[0.0, 0.0], [1.0, 1.0]], limits, blend=blend)
    assert motion.duration == pytest.approx(plain.duration + 0.3, abs=1.1e-3)
    assert motion.positions[-1].tolist() == way[-1]


@pytest.mark.parametrize("step", [1e-8, 1e-7, 1e-6, 1e-5])
def test_way_points_close_to_each_other_cost_little_time(step):
    limits = limits_of(2)
    far = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]
    near = [[0.0, 0.0], [1.0, 0.0], [1.0 + step, step], [1.0, 1.0]]
    for blend in (0.0, 0.01):
        motion = lt.retime(near, limits, blend=blend)
        assert check_limits(motion, limits).ok
        assert motion.duration < lt.retime(far, limits).duration + 0.35


@pytest.mark.parametrize("size", [1e-13, 1e-11, 1e-9, 1e-7])
def test_tiny_motions_end_where_they_are_asked_to(size):
    way = 0.5 + size * np.array([[0.0, 0.0, 0.0], [1.0, 0.3, 0.0], [0.5, 1.0, 0.0]])
    for path in (way, way[:2], lt.JointTrajectory([0.0, 1.0, 2.0], way)):
        motion = lt.retime(path, limits_of(3))
        end = path.positions[-1] if isinstance(path, lt.JointTrajectory) else path[-1]
        np.testing.assert_allclose(motion.positions[-1], end, rtol=0.0, atol=1e-15)
        assert check_limits(motion, limits_of(3)).ok
        assert motion.duration < 0.2


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_narrow_turn_is_rested_at_rather_than_crept_along(side):
    limits = limits_of(2)
    way = side * np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1e-3]])
    stopping, cutting = (lt.retime(way, limits, blend=blend) for blend in (0.0, 1e-6))
    assert cutting.duration <= stopping.duration + 0.15
    assert check_limits(cutting, limits).ok


def test_jerks_before_and_after_a_rest_do_not_add_up():
    limits = limits_of(2, velocity=5.0, acceleration=40.0, jerk=9000.0)
    way = 1e-6 * np.array([[0, 0], [3, 0], [3, 5], [3, 5], [0, 5], [0, 9]], dtype=np.float64)
    motion = lt.retime(way, limits)
    standing = np.vstack([motion.positions[[0] * 3], motion.positions, motion.positions[[-1] * 3]])
    assert np.abs(np.diff(standing, 3, axis=0)).max() * 1e9 <= 9000.0 * (1.0 + 1e-6)


@pytest.mark.parametrize("rate", [100.0, 1000.0, 4000.0])
def test_straight_lines_take_the_time_of_the_double_s(rate):
    # Jerk, acceleration and velocity limits reached; the first two; the first alone.
    for distance, best in (
        (2.0, 2.0 / 1.0 + 1.0 / 2.0 + 2.0 / 20.0),
        (0.3, 0.1 + np.sqrt(0.1**2 + 4.0 * 0.3 / 2.0)),
        (0.002, 4.0 * np.cbrt(0.002 / (2.0 * 20.0))),
    ):
        motion = lt.retime([[0.0], [distance]], limits_of(1), rate=rate)
        assert best - 1e-9 <= motion.duration <= best + max(1.0 / rate, 1e-3) + 1e-9


def test_thousands_of_way_points_are_timed():
    rng = np.random.default_rng(0)
    middle = 0.5 * (PANDA.lower + PANDA.upper)
    way = middle + np.cumsum(0.002 * rng.normal(size=(4000, 7)), axis=0)
    motion = lt.retime(way, PANDA)
    assert check_limits(motion, PANDA).ok
    np.testing.assert_array_equal(motion.positions[[0, -1]], way[[0, -1]])


def test_the_samples_of_a_followed_path_are_timed():
    u = np.linspace(0.0, 1.0, 2001)
    middle, reach = 0.5 * (PANDA.lower + PANDA.upper), 0.1 * (PANDA.upper - PANDA.lower)
    q = middle + reach * np.sin(np.outer(u, np.arange(2.0, 9.0)) + np.arange(7))
    assert check_limits(lt.retime(lt.JointTrajectory(8.0 * u, q), PANDA), PANDA).ok


def test_way_points_beside_a_line_are_passed_where_the_line_would_miss_them():
    u = np.linspace(0.0, 1.0, 3000)
    way = np.column_stack([u, 1e-7 * np.sin(np.pi * u)])  # turns of 1e-10 each
    motion = lt.retime(way, limits_of(2))
    off = np.abs(motion.positions[:, 1] - 1e-7 * np.sin(np.pi * motion.positions[:, 0]))
    assert off.max() < 2e-9


def test_lines_without_a_limit_or_beyond_one_are_refused():
    inf = np.inf
    free = JointLimits(("a", "b"), [-9, -9], [9, 9], [inf, 1], [inf, 1], [inf, 1])
    with pytest.raises(InvalidInput, match="finite limit"):
        lt.retime([[0.0, 0.0], [1.0, 0.0]], free)
    stuck = JointLimits(("a", "b"), [-9, -9], [9, 9], [1, 0], [1, 1], [1, 1])
    with pytest.raises(LimitsInfeasible, match="b moves"):
        lt.retime([[0.0, 0.0], [1.0, 0.1]], stuck)
