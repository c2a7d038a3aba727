"""Movement primitives against movement_primitives, with its compiled steps.

Both replay the same motion with 50 kernels per channel, and both are compared with the
demonstration. The orientation turns by 90 degrees, which the peer can follow as well.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from frame import Benchmark
from movement_primitives import dmp as peers

import leadthrough as lt

WEIGHTS = 50
SAMPLES = 1001
POSE_TOLERANCE = 0.01  # m and rad, mean
JOINT_TOLERANCE = 0.01  # rad, mean
PEER = "movement_primitives"
HAND = np.array([0.0, 0.15, 0.0])  # m, of the right hand in the object; the left one is opposite


def benchmarks(*, quick: bool) -> Iterator[Benchmark]:
    """Rows for fit, rollout, single steps and the planning of a subtask."""
    repeats = 3 if quick else 10
    shown = _pose_motion(1.0)
    skill = lt.DMP(weights=WEIGHTS).fit([lt.Demonstration(shown)])
    peer = _peer(shown)
    yield _fit(repeats)
    yield Benchmark(
        f"{repeats} pose rollouts of 1000 steps, 50 weights",
        ours=lambda: [_rows(skill.generate(dt=0.001)) for _ in range(repeats)][-1],
        peer=lambda: [peer.open_loop()[1] for _ in range(repeats)][-1],
        peer_name=PEER,
        error=lambda ours, theirs: max(_error(ours, shown), _error(theirs, shown)),
        tolerance=POSE_TOLERANCE,
    )
    yield Benchmark(
        "1000 single pose steps, 50 weights",
        ours=lambda: _step_through(skill),
        peer=lambda: _peer_steps(peer, shown),
        peer_name=PEER,
        error=lambda ours, theirs: max(_error(ours, shown), _error(theirs, shown)),
        tolerance=POSE_TOLERANCE,
    )
    yield _subtask(repeats)
    yield _carry()


def _fit(repeats: int) -> Benchmark:
    times = np.linspace(0.0, 1.0, SAMPLES)
    joints = (
        np.sin(np.outer(times, np.arange(1, 8)))
        * lt.trajectories.minimum_jerk_time_scaling(times)[:, None]
    )
    demonstration = lt.Demonstration(lt.JointTrajectory(times, joints))

    def ours() -> Any:
        skills = [lt.DMP(weights=WEIGHTS).fit([demonstration]) for _ in range(repeats)]
        return skills[-1].generate(dt=0.001).positions

    peer = peers.DMP(7, execution_time=1.0, dt=0.001, n_weights_per_dim=WEIGHTS)

    def theirs() -> Any:
        for _ in range(repeats):
            peer.imitate(times, joints)
        return peer.open_loop()[1]

    # Both times include the rollout that gives the answer, and `repeats` fits.
    return Benchmark(
        f"{repeats} fits of 7 joints, 1000 samples, 50 weights, and a rollout",
        ours=ours,
        peer=theirs,
        peer_name=PEER,
        error=lambda a, b: max(float(np.abs(x - joints).mean()) for x in (a, b)),
        tolerance=JOINT_TOLERANCE,
    )


def _subtask(repeats: int) -> Benchmark:
    shown = _pose_motion(10.0)
    skill = lt.DMP(weights=WEIGHTS).fit([lt.Demonstration(shown)])
    peer = _peer(shown)
    goal = _rows(shown)[-1] + np.array([0.02, 0.0, 0.02, 0.0, 0.0, 0.0, 0.0])
    peer.configure(goal_y=goal)
    return Benchmark(
        f"{repeats} x plan a subtask: 10 s at 100 Hz, new goal (one: paper 2.57 ms)",
        ours=lambda: [
            _rows(skill.generate(goal=(goal[:3], goal[3:]), dt=0.01)) for _ in range(repeats)
        ][-1],
        peer=lambda: [peer.open_loop()[1] for _ in range(repeats)][-1],
        peer_name=PEER,
        error=lambda ours, _: float(np.abs(ours[-1] - goal).max()),
        tolerance=1e-9,
    )


def _carry() -> Benchmark:
    """An object held by two hands, to a new goal: theirs couple the hands, ours move the object."""
    shown = _pose_motion(1.0)
    skill = lt.DMP(weights=WEIGHTS).fit([lt.Demonstration(shown)])
    goal = _rows(shown)[-1] + np.array([0.05, 0.05, 0.05, 0.0, 0.0, 0.0, 0.0])
    peer = peers.DualCartesianDMP(
        execution_time=1.0, dt=0.001, int_dt=0.001, n_weights_per_dim=WEIGHTS
    )
    peer.imitate(shown.times, _hands(_rows(shown)))
    peer.configure(goal_y=_hands(goal[None])[0])
    apart = np.eye(4)
    apart[:3, 3] = 2.0 * HAND
    coupling = peers.CouplingTermDualCartesianPose(apart, lf=(1, 1))

    def ours() -> Any:
        return _hands(_rows(skill.generate(goal=(goal[:3], goal[3:]), dt=0.001)))

    return Benchmark(
        "an object carried by two hands to a new goal, 1000 steps",
        ours=ours,
        peer=lambda: peer.open_loop(coupling_term=coupling)[1],
        peer_name=PEER,
        # The peer's hands drift apart by millimetres: ours are judged by what they have to keep.
        error=lambda hands, _: max(held_apart(hands), _goal_error(hands, goal)),
        tolerance=1e-9,
    )


def _hands(rows: Any) -> Any:
    """Poses (n, 14) of the left and the right hand of an object's poses (n, 7)."""
    away = lt.rotations.to_matrix(rows[:, 3:]) @ HAND
    turns = rows[:, 3:]
    return np.hstack([rows[:, :3] - away, turns, rows[:, :3] + away, turns])


def held_apart(hands: Any) -> float:
    """The largest error of the right hand's position as seen from the left one, m."""
    apart = hands[:, 7:10] - hands[:, :3]
    seen = np.einsum("nij,ni->nj", lt.rotations.to_matrix(hands[:, 3:7]), apart)
    return float(np.linalg.norm(seen - 2.0 * HAND, axis=1).max())


def _goal_error(hands: Any, goal: Any) -> float:
    return float(np.abs(hands[-1] - _hands(goal[None])[0])[[0, 1, 2, 7, 8, 9]].max())


def _pose_motion(duration: float) -> lt.PoseTrajectory:
    times = np.linspace(0.0, duration, SAMPLES)
    s = lt.trajectories.minimum_jerk_time_scaling(times / duration)
    positions = np.column_stack([0.3 * s, 0.1 * np.sin(2.0 * s), 0.2 * s**2])
    return lt.PoseTrajectory(times, positions, lt.rotations.exp(np.outer(s, [0.5, 1.0, 1.1])))


def _rows(motion: lt.PoseTrajectory) -> Any:
    return np.hstack([motion.positions, motion.orientations])


def _peer(shown: lt.PoseTrajectory) -> Any:
    dt = shown.duration / (SAMPLES - 1)
    peer = peers.CartesianDMP(
        execution_time=shown.duration, dt=dt, n_weights_per_dim=WEIGHTS, int_dt=dt
    )
    peer.imitate(shown.times, _rows(shown))
    return peer


def _error(rows: Any, shown: lt.PoseTrajectory) -> float:
    gaps = np.linalg.norm(rows[:, :3] - shown.positions, axis=1)
    return float(max(gaps.mean(), lt.rotations.distance(rows[:, 3:], shown.orientations).mean()))


def _step_through(skill: Any) -> Any:
    state = skill.begin()
    rows = np.empty((SAMPLES, 7))
    for i in range(SAMPLES):
        rows[i] = state.pose
        state = skill.step(state, 0.001)
    return rows


def _peer_steps(peer: Any, shown: lt.PoseTrajectory) -> Any:
    peer.reset()
    position, velocity = _rows(shown)[0].copy(), np.zeros(6)
    rows = np.empty((SAMPLES, 7))
    for i in range(SAMPLES):
        rows[i] = position
        position, velocity = peer.step(position, velocity)
    return rows
