"""Gaussian mixture regression: covariance along the motion, and a stiffness profile from it.

Writes stiffness.png: python python/demos/16_gmr_stiffness.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
import probability
from leadthrough.models import kmeans, stiffness_profile, trace_mixture
from leadthrough.show import plot

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

shown = lt.io.lasa.load("JShape")  # mm, as recorded
skill = lt.GMR(components=6).fit(shown)
times = np.linspace(0.0, skill.duration, 100)
mean, covariance = skill.regress(times)
stiffness = stiffness_profile(covariance, softest=100.0, stiffest=1500.0)  # N/m

figure = plt.figure(figsize=(11, 7), layout="constrained")
axes = figure.subplots(2, 4)
points = np.concatenate([each.motion.positions[::10] for each in shown])
clusters = kmeans(points, 6, seed=2)
for panel, step in zip(axes[0, :2], (0, len(clusters.steps) - 1), strict=True):
    probability.draw_kmeans_step(panel, points, clusters, step, (0, 1))
    panel.set_title(f"k-means, {panel.get_title()}", fontsize=9)
mixtures = trace_mixture(points, 6, iterations=20, seed=2)
probability.draw_em_steps(axes[0, 2:], points, [mixtures[0], mixtures[-1]], (0, 1))
axes[0, 3].set_title("after 20 iterations of EM", fontsize=9)

paths = [each.motion.positions for each in shown]
plot.draw_paths(axes[1, 0], paths, plot.DEMONSTRATION, label="demonstrations")
probability.draw_components(axes[1, 0], skill.mixture, (1, 2))
plot.draw_paths(axes[1, 1], [mean], plot.PATH, label="regression")
spread = {"color": "C0", "alpha": 0.15}
probability.draw_ellipses(axes[1, 1], mean[::5], 4.0 * covariance[::5], spread)
plot.draw_paths(axes[1, 2], paths, plot.DEMONSTRATION, label="demonstrations")
moved = skill.generate(start=mean[0] + (8.0, -8.0)).positions
plot.draw_paths(axes[1, 2], [moved], plot.PATH, label="from a new start")
values = np.linalg.eigvalsh(stiffness)
axes[1, 3].semilogy(times, values[:, 0], label="softest axis")
axes[1, 3].semilogy(times, values[:, 1], label="stiffest axis")
axes[1, 3].set_title("stiffness in N/m over time in s", fontsize=9)
for panel in (*axes[0], *axes[1, :3]):
    panel.set_aspect("equal")
for panel in axes[1, 1:]:
    panel.legend(fontsize=7)
figure.savefig(folder / "stiffness.png", dpi=110)
print(f"stiffness {values[0].min():.0f} N/m at the start, {values[-1].max():.0f} N/m at the goal")
print(f"wrote {folder / 'stiffness.png'}")
