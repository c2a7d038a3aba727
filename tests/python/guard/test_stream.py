"""A few of the adversarial streams; `adversary.py` runs as many as are asked for."""

import numpy as np
import pytest
from guard.adversary import HOMES, MARGIN, RATE, clear_obstacles, run_stream
from guard.judge import EXCESS, CoalScene, meeting, worst_use

import leadthrough as lt


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
