"""The fastest motion along a path, random and hostile ones too: limits kept, nearly optimal."""

import importlib.util
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings
from refusals import raised, refused
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

import leadthrough as lt
from leadthrough.arm import JointLimits
from leadthrough.errors import LimitsInfeasible
from leadthrough.timing import TipSpeed, binding_limits, check_limits
from leadthrough.trajectories import Spline

PANDA = lt.Arm.load("panda").limits
MIDDLE = 0.5 * (PANDA.lower + PANDA.upper)


def with_jerk(share):
    return replace(PANDA, jerk=share * PANDA.jerk)


def random_spline(seed, *, spread=0.5, points=12):
    way = MIDDLE + np.random.default_rng(seed).uniform(-spread, spread, (points, 7))
    spline = CubicSpline(np.linspace(0.0, 1.0, points), way)
    return Spline(spline.x, spline.c[::-1].transpose(1, 0, 2))


def distance_to(path, q):
    """From each configuration to the nearest point of a path, past the foot on its tangent."""
    times = np.linspace(*path.domain, 20_000)
    fine, slopes = path.evaluate(times), path.evaluate(times, 1)
    _, near = cKDTree(fine).query(q, p=np.inf)
    offset, slope = q - fine[near], slopes[near]
    along = np.sum(offset * slope, axis=1) / np.sum(slope * slope, axis=1)
    return np.abs(offset - along[:, None] * slope).max()


def limits_of(joints, velocity=1.0, acceleration=2.0, jerk=20.0):
    full = np.ones(joints)
    names = tuple(f"j{i}" for i in range(joints))
    return JointLimits(
        names, -100 * full, 100 * full, velocity * full, acceleration * full, jerk * full
    )


@pytest.mark.parametrize("share", [1.0, 0.1, 0.02])
def test_random_splines_keep_all_limits_and_rest_at_both_ends(share):
    limits = with_jerk(share)
    for seed in range(8):
        path = random_spline(seed)
        motion = lt.retime(path, limits)
        report = check_limits(motion, limits)
        assert report.velocity.ratio <= 1.0 + 1e-6
        assert report.acceleration.ratio <= 1.0 + 1e-6
        assert report.jerk.ratio <= 1.0 + 1e-5
        assert not motion.velocities[[0, -1]].any()
        np.testing.assert_allclose(
            motion.positions[[0, -1]], path.evaluate(path.domain), atol=1e-12
        )
        np.testing.assert_allclose(np.diff(motion.times), 1e-3, rtol=1e-9)
        assert distance_to(path, motion.positions[::200]) < 1e-6  # curvature within the fine steps


def test_short_and_twisty_paths_with_little_jerk_are_not_crept_along():
    free = replace(PANDA, jerk=np.full(7, np.inf))
    ratios = []
    for seed in range(5):
        path = random_spline(seed, spread=0.03)
        motion = lt.retime(path, with_jerk(0.02))
        assert check_limits(motion, with_jerk(0.02)).ok
        ratios.append(motion.duration / lt.retime(path, free).duration)
    assert np.median(ratios) < 1.95


def test_a_path_is_passed_in_the_same_way_backwards():
    way = MIDDLE + np.random.default_rng(3).uniform(-0.4, 0.4, (6, 7))
    there, back = (lt.retime(points, PANDA, blend=0.05) for points in (way, way[::-1]))
    assert there.duration == pytest.approx(back.duration, rel=5e-3)


def test_the_parameter_of_a_path_may_begin_anywhere():
    path = random_spline(4)
    later = Spline(path.knots + 64.0, path.coefficients)
    one, two = (lt.retime(each, PANDA) for each in (path, later))
    assert one.duration == pytest.approx(two.duration, rel=1e-6)


@pytest.mark.parametrize("timed", [lt.retime, lt.keep_timing])
def test_a_log_with_times_since_1970_is_timed_as_from_zero(timed):
    times = np.arange(0.0, 1.0, 0.01)
    path = random_spline(4).evaluate(times)
    early, late = (
        timed(lt.JointTrajectory(first + times, path, joint_names=PANDA.joint_names), PANDA)
        for first in (0.0, 1.7e9)
    )
    assert check_limits(late, PANDA).ok
    np.testing.assert_allclose(late.times, early.times, atol=1e-3)


def test_a_mirrored_path_takes_the_same_time_to_the_bit():
    limits = limits_of(7, jerk=0.4)
    for seed in range(3):
        way = np.random.default_rng(seed).uniform(-0.03, 0.03, (8, 7))
        spline = CubicSpline(np.linspace(0.0, 1.0, 8), way)
        pieces = spline.c[::-1].transpose(1, 0, 2)
        one, two = (lt.retime(Spline(spline.x, sign * pieces), limits) for sign in (1.0, -1.0))
        assert (one.times == two.times).all()
        assert (one.positions == -two.positions).all()


def test_the_same_path_gives_the_same_bits():
    one, two = (lt.retime(random_spline(1), PANDA) for _ in range(2))
    assert (one.positions == two.positions).all()


@pytest.mark.parametrize("rate", [20.0, 100.0, 250.0, 999.0, 4000.0])
def test_any_rate_keeps_the_limits(rate):
    motion = lt.retime(random_spline(2), PANDA, rate=rate)
    assert check_limits(motion, PANDA).ok
    np.testing.assert_allclose(np.diff(motion.times), 1.0 / rate, rtol=1e-9)
    assert motion.duration < 1.02 * lt.retime(random_spline(2), PANDA).duration + 1.0 / rate


def test_given_velocities_are_met_at_both_ends():
    path = random_spline(4)
    start, end = (
        share * slope / np.abs(slope / PANDA.velocity).max()
        for share, slope in zip((0.3, 0.2), path.evaluate(path.domain, 1), strict=True)
    )
    motion = lt.retime(path, PANDA, start_velocity=start, end_velocity=end)
    np.testing.assert_allclose(motion.velocities[0], start, atol=1e-12)
    np.testing.assert_allclose(motion.velocities[-1], end, atol=1e-12)
    np.testing.assert_allclose(motion.positions[[0, -1]], path.evaluate(path.domain), atol=1e-12)
    assert motion.duration < lt.retime(path, PANDA).duration
    for order, limit in enumerate((PANDA.velocity, PANDA.acceleration, PANDA.jerk), 1):
        differences = np.diff(motion.positions[:-1], order, axis=0) / 1e-3**order
        assert (np.abs(differences) <= limit * (1.0 + 1e-5)).all()
    assert 0.5e-3 <= motion.times[-1] - motion.times[-2] <= 1.5e-3


def test_velocities_and_speeds_off_the_path_or_too_fast_are_refused():
    for jacobian in [None, 3.0]:
        refused("jacobian", TipSpeed, 0.1, jacobian)
        refused("tip_speed", TipSpeed, 0.0, lambda q: q)
    path = random_spline(4)
    slope = path.evaluate(0.0, 1)
    along = slope / np.abs(slope / PANDA.velocity).max()
    for wrong in (-0.1 * along, 0.1 * along * [1, 1, 1, 1, 1, 1, -1]):
        refused("start_velocity", lt.retime, path, PANDA, start_velocity=wrong)
    with pytest.raises(LimitsInfeasible):
        lt.retime(path, PANDA, start_velocity=1.5 * along)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_refused_velocity_names_the_joint_nearest_its_limit_whichever_way_it_moves(way):
    limits = lt.arm.JointLimits(["a", "b"], [-9, -9], [9, 9], [2, 1], [9, 9], [99, 99])
    line = np.array([[0.0, 0.0], [1.0, way]])
    error = raised(LimitsInfeasible, lt.retime, line, limits, start_velocity=3.0 * line[1])
    assert error.joint == "b"


def test_corners_stop_or_are_cut():
    way = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    limits = limits_of(2)
    stopped, cut = lt.retime(way, limits), lt.retime(way, limits, blend=0.05)
    at_corner = np.abs(stopped.positions - way[1]).max(axis=1).argmin()
    np.testing.assert_allclose(stopped.positions[at_corner], way[1], atol=1e-9)
    np.testing.assert_allclose(stopped.velocities[at_corner], 0.0, atol=1e-9)
    assert cut.duration < stopped.duration
    miss = np.abs(cut.positions - way[1]).max(axis=1).min()
    assert 0.01 < miss <= 0.0505  # no sample lies in the middle of the cut
    off_the_lines = np.minimum(np.abs(cut.positions[:, 1]), np.abs(cut.positions[:, 0] - 1.0))
    assert off_the_lines.max() <= 0.05 + 1e-9
    assert check_limits(cut, limits).ok
    assert check_limits(stopped, limits).ok


def test_way_points_on_a_line_are_no_corners():
    limits = limits_of(2)
    direct = lt.retime([[0.0, 0.0], [1.0, 0.5]], limits)
    through = lt.retime([[0.0, 0.0], [0.2, 0.1], [0.2, 0.1], [1.0, 0.5]], limits)
    assert through.duration == pytest.approx(direct.duration, abs=1e-3)


def test_holds_rest_at_their_way_points():
    way = np.array([[0.0, 0.0], [1.0, 0.2], [1.0, 1.0]])
    limits = limits_of(2)
    plain = lt.retime(way, limits)
    held = lt.retime(way, limits, dwell_times={0: 0.1, 1: 0.5, 2: 0.2})
    assert held.duration == pytest.approx(plain.duration + 0.8, abs=1e-9)
    at_corner = np.abs(held.positions - way[1]).max(axis=1) < 1e-9
    assert at_corner.sum() >= 500
    assert check_limits(held, limits).ok
    np.testing.assert_allclose(np.diff(held.times), 1e-3, rtol=1e-6)


def test_holds_of_a_motion_that_rests_already_are_rests_there():
    ease = np.linspace(0.0, 1.0, 41) ** 2 * (3.0 - 2.0 * np.linspace(0.0, 1.0, 41))
    corners = np.array([[0.0, 0.0], [1.0, 0.2], [1.0, 1.0], [0.0, 1.0], [0.0, 1.0], [0.0, 0.0]])
    way = np.concatenate([one + np.outer(ease, two - one) for one, two in pairwise(corners)])
    moving = lt.JointTrajectory(np.arange(205) / 40.0, way)
    plain = lt.retime(moving, limits_of(2), dwell_times={40: 0.0, 81: 0.0, 123: 0.0, 160: 0.0})
    held = lt.retime(moving, limits_of(2), dwell_times={40: 0.1, 81: 0.3, 123: 0.2, 160: 0.6})
    assert held.duration == pytest.approx(plain.duration + 1.2, abs=1e-9)
    for point, rest in ((corners[1], 0.1), (corners[2], 0.3), (corners[3], 0.8)):
        still = np.abs(held.positions - point).max(axis=1) < 1e-9
        assert still.sum() == pytest.approx(1000 * rest, abs=60)  # and what is near


def test_the_path_stays_within_the_tolerance_of_the_samples():
    rng = np.random.default_rng(5)
    times = np.linspace(0.0, 5.0, 1001)
    q = 0.5 * np.sin(np.outer(times, [1.0, 1.7, 0.4])) + rng.normal(0.0, 2e-6, (1001, 3))
    motion = lt.retime(lt.JointTrajectory(times, q), limits_of(3), path_tolerance=1e-5)
    dense = CubicSpline(times, q)(np.linspace(0.0, 5.0, 100_001))
    assert cKDTree(dense).query(motion.positions[::100], p=np.inf)[0].max() < 1e-5 + 2e-5
    np.testing.assert_allclose(motion.positions[[0, -1]], q[[0, -1]], rtol=0.0, atol=1e-8)


def test_standing_still_takes_no_time():
    times = np.linspace(0.0, 6.0, 301)
    go = np.clip(times, 0.0, 1.0) + np.clip(times - 5.0, 0.0, 1.0)
    q = np.column_stack([np.sin(0.5 * go), np.cos(0.7 * go)])
    motion = lt.retime(lt.JointTrajectory(times, q), limits_of(2))
    straight = lt.retime(
        lt.JointTrajectory(times[:101], q[[*range(51), *range(251, 301)]]), limits_of(2)
    )
    assert motion.duration < 1.5 * straight.duration


def test_the_tip_keeps_its_speed_limit():
    arm = lt.Arm.load("panda")
    path = random_spline(6, spread=0.3)
    motion = lt.retime(path, arm.limits, tip_speed=TipSpeed(0.25, arm.jacobian), rate=200.0)
    rows = zip(motion.positions, motion.velocities, strict=True)
    speeds = [np.linalg.norm(arm.jacobian(q)[:3] @ v) for q, v in rows]
    assert 0.24 < max(speeds) <= 0.25 * (1.0 + 1e-3)
    assert motion.duration > lt.retime(path, arm.limits).duration


def test_efforts_keep_their_limits():
    mass, length = 2.0, 0.5

    def pendulum(q, qd, qdd):
        return mass * length**2 * qdd + mass * 9.81 * length * np.sin(q)

    limits = JointLimits(("j",), [-9.0], [9.0], [5.0], [50.0], [5000.0], effort=[12.0])
    motion = lt.retime([[-1.0], [1.0]], limits, inverse_dynamics=pendulum)
    efforts = np.abs(pendulum(motion.positions, motion.velocities, motion.accelerations))
    assert 11.0 < efforts.max() <= 12.0 * (1.0 + 1e-3)
    told = binding_limits(motion, limits, inverse_dynamics=pendulum)
    assert max(b.ratio for b in told if b.kind == "torque") == pytest.approx(efforts.max() / 12.0)
    with pytest.raises(LimitsInfeasible, match="cannot hold"):
        lt.retime(
            [[-2.0], [2.0]],
            JointLimits(("j",), [-9], [9], [5], [50], [5000], effort=[9.0]),
            inverse_dynamics=pendulum,
        )


def test_the_panda_s_torques_keep_their_limits():
    arm = lt.Arm.load("panda")
    path = random_spline(7)
    limits = replace(arm.limits, effort=0.6 * arm.limits.effort)
    free = lt.retime(path, limits, rate=200.0)
    kept = lt.retime(path, limits, rate=200.0, inverse_dynamics=arm.inverse_dynamics)
    shares = []
    for motion in (free, kept):
        torques = arm.inverse_dynamics(motion.positions, motion.velocities, motion.accelerations)
        shares.append(np.abs(torques / limits.effort).max())
    assert shares[0] > 1.05
    assert 0.95 < shares[1] <= 1.0 + 1e-3
    assert kept.duration > free.duration


def test_nothing_to_move_gives_one_sample_and_holds_are_kept():
    motion = lt.retime(np.zeros((3, 2)), limits_of(2))
    assert motion.positions.tolist() == [[0.0, 0.0]]
    assert lt.retime(
        np.zeros((3, 2)), limits_of(2), dwell_times={1: 0.5}
    ).duration == pytest.approx(0.5)
    still = lt.JointTrajectory([0.0, 1.0], np.ones((2, 2)))
    assert lt.retime(still, limits_of(2)).duration == 0.0


def test_a_path_from_limit_to_limit_is_inside_them():
    limits = replace(limits_of(2), lower=np.array([-1.0, 0.0]), upper=np.array([1.0, 0.3]))
    span = limits.upper - limits.lower
    path = Spline([0.0, 1.0], np.array([[limits.lower, 0.0 * span, 3.0 * span, -2.0 * span]]))
    motion = lt.retime(path, limits)
    np.testing.assert_allclose(motion.positions[-1], limits.upper, atol=1e-9)
    assert check_limits(motion, limits).ok


def test_what_limits_a_motion_is_told_by_joint_and_kind():
    limits = limits_of(2, velocity=1.0, acceleration=2.0, jerk=2000.0)
    motion = lt.retime([[0.0, 0.0], [3.0, 0.3]], limits)
    bindings = binding_limits(motion, limits)
    assert {b.joint for b in bindings if b.ratio > 0.9} == {"j0"}
    longest = max(bindings, key=lambda b: b.end - b.start)
    assert (longest.kind, longest.joint) == ("velocity", "j0")
    assert longest.ratio == pytest.approx(1.0, abs=1e-3)
    assert bindings[0].start == motion.times[0]
    assert bindings[-1].end == motion.times[-1]
    slow = lt.JointTrajectory(10.0 * motion.times, motion.positions)
    assert not any(binding.binds for binding in binding_limits(slow, limits))
    assert all(binding.binds == (binding.ratio >= 0.95) for binding in bindings)


@settings(max_examples=40)
@given(
    seed=st.integers(0, 2**31),
    joints=st.integers(1, 8),
    points=st.integers(2, 8),
    scale=st.floats(1e-4, 10.0),
    jerk=st.floats(0.5, 1e4),
)
def test_any_polyline_keeps_its_limits(seed, joints, points, scale, jerk):
    rng = np.random.default_rng(seed)
    limits = limits_of(
        joints, velocity=rng.uniform(0.1, 3.0), acceleration=rng.uniform(0.5, 20.0), jerk=jerk
    )
    way = scale * rng.normal(size=(points, joints))
    motion = lt.retime(way, limits, blend=0.1 * scale, rate=200.0)
    report = check_limits(motion, limits)
    assert max(report.velocity.ratio, report.acceleration.ratio, report.jerk.ratio) < 1.0 + 1e-5


@pytest.mark.parametrize(
    ("change", "match"),
    [
        ({"path": [[0.0, np.nan]]}, "path"),
        ({"path": np.empty((0, 2))}, "path"),
        ({"path": [0.0, 1.0]}, "path"),
        ({"path": np.zeros((3, 3))}, "limits"),
        ({"limits": None}, "limits"),
        ({"rate": 0.0}, "rate"),
        ({"rate": np.inf}, "rate"),
        ({"path_tolerance": -1.0}, "path_tolerance"),
        ({"blend": np.nan}, "blend"),
        ({"dwell_times": {5: 1.0}}, "dwell_times"),
        ({"dwell_times": {1: -1.0}}, "dwell_times"),
        ({"dwell_times": [1.0]}, "dwell_times"),
        ({"start_velocity": [1.0]}, "start_velocity"),
        ({"tip_speed": 0.1}, "tip_speed"),
        ({"tip_speed": TipSpeed(0.1, lambda q: np.full((3, len(q)), np.nan))}, "jacobian"),
        ({"tip_speed": TipSpeed(0.1, lambda q: q)}, "jacobian"),
        ({"inverse_dynamics": 3}, "inverse_dynamics"),
        ({"inverse_dynamics": lambda *state: state[2]}, "effort"),
    ],
)
def test_wrong_arguments_are_named(change, match):
    arguments = {"path": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], "limits": limits_of(2), **change}
    refused(match, lt.retime, arguments.pop("path"), arguments.pop("limits"), **arguments)


def test_limits_that_no_motion_keeps_are_infeasible():
    stuck = JointLimits(("a", "b"), [-1, -1], [1, 1], [1, 0], [1, 1], [1, 1])
    with pytest.raises(LimitsInfeasible, match="b \\(velocity\\)") as caught:
        lt.retime([[0.0, 0.0], [0.5, 0.5]], stuck)
    assert caught.value.joint == "b"
    assert lt.retime([[0.0, 0.2], [0.5, 0.2]], stuck).duration > 0.5
    with pytest.raises(LimitsInfeasible, match="a leaves its position"):
        lt.retime([[0.0, 0.0], [1.5, 0.0]], stuck)


def test_infinite_limits_do_not_bind():
    inf = np.inf
    fast = JointLimits(("j",), [-9], [9], [inf], [2.0], [inf])
    assert lt.retime([[0.0], [2.0]], fast).duration == pytest.approx(2.0, rel=0.01)
    free = JointLimits(("a", "b"), [-9, -9], [9, 9], [inf, 1], [inf, 1], [inf, 1])
    refused("finite limit", lt.retime, [[0.0, 0.0], [1.0, 0.0]], free)


BENCHMARKS = Path(__file__).parents[3] / "python" / "benchmarks"


@pytest.fixture(scope="module")
def random_paths():
    spec = importlib.util.spec_from_file_location("random_paths", BENCHMARKS / "random_paths.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["random_paths"] = module  # its dataclass looks itself up there
    spec.loader.exec_module(module)
    return module


ONCE_WRONG = (303, 325, 389, 609, 1153, 1469, 1863)  # refused, exceeding limits or crept along


@pytest.mark.parametrize("seeds", [*(range(i, i + 100) for i in (0, 100, 200)), ONCE_WRONG])
def test_random_paths_are_timed_and_keep_their_limits(random_paths, seeds):
    for seed in seeds:
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


def test_limits_that_are_missing_or_never_kept_are_refused():
    limits = JointLimits(("j",), [-1.0], [1.0], [1.0], [1.0])
    refused(r"(?s)jerk limits, got none.*\[joints\].*\"j\" =", lt.retime, [[0.0], [0.5]], limits)
    slow = limits_of(1, velocity=1e-9)
    refused("samples", lt.retime, [[0.0], [2.0]], slow)


def hand_motion(seed, limits, *, joint_at_limit=False, noise=0.0):
    """A smooth motion of all joints at 100 Hz; one of them may rest at its upper limit."""
    rng, u = np.random.default_rng(seed), np.linspace(0.0, 1.0, 300)[:, None]
    middle = 0.5 * (np.maximum(limits.lower, -7.0) + np.minimum(limits.upper, 7.0))
    waves = [rng.normal(size=len(middle)) * 0.1 * np.sin(np.pi * k * u) for k in (1, 2, 3)]
    q = middle + sum(waves) + 0.3 * rng.normal(size=len(middle)) * u
    if joint_at_limit:
        arrives = np.clip(1.0 - u[:, 0] / 0.7, 0.0, 1.0) ** 3
        leaves = np.clip((u[:, 0] - 0.3) / 0.7, 0.0, 1.0) ** 3
        pressed = np.clip(0.2 * np.sin(2.0 * np.pi * u[:, 0]), 0.0, None)
        joint = seed % 5  # the last one of the UR3 has no limit
        q[:, joint] = limits.upper[joint] - (arrives, leaves, pressed)[seed % 3]
    q = np.clip(q + noise * rng.normal(size=q.shape), limits.lower, limits.upper)
    return lt.JointTrajectory(3.0 * u[:, 0], q)


@pytest.mark.parametrize("robot", ["ur3", "panda"])
@pytest.mark.parametrize("rate", [100.0, 1000.0])
def test_recordings_that_rest_at_a_limit_are_legal(robot, rate):
    limits = lt.Arm.load(robot).limits
    for seed in range(6):
        given = hand_motion(seed, limits, joint_at_limit=True, noise=(0.0, 1e-5)[seed % 2])
        motion = lt.retime(given, limits, rate=rate)
        assert check_limits(motion, limits).ok
        np.testing.assert_allclose(motion.positions[[0, -1]], given.positions[[0, -1]], atol=1e-9)


def test_a_long_recording_stays_within_the_tolerance_and_more_never_takes_longer():
    times = np.linspace(0.0, 120.0, 24_000)
    phases = np.outer(times, np.linspace(0.3, 0.6, 7)) + np.arange(7)
    tremor = 2e-4 * np.sin(80.0 * phases)
    q = 0.5 * (PANDA.lower + PANDA.upper) + 0.3 * np.sin(phases) + tremor
    given = lt.JointTrajectory(times, q)
    durations = []
    for tolerance in (1e-5, 2e-4, 1e-3):
        motion = lt.retime(given, PANDA, rate=500.0, path_tolerance=tolerance)
        durations.append(motion.duration)
        assert check_limits(motion, PANDA).ok
        steps = np.linspace(0.0, motion.duration, 4 * len(motion.times))
        fine = np.column_stack([np.interp(steps, motion.times, q) for q in motion.positions.T])
        missed, _ = cKDTree(fine).query(given.positions, p=np.inf)
        assert missed.max() <= tolerance + np.abs(np.diff(fine, axis=0)).max()
    assert (np.diff(durations) <= 1e-9).all()
    assert durations[-1] < 0.9 * durations[0]  # the tremor is not followed


@pytest.mark.parametrize("seed", range(2))
def test_more_path_tolerance_never_takes_longer_and_is_a_tube(seed):
    given = hand_motion(seed, PANDA, noise=3e-4)
    durations = []
    for tolerance in (1e-5, 3e-4, 7e-4, 3e-3):
        motion = lt.retime(given, PANDA, rate=500.0, path_tolerance=tolerance)
        durations.append(motion.duration)
        assert check_limits(motion, PANDA).ok
        steps = np.linspace(0.0, motion.duration, 20 * len(motion.times))
        fine = np.column_stack([np.interp(steps, motion.times, q) for q in motion.positions.T])
        missed, _ = cKDTree(fine).query(given.positions, p=np.inf)
        assert missed.max() <= tolerance + np.abs(np.diff(fine, axis=0)).max()
    assert (np.diff(durations) <= 1e-9).all()
    assert durations[-1] < 0.7 * durations[0]  # the noise is not followed


@pytest.mark.parametrize("seed", [1, 2])
def test_corners_of_a_recording_slow_it_down_nowhere_else(seed):
    """The whole takes no longer than its smooth parts one after the other, from rest to rest."""
    rng, times, cuts = np.random.default_rng(seed), 0.004 * np.arange(5000), [1200, 2500, 3900]
    q = MIDDLE + 0.3 * np.sin(2.0 * np.pi * rng.uniform(0.05, 0.15, 7) * times[:, None])
    for at in cuts:
        since = np.maximum(times - times[at], 0.0)[:, None]
        q = q + rng.normal(0.0, 0.3, 7) * since * np.exp(-since)
    timed = lt.retime(lt.JointTrajectory(times, q), PANDA, rate=500.0)
    parts = (slice(a, b + 1) for a, b in pairwise([0, *cuts, len(q) - 1]))
    alone = [
        lt.retime(lt.JointTrajectory(times[part], q[part]), PANDA, rate=500.0).duration
        for part in parts
    ]
    assert timed.duration < 1.01 * sum(alone)
    assert check_limits(timed, PANDA).ok
    shown = CubicSpline(times, q)(np.linspace(0.0, times[-1], 100_000))
    assert cKDTree(shown).query(timed.positions)[0].max() < 3e-4  # of samples 1e-4 apart
