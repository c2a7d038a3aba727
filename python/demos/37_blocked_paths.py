"""Three ways past a blocked path segment: a detour, another path, or joint space.

Writes detours.png and blocked.html:
python python/demos/37_blocked_paths.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda")

# A reach across the table, shown once; a box that came later hangs where the hand goes.
u = np.linspace(0.0, 1.0, 61)
rise, bow = lt.trajectories.minimum_jerk_time_scaling(u), np.sin(np.pi * u)
way = np.column_stack([0.45 + 0.05 * bow, 0.6 * rise - 0.3, 0.25 + 0.1 * bow])
shown = lt.PoseTrajectory(2.0 * u, way, np.tile([0.0, 1.0, 0.0, 0.0], (61, 1)))
skill = lt.DMP().fit([shown])
box = lt.Box((0.08, 0.06, 0.1), (0.42, 0.0, 0.44))

ways = {
    "up to 8 cm beside the path": lt.plan_motion(
        skill, arm, [box], lt.Query(dt=0.02), deviation=(0.08, 0.0)
    ),
    "another path of the tip": lt.plan_motion(skill, arm, [box], lt.Query(dt=0.02)),
    "through joint space": lt.plan_motion(
        skill, arm, [box], lt.Query(dt=0.02), rounds=1, last_resort="joint_space"
    ),
}

figure = plt.figure(figsize=(8, 3.5), layout="constrained")
side, gap = figure.subplots(1, 2)
alone = skill.generate(obstacles=[box], dt=0.002).positions
for name, planned in ways.items():
    tip, _ = arm.forward_kinematics(planned.joints.positions)
    off = np.linalg.norm(tip[:, None] - alone, axis=2).min(axis=1)
    (line,) = side.plot(tip[:, 1], 1e3 * off, label=name)
    distances = arm.check(planned.joints, [box]).obstacles.distances
    gap.plot(tip[:, 1], 1e3 * distances, color=line.get_color())
    print(
        f"{name}: tool {1e3 * planned.deviation:.0f} mm off its path, "
        f"arm {1e3 * planned.clearance:.1f} mm clear, {planned.joints.duration:.1f} s"
    )
side.set(xlabel="y of the tool in m", ylabel="tool off its path in mm")
side.legend(fontsize="small", loc="upper left")
gap.set(xlabel="y of the tool in m", ylabel="whole arm to box in mm", ylim=(0.0, 100.0))
figure.savefig(folder / "detours.png", dpi=120)

last = ways["through joint space"]
print("joint space, {:.2f} to {:.2f} s:".format(*last.connected), *last.reasons, sep="\n")
timed = lt.retime(last.joints, arm.limits)
lt.show.view(arm, timed, scene=[box], html=folder / "blocked.html")
print(f"wrote {folder / 'detours.png'} and {folder / 'blocked.html'}")
