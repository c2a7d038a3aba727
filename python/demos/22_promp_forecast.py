"""ProMP forecast: the rest of a drawing from its beginning, with its confidence region.

Writes forecast.png: python python/demos/22_promp_forecast.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import Ellipse

import leadthrough as lt
from leadthrough.models import infer
from leadthrough.show import plot

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

*shown, left_out = lt.io.lasa.load("Sshape")  # mm, as recorded
skill = lt.ProMP().fit(shown)
whole = left_out.motion
phases = (whole.times - whole.times[0]) / whole.duration

figure = plt.figure(figsize=(11, 4.5), layout="constrained")
for axes, fraction in zip(figure.subplots(1, 3), (0.15, 0.4, 0.7), strict=True):
    count = int(fraction * len(whole.times))
    guess = infer(lt.Trajectory(whole.times[:count], whole.positions[:count]), [skill])
    ahead = np.linspace(fraction, 1.0, 13) * guess.durations[0]
    region = guess.region(ahead)
    for centre, shape in zip(region.mean, region.shape, strict=True):
        squares, directions = np.linalg.eigh(shape)
        turn = np.degrees(np.arctan2(directions[1, 1], directions[0, 1]))
        width, height = 2.0 * np.sqrt(squares[::-1])
        axes.add_patch(Ellipse(centre, width, height, angle=turn, color="C0", alpha=0.12))
    drawn = [each.motion.positions for each in shown]
    plot.draw_paths(axes, drawn, plot.DEMONSTRATION, label="demonstrations")
    plot.draw_paths(axes, [guess.skills[0].generate().positions], plot.PATH, label="forecast")
    axes.plot(*whole.positions[count:].T, "k:", label="what came")
    axes.plot(*whole.positions[:count].T, "k", linewidth=2.5, label="seen")
    axes.set_title(f"{fraction:.0%} seen: 95 % regions", fontsize=10)
    axes.set_aspect("equal")
    came = np.stack([np.interp(ahead / ahead[-1], phases, x) for x in whole.positions.T], axis=1)
    missed = np.linalg.norm(region.mean - came, axis=1).max()
    inside = region.contains(came).mean()
    print(
        f"{fraction:.0%} seen: at most {missed:.1f} mm off, {inside:.0%} of the rest in its region"
    )
axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5))
figure.savefig(folder / "forecast.png", dpi=110)
print(f"wrote {folder / 'forecast.png'}")
