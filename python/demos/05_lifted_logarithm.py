"""Two turns about a slowly moving axis: the plain logarithm jumps, the lifted one does not.

Writes turns.png: python python/demos/05_lifted_logarithm.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

times = np.linspace(0.0, 4.0, 400)
turned = (
    4.0 * np.pi * lt.trajectories.minimum_jerk_time_scaling(times / times[-1])
)  # from rest to rest
lean = turned / 25.0
axis = np.column_stack([np.sin(lean), np.zeros_like(lean), np.cos(lean)])
orientations = lt.rotations.exp(turned[:, None] * axis)

vectors = {"log": lt.rotations.log(orientations), "lift": lt.rotations.lift(orientations)}
figure = plt.figure(figsize=(9, 3.6), layout="constrained")
for axes, (name, rows) in zip(figure.subplots(1, 2, sharey=True), vectors.items(), strict=True):
    axes.plot(times, np.degrees(rows), label=["x", "y", "z"])
    axes.set(title=f"lt.rotations.{name}", xlabel="time [s]")
    axes.grid(alpha=0.3)
    largest = np.degrees(np.linalg.norm(np.diff(rows, axis=0), axis=1).max())
    print(f"{name}: largest step {largest:.1f} degrees, ends at {np.degrees(rows[-1]).round(1)}")
figure.axes[0].set_ylabel("rotation vector [degrees]")
figure.axes[0].legend()
figure.savefig(folder / "turns.png", dpi=110)

back = lt.rotations.exp(vectors["lift"])
print(f"exp(lift) differs by at most {lt.rotations.distance(back, orientations).max():.0e} rad")
print(f"wrote {folder / 'turns.png'}")
