"""Chunks of a policy followed at 1 kHz: late, overlapping, with gaps, relative, too fast."""

import copy

import numpy as np
import pytest
from guard.adversary import HOMES
from guard.judge import EXCESS, worst_use
from refusals import refused
from scipy.interpolate import BSpline

import leadthrough as lt
from leadthrough.guard.chunks import ChunkCurve
from leadthrough.guard.lerobot import ChunkStep

Q = HOMES["panda"]
RATE, POLICY = 1000.0, 30.0
SIZE = np.array([0.4, 0.1, 0.2, 0.2, 0.3, 0.2, 0.4])
POST = lt.Cylinder(0.05, 1.0, (0.45, -0.3, 0.5))


def wanted(times, pace=1.0):
    """The motion that the policy means, at rest at first."""
    turn = np.asarray(times)[..., None] * pace
    return Q + SIZE * (1.0 - np.cos(2.0 * np.pi * 0.4 * turn)) / 2.0


def rows_at(stamp, *, count=30, pace=1.0):
    return wanted(stamp + np.arange(count) / POLICY, pace)


def followed(chunks, arrivals, seconds, *, ticks=None):
    """The commands (n, joints), where chunks (arrival, stamp, rows) come in this order."""
    waiting, sent = list(arrivals), [chunks.guard.state.q]
    for tick in range(1, round(seconds * RATE) + 1) if ticks is None else ticks:
        while waiting and waiting[0][0] <= tick / RATE:
            chunks.put(waiting[0][2], waiting.pop(0)[1])
        sent.append(chunks.next(tick / RATE).q)
    return np.array(sent)


@pytest.fixture
def chunks(panda):
    follower = lt.guard.Chunks(lt.Guard(panda, rate=RATE), rate=POLICY)
    follower.start(Q)
    return follower


def coming(seconds, *, latency=0.1, every=0.5, **keywords):
    stamps = np.arange(0.0, seconds - 0.4, every)
    return [(stamp + latency, stamp, rows_at(stamp, **keywords)) for stamp in stamps]


def assert_kept(chunks, sent, obstacles=()):
    """Commands keep limits and margins, with those that follow if nothing comes any more."""
    arm, rest = chunks.guard.arm, copy.deepcopy(chunks)
    left = [rest.next().q for _ in range(4000)]
    assert np.array_equal(left[-1], left[-2])
    assert worst_use(np.concatenate([sent, left]), arm.limits, RATE) <= 1.0 + EXCESS
    assert arm.check(sent, obstacles).ok


def test_a_curve_is_the_b_spline_of_its_actions():
    rows = np.random.default_rng(0).normal(size=(9, 3))
    curve = ChunkCurve.of(rows, 2.0, 0.1)
    peer = BSpline(2.0 + 0.1 * np.arange(-3, 12), curve.points, 3)
    times = np.linspace(2.0, 2.8, 50)
    states = curve.states(times)
    for order in range(3):
        part = states[:, 3 * order : 3 * order + 3]
        assert np.allclose(part, peer(times, order), atol=1e-9)
    assert np.allclose(states[[0, -1], :3], rows[[0, -1]])


def test_chunks_on_time_are_followed_without_lag(panda, chunks):
    sent = followed(chunks, coming(4.0), 4.0)
    assert_kept(chunks, sent)
    times = np.arange(len(sent)) / RATE
    late = [np.abs(sent[1000:] - wanted(times[1000:] - lag)).mean() for lag in (-1e-3, 0.0, 1e-3)]
    assert np.argmin(late) == 1
    assert np.abs(sent[1000:] - wanted(times[1000:])).max() < 2e-3
    assert chunks.lag == 0.0


def test_a_seam_between_chunks_is_joined_smoothly(panda, chunks):
    first, second = rows_at(0.0), rows_at(0.5) + 0.03
    sent = followed(chunks, [(0.1, 0.0, first), (0.6, 0.5, second)], 0.95)
    assert_kept(chunks, sent)
    jerk = np.diff(sent, 3, axis=0) * RATE**3
    assert np.abs(jerk[300:]).max() < 0.1 * panda.limits.jerk.max()
    assert np.abs(sent[850] - wanted(0.85) - 0.03).max() < 2e-3


def test_nothing_more_comes_and_the_arm_stops_on_its_path(panda, chunks):
    sent = followed(chunks, [(0.1, 0.0, rows_at(0.0, count=24))], 1.5)
    assert_kept(chunks, sent)
    assert np.array_equal(sent[-1], sent[-100])
    path = wanted(np.linspace(0.0, 23 / POLICY, 400))
    gaps = np.linalg.norm(sent[500::10, None] - path, axis=2).min(axis=1)
    assert gaps.max() < 3e-3


@pytest.mark.parametrize("latency", [0.3, 0.8])
def test_a_late_chunk_is_joined_where_it_is_due(panda, chunks, latency):
    arrivals = coming(4.0, every=1.0)
    arrivals[2] = (2.0 + latency, 2.0, rows_at(2.0))
    sent = followed(chunks, arrivals, 3.7)
    assert_kept(chunks, sent)
    assert np.abs(sent[3600] - wanted(3.6)).max() < 2e-3


def test_periods_that_were_missed_are_caught_up(panda, chunks):
    ticks = [tick for tick in range(1, 3001) if not 1500 < tick <= 1521]
    sent = followed(chunks, coming(3.5), 3.0, ticks=ticks)
    assert_kept(chunks, sent)
    assert np.abs(sent[-1] - wanted(3.0)).max() < 2e-3


def test_too_fast_a_policy_is_followed_within_limits(panda, chunks):
    sent = followed(chunks, coming(3.0, pace=5.0), 3.0)
    assert_kept(chunks, sent)
    assert np.ptp(sent, axis=0)[0] > 0.5 * SIZE[0]


def test_an_obstacle_on_the_way_is_not_touched(panda):
    into = Q + np.linspace(0.0, 1.0, 45)[:, None] * [-0.8, 0.3, 0, 0.2, 0, 0, 0]
    assert not panda.check(into, [POST]).ok
    chunks = lt.guard.Chunks(lt.Guard(panda, [POST], rate=RATE), rate=POLICY)
    chunks.start(Q)
    sent = followed(chunks, [(0.1, 0.0, into)], 2.5)
    assert_kept(chunks, sent, [POST])
    assert chunks.guard.safe
    assert np.abs(sent[-1] - Q).max() > 0.1


def test_a_chunk_observed_before_the_one_followed_is_left_out(chunks):
    arrivals = coming(3.0)
    alone = copy.deepcopy(chunks)
    late = [*arrivals[:4], (1.75, 1.0, rows_at(1.0) + 0.05), *arrivals[4:]]
    assert np.array_equal(followed(chunks, late, 2.5), followed(alone, arrivals, 2.5))


def test_a_single_action_is_gone_to(panda, chunks):
    goal = Q + 0.1
    assert chunks.put(goal[None], 0.01) == 1
    sent = np.array([chunks.next().q for _ in range(1000)])
    assert_kept(chunks, sent)
    assert np.abs(sent[-1] - goal).max() < 1e-8


def test_an_arm_with_little_room_catches_up_with_late_chunks():
    """Its policy uses three quarters of a limit."""
    arm, size = lt.Arm.load("ur3"), np.array([1.2, 0.5, 0.5, 1.0, 1.3, 1.4])

    def meant(times):
        return HOMES["ur3"] + size * (1.0 - np.cos(0.74 * np.pi * times))[..., None] / 2.0

    follower = lt.guard.Chunks(lt.Guard(arm, rate=RATE), rate=POLICY)
    follower.start(HOMES["ur3"])
    delays = np.repeat([0.15, 0.8, 0.15], [4, 4, 12])
    stamps = 0.2 * np.arange(20)
    chunks = [meant(stamp + np.arange(30) / POLICY) for stamp in stamps]
    arrivals = sorted(zip(stamps + delays, stamps, chunks, strict=True), key=lambda each: each[0])
    sent = followed(follower, arrivals, 4.0)
    assert_kept(follower, sent)
    times = np.arange(len(sent)) / RATE
    assert np.abs(sent[3200:] - meant(times[3200:])).max() < 5e-3


@pytest.mark.parametrize("kind", ["relative", "delta"])
def test_relative_actions_are_of_the_joints_at_their_time(panda, kind):
    measured = Q + 0.001
    steps = np.tile(np.linspace(0.0, 0.005, 30)[:, None], 7)
    meant = measured + (np.cumsum(steps, axis=0) if kind == "delta" else steps)
    ends = []
    for actions, rows, at in (("absolute", meant, None), (kind, steps, measured)):
        chunks = lt.guard.Chunks(lt.Guard(panda, rate=RATE), rate=POLICY, actions=actions)
        chunks.start(Q)
        assert chunks.put(rows, 0.0, measured=at) == 29
        ends.append([chunks.next().q for _ in range(1200)])
    assert np.allclose(*ends, atol=1e-12)
    chunks.put(steps, chunks.time)
    assert np.abs(chunks.next().q - ends[1][-1]).max() < 1e-3


def test_poses_of_the_tip_are_followed(panda, chunks):
    poses = panda.forward_kinematics(rows_at(0.0, count=45))
    assert chunks.put_poses(*poses, 0.0) == 44
    sent = np.array([chunks.next().q for _ in range(1600)])
    assert_kept(chunks, sent)
    reached = panda.forward_kinematics(sent[-1])[0]
    assert np.linalg.norm(reached - poses[0][-1]) < 1e-3
    away = poses[0] + np.linspace(0.0, 3.0, 45)[:, None]
    assert 0 < chunks.put_poses(away, poses[1], chunks.time) < 30


@pytest.mark.parametrize("by", ["put", "put_poses"])
@pytest.mark.parametrize("between", [0, 10])
def test_the_chunk_observed_last_is_followed_whatever_came_last(panda, chunks, by, between):
    def put(offset, observed):
        rows = np.tile(Q + offset, (90, 1))
        given = (rows,) if by == "put" else panda.forward_kinematics(rows)
        return getattr(chunks, by)(*given, observed)

    followed(chunks, [], 1.0)
    order = [(0.002, 0.5), (-0.002, 0.0)]
    for offset, observed in order if between == 0 else reversed(order):
        assert put(offset, observed) > 0
        for _ in range(between):
            chunks.next()
    end, wanted = [chunks.next().q for _ in range(1000)][-1], Q + 0.002
    tips = [panda.forward_kinematics(q)[0] for q in (end, wanted)]
    assert np.linalg.norm(tips[0] - tips[1]) < 1e-4


def test_what_is_too_late_or_not_finite_is_left_out(chunks):
    followed(chunks, coming(2.0), 1.4)
    assert chunks.put(rows_at(0.0), 0.0) == 0
    assert chunks.put(np.full((30, 7), np.nan), 1.4) == 0
    assert chunks.put_poses(np.full((30, 3), np.nan), np.tile([1.0, 0, 0, 0], (30, 1)), 1.4) == 0
    assert np.abs(chunks.next(1.401).q - wanted(1.401)).max() < 2e-3
    assert chunks.stop().verdict == "braking"
    rest = [chunks.next().q for _ in range(600)]
    assert np.array_equal(rest[-1], rest[-2])


def test_bad_input_is_named(panda, chunks):
    refused("actions: expected", chunks.put, np.zeros((3, 2)), 0.0)
    refused("time: ", chunks.put, rows_at(0.0), np.nan)
    fresh = lt.guard.Chunks(lt.Guard(panda, rate=RATE), rate=POLICY)
    refused("expected `start`", fresh.put, rows_at(0.0), 0.0)
    refused("rate: ", lt.guard.Chunks, lt.Guard(panda, rate=RATE), rate=0.0)
    refused("actions: ", lt.guard.Chunks, lt.Guard(panda, rate=RATE), rate=30.0, actions="joint")


def test_a_step_of_a_pipeline_follows_chunks_by_motor_names(panda):
    clock = iter(np.arange(0.0, 10.0, 0.005))
    chunks = lt.guard.Chunks(lt.Guard(panda, rate=200.0), rate=POLICY)
    step = ChunkStep(chunks, unit="radians", clock=lambda: next(clock))
    names = [f"{name}.pos" for name in panda.joint_names]
    observation = dict(zip(names, Q, strict=True))
    first = {**dict(zip(names, rows_at(0.0).T, strict=True)), "gripper.pos": 1.0}
    out = step({"observation": observation, "action": first})
    assert out["action"]["gripper.pos"] == 1.0
    for _ in range(150):
        out = step({"observation": observation, "action": None})
    assert list(out["action"].values()) == pytest.approx(wanted(0.75), abs=2e-3)
    late = dict(zip(names, rows_at(0.7).T, strict=True))
    step({"action": late, "complementary_data": {"observed_at": 0.7}})
    for _ in range(100):
        out = step({"action": None})
    assert list(out["action"].values()) == pytest.approx(wanted(1.26), abs=2e-3)
