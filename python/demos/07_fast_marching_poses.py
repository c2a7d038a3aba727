"""Learn poses along a path that crosses itself, save the skill, and generate new ends.

Writes crossing.png: python python/demos/07_fast_marching_poses.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
from leadthrough.show import plot

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

# Three demonstrations of a loop over a table, in m. The tool's x axis points along the path.
times = np.linspace(0.0, 4.0, 400)
turn = 2.5 * np.pi * times / 4.0
demonstrations = []
for offset in (-0.01, 0.0, 0.01):
    x = 0.08 * times + 0.12 * np.sin(turn)
    y = 0.12 * np.cos(turn) + offset * (1.0 - times / 4.0)
    heading = np.unwrap(np.arctan2(np.gradient(y), np.gradient(x)))
    positions = np.column_stack([x, y, np.full(400, 0.3)])
    poses = lt.PoseTrajectory(times, positions, lt.rotations.exp(np.outer(heading, [0, 0, 1])))
    demonstrations.append(lt.Demonstration(poses))

lt.FastMarching().fit(demonstrations).save(folder / "loop.npz")
skill = lt.load_skill(folder / "loop.npz")
start, goal = (-0.02, 0.15, 0.3), (0.46, -0.03, 0.3)
made = skill.generate(start=start, goal=goal)
print(f"{skill.plan(start=start, goal=goal).method}: {made.duration:.2f} s, ends at {goal}")

figure = plt.figure(figsize=(8, 5), layout="constrained")
axes = figure.subplots()
shown = [demonstration.motion.positions for demonstration in demonstrations]
plot.draw_paths(axes, shown, plot.DEMONSTRATION, label="three demonstrations")
plot.draw_paths(axes, [made.positions], plot.PATH, label="new start and goal")
ahead = lt.rotations.to_matrix(made.orientations)[::20, :2, 0]
axes.quiver(*made.positions[::20, :2].T, *ahead.T, color="C1", width=0.003, label="tool's x")
axes.set_aspect("equal")
axes.legend()
figure.savefig(folder / "crossing.png", dpi=120)
print(f"wrote {folder / 'crossing.png'}")
