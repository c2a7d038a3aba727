"""The family of models by left-out demonstrations, and the mean of aligned ones beside others.

Writes families.png: python python/demos/39_choose_a_family.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
from leadthrough.show import plot

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
u = np.linspace(0.0, 1.0, 200)
rng = np.random.default_rng(1)


def reach(side: float) -> lt.Trajectory:
    """A reach around a post on one side, that joins the common path after a third, in m."""
    start = np.array([0.0, 0.1 * side + rng.normal(0.0, 0.03)])
    path = np.column_stack([0.5 * u, 0.12 * side * np.sin(np.pi * u)])
    path += np.clip(1.0 - 3.0 * u, 0.0, 1.0)[:, None] ** 2 * start
    pause = int(rng.integers(40, 160))  # the hand stops for half a second, somewhere
    rows = np.insert(path, [pause] * 50, path[pause], axis=0)
    return lt.Trajectory(np.arange(len(rows)) * 0.01, rows)


shown = [reach(side) for side in (1.0, -1.0) for _ in range(6)]
skill = lt.learn(shown)
print(skill.choice)
figure, panels = plt.subplots(1, 3, figsize=(11, 3.6), layout="constrained")
families = {"learn": skill, "ProMP": lt.ProMP().fit(shown), "DMP": lt.DMP().fit(shown)}
for axes, (name, each) in zip(panels, families.items(), strict=True):
    plot.draw_paths(axes, [one.positions for one in shown], plot.DEMONSTRATION, label="shown")
    starts = [(0.0, y) for y in (-0.15, -0.05, 0.05, 0.15)]
    paths = [each.generate(start=start, goal=(0.5, 0.0)).positions for start in starts]
    plot.draw_paths(axes, paths, plot.PATH, label="made")
    axes.set_title(f"{name}: {skill.choice.chosen}" if name == "learn" else name)
    axes.set_aspect("equal")
    axes.legend(fontsize=7)
figure.savefig(folder / "families.png", dpi=110)
print(f"wrote {folder / 'families.png'}")
