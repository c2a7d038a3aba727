"""Clean a ROS 2 bag of a guided UR3, retime it, check it, and write it for three controllers.

Writes guided.mcap, arm.json, arm.yaml, arm.script and cleaned.png (needs the extra `ros`):
python python/demos/21_ros_bag_to_controller.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
from leadthrough.io import rosbag

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("ur3")

# Stands in for `ros2 bag record`: tremor, a pause midway, two faulty samples, a gap.
times = np.arange(0.0, 6.0, 0.008)
progress = np.interp(times, [0.0, 0.4, 2.0, 4.0, 5.6, 6.0], [0.0, 0.0, 0.5, 0.5, 1.0, 1.0])
way = lt.trajectories.minimum_jerk_time_scaling(progress)
q = np.array([0.0, -1.6, 1.9, -1.9, -1.6, 0.0]) + np.outer(way, [1.2, 0.3, -0.4, 0.5, 0.6, 2.0])
q += np.random.default_rng(3).normal(scale=3e-4, size=q.shape)
q[[150, 151], 2] += 1.5
kept = np.delete(np.arange(len(times)), np.arange(600, 620))
grasp = (lt.Event(3.0, "close gripper"),)
guided = lt.JointTrajectory(times[kept], q[kept], joint_names=arm.joint_names, events=grasp)
rosbag.write_joint_states(guided, folder / "guided.mcap")

(recording,) = lt.io.read_recordings(folder / "guided.mcap")
shown, report = lt.preprocess.clean(recording, longest_pause=0.1, rate=100, smoothing=0.4)
print(report)

joints = lt.retime(shown.motion, arm.limits, rate=500, path_tolerance=2e-3)
print(f"{recording.times[-1]:.2f} s as recorded, {joints.duration:.2f} s inside the limits")
print(f"{joints.events[0].name} at {joints.events[0].time:.2f} s; clear: {arm.check(joints).ok}")
for suffix in ("json", "yaml", "script"):
    lt.write_motion(joints, folder / f"arm.{suffix}")

figure, axes = plt.subplots(2, 1, figsize=(8, 6), layout="constrained")
axes[0].plot(recording.times, recording.positions, ".", markersize=2)
axes[0].set(title="recorded: tremor, a spike, a gap, a pause", ylabel="joints, rad")
axes[1].plot(joints.times, joints.positions)
axes[1].axvline(joints.events[0].time, color="C6", linestyle=":", label=joints.events[0].name)
axes[1].set(title="for the controller", xlabel="time, s", ylabel="joints, rad")
axes[1].legend()
figure.savefig(folder / "cleaned.png", dpi=110)
print(f"wrote {folder / 'arm.json'}, arm.yaml, arm.script and {folder / 'cleaned.png'}")
