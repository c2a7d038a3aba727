"""Inverse kinematics of the Panda: many single poses, then a circle without jumps.

Writes circle.png: python python/demos/03_follow_circle.py [FOLDER]
"""

import sys
import time
from pathlib import Path

import numpy as np

import leadthrough as lt
from leadthrough.show.plot import limits_figure

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda")

rng = np.random.default_rng(0)
targets = arm.forward_kinematics(rng.uniform(arm.limits.lower, arm.limits.upper, (2000, 7)))
began = time.process_time()
answers = arm.inverse_kinematics_batch(*targets)
microseconds = (time.process_time() - began) / len(answers.q) * 1e6
print(f"{answers.success.mean():.2%} of 2000 random poses solved, {microseconds:.0f} us per pose")

times = np.linspace(0.0, 2.0, 801)
angle = 2.0 * np.pi * lt.trajectories.minimum_jerk_time_scaling(times / 2.0)  # from rest to rest
circle = np.column_stack([np.full(801, 0.45), 0.15 * np.cos(angle), 0.45 + 0.15 * np.sin(angle)])
downwards = np.tile([0.0, 1.0, 0.0, 0.0], (801, 1))
asked = lt.PoseTrajectory(times, circle, downwards)
followed = arm.follow(asked, on_rate_limit="exceed_limits")  # slowed down in the next line
joints = lt.keep_timing(followed, arm.limits, rate=400.0)

reached, _ = arm.forward_kinematics(followed.positions)
print(f"tool error at most {np.abs(reached - circle).max():.1e} m")
print(f"slowed from {asked.duration:.2f} s to {joints.duration:.2f} s")
limits_figure(joints, arm.limits).savefig(folder / "circle.png", dpi=110)
print(f"wrote {folder / 'circle.png'}")
