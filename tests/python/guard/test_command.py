"""`leadthrough guard`: files in, what may run out."""

import tracemalloc

import numpy as np
import pytest
from cli.command_line import facts
from guard.adversary import HOMES, MARGIN, RATE, clear_obstacles, run_stream
from guard.judge import EXCESS, CoalScene, meeting, worst_use

import leadthrough as lt

Q = HOMES["panda"]


@pytest.fixture
def written(tmp_path):
    """A motion of the Panda with a jump in it, as a table."""
    arm = lt.Arm.load("panda")
    times = 0.02 * np.arange(100)
    rows = Q + 0.1 * np.outer(1.0 - np.cos(np.pi * times), np.ones(7))
    rows[40:] += 0.2
    event = lt.Event(1.0, "closed")
    motion = lt.JointTrajectory(times, rows, joint_names=arm.joint_names, events=[event])
    lt.write_motion(motion, tmp_path / "jump.npz")
    return tmp_path


def guarded(folder, *words, code=0):
    """Printed facts about the motion with the jump."""
    files = (folder / "jump.npz", "-o", folder / "safe.npz")
    return facts("guard", *files, "--robot", "panda", *words, code=code)


def test_the_nearest_motion_that_is_allowed_is_written(written):
    found = guarded(written)
    assert (found["verdict"], found["safe"]) == ("changed", True)
    assert "panda_joint1 jumps at 0.800 s" in found["reasons"][0]
    motion = lt.read_motion(written / "safe.npz")
    arm = lt.Arm.load("panda")
    assert lt.check_limits(motion, arm.limits).ok
    assert np.array_equal(motion.positions[0], Q)
    assert motion.events[0].name == "closed"
    assert found["duration"] == pytest.approx(motion.times[-1])


@pytest.mark.parametrize("robot", ["panda", "ur3"])
def test_the_hinted_check_agrees_with_the_guard(tmp_path, robot):
    arm, times = lt.Arm.load(robot), 0.01 * np.arange(150)
    q = HOMES[robot] + 0.3 * np.outer(np.sin(3.0 * times), np.ones(len(arm.joint_names)))
    motion = lt.JointTrajectory(times, q, joint_names=arm.joint_names)
    lt.write_motion(motion, tmp_path / "moving.npz")
    files = (tmp_path / "moving.npz", "-o", tmp_path / "safe.npz")
    assert facts("guard", *files, "--robot", robot)["safe"]
    found = facts("check", tmp_path / "safe.npz", "--robot", robot)
    assert found["limits_kept"]


def test_nothing_runs_from_inside_an_obstacle_and_the_exit_code_says_so(written):
    tip = lt.Arm.load("panda").forward_kinematics(Q)[0]
    place = ",".join(f"{x:.4f}" for x in tip)
    found = guarded(written, "--obstacle", f"sphere:0.1@{place}", code=1)
    assert found["verdict"] == "braking"
    assert "obstacle 0" in found["reasons"][-1]


def test_where_not_even_standing_still_is_allowed_nothing_is_written(written):
    start = lt.read_motion(written / "jump.npz").positions[0]
    place = lt.Arm.load("panda").forward_kinematics(start)[0]
    ball = f"sphere:0.1@{','.join(map(str, place))}"
    found = guarded(written, "--obstacle", ball, code=1)
    assert (found["safe"], found["motion"]) == (False, "not written")
    assert not (written / "safe.npz").exists()


def test_a_way_leads_onto_the_motion_from_where_the_arm_is(written):
    here = Q + 0.2 * np.eye(7)[6]
    found = guarded(written, "--start", ",".join(map(str, here)))
    assert found["verdict"] == "changed"
    motion, arm = lt.read_motion(written / "safe.npz"), lt.Arm.load("panda")
    assert np.array_equal(motion.positions[0], here)
    assert lt.check_limits(motion, arm.limits).ok
    shown = lt.read_motion(written / "jump.npz")
    assert np.abs(motion.positions[-1] - shown.positions[-1]).max() < 1e-3
    assert motion.events[0].time > shown.events[0].time


@pytest.mark.parametrize("name", ["panda", "ur3"])
def test_no_stream_leaves_a_limit_touches_anything_or_ends_in_motion(name):
    arm = lt.Arm.load(name)
    meet = meeting(arm)
    for seed in range(3):
        rng = np.random.default_rng([11, seed])
        found = run_stream(arm, rng, lambda w: CoalScene(arm, name, w, meet), chunks=25)
        assert worst_use(found["positions"], arm.limits, RATE) <= 1.0 + EXCESS
        assert found["contacts"] == 0
        assert not np.ptp(found["positions"][-3:], axis=0).any()
        assert found["verdicts"]["changed"] > 0


@pytest.mark.parametrize("name", ["panda", "ur3"])
def test_good_chunks_pass_unchanged(name):
    """Overlapping windows of slow motions far from everything."""
    arm = lt.Arm.load(name)
    rng = np.random.default_rng(2)
    for _ in range(4):
        assert good_chunks_unchanged(arm, rng, HOMES[name]) == 14


def good_chunks_unchanged(arm, rng, q):
    """How many of 14 windows of a good motion pass to the bit."""
    goal = q + rng.uniform(-0.3, 0.3, len(q))
    joints = arm.joint_names
    motion = lt.retime(
        lt.JointTrajectory([0.0, 1.0], [q, goal], joint_names=joints), arm.limits, rate=RATE
    )
    slow = lt.JointTrajectory(motion.times * 3.0, motion.positions, joint_names=joints)
    times = np.arange(0.0, slow.times[-1], 1.0 / RATE)
    rows = slow.at(times)
    rows = np.concatenate([rows, np.repeat(rows[-1:], 200 - len(rows) % 100, axis=0)])
    world = [
        each
        for each in clear_obstacles(rng, arm, q, 20, 0.3)
        if arm.distance(rows, [each]).min() > 0.2
    ][:5]
    guard = lt.Guard(arm, lt.Scene(world, MARGIN), rate=RATE)
    guard.admit(q[None], q)
    passed = 0
    for start in range(0, 14):
        chunk = rows[start * 7 : start * 7 + 50]
        answer = guard.admit(chunk)
        passed += answer.verdict == "allowed" and np.array_equal(answer.motion.positions, chunk)
        for _ in range(7):
            guard.next()
    return passed


def test_a_long_log_takes_some_times_its_own_memory(tmp_path):
    """It took 21 times the memory of the log's positions: 740 MB for ten minutes at 1 kHz."""
    arm, times = lt.Arm.load("panda"), 0.001 * np.arange(60_000)
    q = Q + 0.1 * np.outer(1.0 - np.cos(0.5 * times), np.ones(7))
    log = lt.JointTrajectory(times, q, joint_names=arm.joint_names)
    lt.write_motion(log, tmp_path / "log.npz")
    tracemalloc.start()
    found = facts("guard", tmp_path / "log.npz", "-o", tmp_path / "safe.npz", "--robot", "panda")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found["verdict"] == "allowed"
    assert peak < 15 * q.nbytes
