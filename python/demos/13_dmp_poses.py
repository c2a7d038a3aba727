"""DMP of poses: one demonstrated pour, to a glass moved and tilted, around a bottle.

Writes pour.png: python python/demos/13_dmp_poses.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
from leadthrough.show import plot

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

# A hand carries a jug to a glass and tips it by 130 degrees while it swings about the wrist.
times = np.linspace(0.0, 4.0, 401)
u = times / 4.0
carried = lt.trajectories.minimum_jerk_time_scaling(u)
tipped = np.radians(130.0) * lt.trajectories.minimum_jerk_time_scaling(
    np.clip((u - 0.4) / 0.6, 0.0, 1.0)
)
positions = np.column_stack([0.4 * carried, 0.1 * np.sin(np.pi * carried), 0.3 + 0.05 * carried])
swung = lt.rotations.exp(np.outer(carried, [0.0, 0.0, 1.2]))
orientations = lt.rotations.compose(swung, lt.rotations.exp(np.outer(tipped, [0.0, 1.0, 0.0])))
shown = lt.PoseTrajectory(times, positions, orientations)

skill = lt.DMP().fit([lt.Demonstration(shown, name="pour")])
again = skill.generate(dt=0.01)
off = np.degrees(lt.rotations.distance(again.orientations, shown.orientations))
print(f"replayed within {off.max():.4f} degrees")

tilt = lt.rotations.exp(np.radians([[60.0, 0.0, 0.0]]))
goal = ((0.45, -0.1, 0.3), lt.rotations.compose(tilt, orientations[-1:])[0])
bottle = lt.Capsule(0.04, 0.3, (0.24, 0.03, 0.3))
made = skill.generate(goal=goal, obstacles=[bottle], dt=0.01)
left = np.degrees(lt.rotations.distance(made.orientations[-1:], goal[1][None])[0])
clear = 1000 * bottle.distance(made.positions).min()
print(f"at the tilted glass: {left:.1e} degrees off, {clear:.0f} mm clear of the bottle")

figure = plt.figure(figsize=(10, 4), layout="constrained")
above, turning = figure.subplots(1, 2)
plot.draw_paths(above, [shown.positions[:, :2]], plot.DEMONSTRATION, label="shown")
plot.draw_paths(above, [made.positions[:, :2]], plot.PATH, label="to the other glass")
around = np.linspace(0.0, 2.0 * np.pi, 60)
above.fill(0.24 + 0.04 * np.cos(around), 0.03 + 0.04 * np.sin(around), color="C6")
above.set(title="from above", xlabel="x [m]", ylabel="y [m]", aspect="equal")
for motion, colour in ((shown, "C6"), (made, "C0")):
    speeds = lt.rotations.angular_velocity(motion.times, motion.orientations)
    turning.plot(motion.times, np.degrees(np.linalg.norm(speeds, axis=1)), color=colour)
turning.set(title="the jug turns without a spin", xlabel="time [s]", ylabel="degrees per second")
above.legend()
figure.savefig(folder / "pour.png", dpi=120)
print(f"wrote {folder / 'pour.png'}")
