"""Learn a handwriting motion from six demonstrations and plan it around a box.

Writes handwriting.png: python python/demos/01_learn_handwriting.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

import leadthrough as lt
from leadthrough.show import plot

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

*shown, held_out = lt.io.lasa.load("Snake")  # mm, as recorded
skill = lt.FastMarching().fit(shown)
start = held_out.motion.positions[0]
motion = skill.generate(start=start)

box = lt.Box((3.0, 3.0, 3.0), (*motion.positions[len(motion.positions) // 2], 0.0))
around = skill.generate(start=start, obstacles=[box])

figure = plt.figure(figsize=(8, 5), layout="constrained")
axes = figure.subplots()
plot.draw_velocity_map(axes, skill)
paths = [demonstration.motion.positions for demonstration in shown]
plot.draw_paths(axes, paths, plot.DEMONSTRATION, label="demonstrations")
plot.draw_paths(axes, [motion.positions], plot.PATH, label="from a new start")
plot.draw_paths(axes, [around.positions], plot.DETOUR, label="around the box")
plot.draw_box(axes, box)
axes.legend()
figure.savefig(folder / "handwriting.png", dpi=120)
print(f"kappa {skill.kappa(motion.positions):.2f} -> {skill.kappa(around.positions):.2f}")
print(f"wrote {folder / 'handwriting.png'}")
