"""Ctrl-C ends each of the calls that can take long, in a process of its own.

By hand, `python tests/python/test_interrupt.py` prints the time from the signal to the end of each.
"""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator

import numpy as np

import leadthrough as lt
from leadthrough import planning, preprocess, trajectories
from leadthrough_studies.damped_least_squares import damped_inverse_kinematics

AFTER = 0.3  # s; each call takes several
HOME = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])


def calls() -> Iterator[tuple[str, Callable[[], object]]]:
    """Calls that take several seconds each, by name."""
    rng = np.random.default_rng(1)
    walk = np.cumsum(rng.normal(size=(60_000, 3)), axis=0)
    yield "dtw_distance", lambda: preprocess.dtw_distance(walk, walk[::-1])
    yield "frechet_distance", lambda: preprocess.frechet_distance(walk, walk[::-1])

    arm = lt.Arm.load("panda")
    wave = HOME + 0.3 * np.sin(np.outer(np.linspace(0.0, 3000.0, 200_000), np.arange(1, 8) / 3.0))
    ball = lt.Sphere(0.1, (0.5, 0.2, 0.5))
    yield "Arm.check", lambda: arm.check(wave, [ball])
    yield "Arm.check on 2 threads", lambda: arm.check(wave, [ball], threads=2)
    yield "retime", lambda: lt.retime(wave, arm.limits)
    far = rng.uniform(-0.8, 0.8, (200_000, 3)), lt.rotations.exp(rng.normal(size=(200_000, 3)))
    yield "inverse_kinematics_batch", lambda: arm.inverse_kinematics_batch(*far)
    yield "the same on 2 threads", lambda: arm.inverse_kinematics_batch(*far, threads=2)
    yield "damped_inverse_kinematics", lambda: damped_inverse_kinematics(arm, *far, q0=HOME)
    poses = arm.forward_kinematics(wave)
    tip = lt.PoseTrajectory(np.linspace(0.0, 9000.0, len(wave)), *poses)
    yield "Arm.follow", lambda: [arm.follow(tip, q0=wave[0]) for _ in range(20)]

    speed = rng.uniform(0.1, 1.0, (200, 200, 200))
    yield "arrival_times", lambda: lt.arrival_times(speed, [(2, 2, 2)])
    yield "the same of order 2", lambda: lt.arrival_times(speed, [(2, 2, 2)], order=2)
    yield "nearest_sources", lambda: planning.nearest_sources(speed, [(2, 2, 2), (9, 9, 9)])

    through = trajectories.Lagrange(trajectories.chebyshev_nodes(200), rng.normal(size=(200, 3)))
    yield "Lagrange.evaluate", lambda: through.evaluate(np.linspace(-1.0, 1.0, 5_000_000))

    u = np.linspace(0.0, 1.0, 40)
    shown = [
        lt.Trajectory(u, np.column_stack([u + 0.1 * i * u**2, np.sin(3.0 * u)])) for i in range(3)
    ]
    promp, dmp = lt.ProMP(weights=8).fit(shown), lt.DMP(weights=10).fit(shown[:1])
    yield "ProMPSkill.sample", lambda: [promp.sample(100_000, seed=i) for i in range(50)]
    yield (
        "DMPSkill.generate",
        lambda: dmp.generate(dt=2e-7, obstacles=[lt.Sphere(0.05, (0.5, 0.9, 0.0))]),
    )


def seconds_to_end(call: Callable[[], object]) -> float:
    """Seconds from Ctrl-C to KeyboardInterrupt; nan if the call ended before."""
    sent = np.nan

    def interrupt() -> None:
        nonlocal sent
        sent = time.perf_counter()
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(AFTER, interrupt)
    timer.start()
    try:
        call()
    except KeyboardInterrupt:
        return time.perf_counter() - sent
    timer.cancel()
    return np.nan


def main() -> None:
    # A shell starts processes in the background with the signal ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for name, call in calls():
        print(f"{name}: {seconds_to_end(call):.2f} s", flush=True)


def test_ctrl_c_ends_every_long_call_by_a_keyboard_interrupt() -> None:
    done = subprocess.run(
        [sys.executable, __file__], capture_output=True, text=True, timeout=300, check=True
    )
    lines = done.stdout.splitlines()
    assert len(lines) == len(list(calls()))
    assert not [line for line in lines if line.endswith(" nan s")]


if __name__ == "__main__":
    main()
