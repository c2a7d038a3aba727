"""Turn a CSV recording of joint angles into a trajectory that a UR3 can execute.

Writes recording.json and recording.png: python python/demos/04_recording_to_robot.py [FOLDER]
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import leadthrough as lt
from leadthrough.show.plot import limits_figure

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("ur3")

# Stands in for a file from the robot's own recorder: a header, 100 Hz, guided quickly by hand.
phase = np.linspace(0.0, 1.0, 121)
swing = lt.trajectories.minimum_jerk_time_scaling(phase)
q = np.array([0.0, -1.6, 1.9, -1.9, -1.6, 0.0]) + np.outer(swing, [1.2, 0.3, -0.4, 0.5, 0.6, 2.0])
recording = folder / "recording.csv"
header = ",".join(["time", *arm.joint_names])
np.savetxt(recording, np.column_stack([1.2 * phase, q]), delimiter=",", header=header, comments="")

recorded = lt.read_motion(recording)
gripped = lt.Event(0.6, "gripper closed")  # half way; keeps its place when the arm slows down
asked = replace(recorded, events=[gripped])
before = lt.check_limits(asked, arm.limits)
joints = lt.keep_timing(asked, arm.limits, rate=100.0)
after = lt.check_limits(joints, arm.limits)
for name in ("velocity", "acceleration", "jerk"):
    peaks = [getattr(report, name) for report in (before, after)]
    print(f"{name}: {peaks[0].ratio:.0%} of the limit -> {peaks[1].ratio:.0%} ({peaks[1].joint})")

lt.io.joint_trajectory.write_json(joints, folder / "recording.json")
limits_figure(joints, arm.limits).savefig(folder / "recording.png", dpi=110)
print(f"slowed from {asked.duration:.2f} s to {joints.duration:.2f} s")
print(f"the gripper closes at {joints.events[0].time:.2f} s instead of {gripped.time:.2f} s")
print(f"wrote {folder / 'recording.json'} and {folder / 'recording.png'}")
