"""Seven curves through or near the same six points, and a curve of poses.

Writes curves.png: python python/demos/18_curves.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from leadthrough import rotations, trajectories as tr

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
times = np.linspace(0.0, 5.0, 6)
points = np.array([[0, 0], [1, 2], [2, -1], [3, 2.5], [4.5, 0.5], [5, 2]])

curves = {
    "one polynomial": tr.Lagrange(times, points),
    "straight lines": tr.linear(times, points),
    "natural cubic spline": tr.natural_cubic(times, points),
    "minimum jerk": tr.minimum_jerk_through(times, points),
    "smoothing spline": tr.smoothing(times, points, weight=0.1),
    "Bezier": tr.Bezier(points, (0.0, 5.0)),
    "B-spline": tr.BSpline(points, [0, 0, 0, 0, 5 / 3, 10 / 3, 5, 5, 5, 5], 3),
}

figure = plt.figure(figsize=(10.0, 4.5), layout="constrained")
left, right = figure.subplots(1, 2)
left.plot(*points.T, "k.", markersize=9)
fine = np.linspace(0.0, 5.0, 400)
for name, curve in curves.items():
    left.plot(*curve.evaluate(fine).T, label=name, linewidth=1.2)
    accelerations = np.linalg.norm(curve.evaluate(fine, 2), axis=1)
    print(f"{name}: acceleration at most {accelerations.max():.2f}")
left.legend(fontsize=7)
left.set_title("the same points", fontsize=10)

turns = rotations.exp(np.column_stack([points, np.linspace(0.0, 3.0, 6)]) * 0.4)
for name, rotating in {
    "slerp": tr.Slerp(times, turns),
    "squad": tr.Squad(times, turns),
    "C2 spline": tr.RotationSpline(times, turns),
}.items():
    speeds = np.linalg.norm(rotating.evaluate(fine, 1), axis=1)
    right.plot(fine, speeds, label=name)
right.legend(fontsize=7)
right.set_title("angular speed through six rotations, rad/s", fontsize=10)

place = tr.natural_cubic(times, np.column_stack([points, np.zeros(6)]))
pose = tr.PoseCurve(place, tr.RotationSpline(times, turns)).sampled(fine)
print(f"a pose trajectory of {len(pose.times)} samples over {pose.duration:g} s")
figure.savefig(folder / "curves.png", dpi=110)
print(f"wrote {folder / 'curves.png'}")
