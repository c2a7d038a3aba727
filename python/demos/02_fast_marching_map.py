"""March a wave through a map with walls and follow its gradient along the fastest path.

Writes map.png: python python/demos/02_fast_marching_map.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

grid = lt.Grid(origin=(0.0, 0.0), spacing=0.01, shape=(101, 101))  # 1 m by 1 m
walls = [
    lt.Box((0.7, 0.04, 1.0), (0.35, 0.33, 0.0)),
    lt.Box((0.7, 0.04, 1.0), (0.65, 0.67, 0.0)),
]
blocked = lt.planning.occupied(grid, walls)
start, goal = (0.1, 0.1), (0.9, 0.9)

# Plain fast marching hugs the walls. Slow cells near walls (FM2) keep the path away from them.
clearance = np.minimum(lt.planning.distance_transform(blocked, spacing=grid.spacing), 0.1)
figure = plt.figure(figsize=(9, 4.5), layout="constrained")
for axes, title, speed in zip(
    figure.subplots(1, 2),
    ("shortest path", "safe path: slow near walls"),
    (np.where(blocked, 0.0, 1.0), clearance / clearance.max()),
    strict=True,
):
    arrival = lt.arrival_times(speed, grid.cells_of([goal]), spacing=grid.spacing)
    path = lt.planning.descend(arrival, grid, start, goal)
    x, y = np.moveaxis(grid.centres(), -1, 0)
    axes.contourf(x, y, np.where(np.isinf(arrival), np.nan, arrival), 30)
    axes.plot(*path.T, "w", linewidth=2)
    axes.set_title(f"{title}: {np.linalg.norm(np.diff(path, axis=0), axis=1).sum():.2f} m")
    axes.set_aspect("equal")
figure.savefig(folder / "map.png", dpi=120)
print(f"wrote {folder / 'map.png'}")
