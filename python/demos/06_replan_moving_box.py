"""Replanning while a box moves across the path: arrival times are repaired, not recomputed.

Writes moving_box.png: python python/demos/06_replan_moving_box.py [FOLDER]
"""

import sys
import time
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

grid = lt.Grid(origin=(0.0, 0.0), spacing=0.005, shape=(401, 301))  # 2 m by 1.5 m
goal, start = (0.2, 0.75), (1.8, 0.75)
field = lt.planning.ArrivalField(np.ones(grid.shape), grid, goal)

figure = plt.figure(figsize=(10, 5.5), layout="constrained")
x, y = np.moveaxis(grid.centres(), -1, 0)
for axes, height in zip(figure.subplots(2, 3).flat, np.linspace(0.1, 1.4, 6), strict=True):
    box = lt.Box((0.25, 0.4, 1.0), (1.1, height, 0.0))
    walls = lt.planning.occupied(grid, [box], margin=0.02)
    begin = time.perf_counter()
    update = field.update(np.where(walls, 0.0, 1.0))
    milliseconds = 1e3 * (time.perf_counter() - begin)

    path = lt.planning.descend(field.times, grid, start, goal)
    axes.contourf(x, y, np.where(walls, np.nan, field.times), 25)
    axes.plot(*path.T, "w", linewidth=2)
    axes.set_title(f"{update.kind}, {update.invalidated} cells, {milliseconds:.1f} ms", fontsize=9)
    axes.set_aspect("equal")

# If an arm is pushed off its path, the field gives the direction to the goal from any position.
pushed = np.random.default_rng(1).uniform((0.1, 0.1), (0.9, 1.4), (40, 2))
axes.quiver(*pushed.T, *lt.planning.direction(field.times, grid, pushed).T, color="w", width=0.004)
figure.savefig(folder / "moving_box.png", dpi=120)
print(f"wrote {folder / 'moving_box.png'}")
