"""A point of a learned motion is moved by hand: the motion passes there and stays elsewhere.

Writes corrected.png: python python/demos/44_correct_motion.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
from leadthrough.show import plot

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
skill = lt.DMP().fit(lt.io.lasa.load("GShape"))
own, goal = skill.generate(), (15.0, 5.0)  # mm

time, moved = 0.55 * own.duration, own.at(0.55 * own.duration) + np.array([-2.0, 7.0])
corrected = skill.corrected(time, moved)
beside = {"corrected": corrected, "via point": skill}
figure, panels = plt.subplots(1, 3, figsize=(11, 3.8), layout="constrained", sharey=True)
for axes, (name, each) in zip(panels, beside.items(), strict=False):
    via = [(time / own.duration, moved)] if each is skill else ()
    made = each.generate(via=via) if via else each.generate()
    plot.draw_paths(axes, [own.positions], plot.DEMONSTRATION, label="before")
    plot.draw_paths(axes, [made.positions], plot.PATH, label=name)
    changed = np.linalg.norm(made.positions - own.positions, axis=1) > 0.5
    print(f"{name}: {changed.mean():.0%} of the motion is changed by more than 0.5 mm")
    axes.plot(*moved, "o", color="black", label="moved to")
    axes.set_title(name)

plot.draw_paths(
    panels[2], [skill.generate(goal=goal).positions], plot.DEMONSTRATION, label="before"
)
plot.draw_paths(panels[2], [corrected.generate(goal=goal).positions], plot.PATH, label="corrected")
panels[2].set_title("corrected, with a new goal")
for axes in panels:
    axes.set_aspect("equal")
    axes.legend(fontsize=7)
corrected.save(folder / "corrected.npz")  # the file keeps the correction
figure.savefig(folder / "corrected.png", dpi=110)
print(f"wrote {folder / 'corrected.png'} and {folder / 'corrected.npz'}")
