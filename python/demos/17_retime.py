"""Time law: a slowly demonstrated circle, made as fast as the joints of a Panda allow.

Writes retimed.json and retimed.png:
python python/demos/17_retime.py [FOLDER]
"""

import sys
from pathlib import Path

import numpy as np

import leadthrough as lt
from leadthrough.show.plot import limits_figure
from leadthrough.timing import TipSpeed, binding_limits

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda")

# One round in six seconds, starting and ending at rest.
phase = np.linspace(0.0, 1.0, 301)
angle = 2.0 * np.pi * lt.trajectories.minimum_jerk_time_scaling(phase)
tip = np.column_stack([0.45 + 0.12 * np.cos(angle), 0.12 * np.sin(angle), np.full(301, 0.4)])
poses = lt.PoseTrajectory(6.0 * phase, tip, [(0, 1, 0, 0)] * 301)
shown = arm.follow(poses, on_rate_limit="exceed_limits")

kept = lt.keep_timing(shown, arm.limits)
fastest = lt.retime(shown, arm.limits)
gentle = lt.retime(shown, arm.limits, tip_speed=TipSpeed(0.25, arm.jacobian))
for name, motion in {"fastest": fastest, "tip at 0.25 m/s at most": gentle}.items():
    report = lt.check_limits(motion, arm.limits)
    rates = [f"{getattr(report, k).ratio:.1%}" for k in ("velocity", "acceleration", "jerk")]
    print(f"{name}: {motion.duration:.3f} s; velocity, acceleration, jerk at most {rates}")
print(f"demonstrated in {shown.duration:.2f} s, with its timing kept {kept.duration:.2f} s")
for binding in binding_limits(fastest, arm.limits)[:8]:
    print(f"{binding.start:.3f} to {binding.end:.3f} s: {binding.kind} of {binding.joint}")

lt.io.joint_trajectory.write_json(fastest, folder / "retimed.json")
limits_figure(fastest, arm.limits).savefig(folder / "retimed.png", dpi=110)
print(f"wrote {folder / 'retimed.json'} and {folder / 'retimed.png'}")
