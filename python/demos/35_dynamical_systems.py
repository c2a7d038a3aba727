"""Stable dynamical systems: convergence to the goal after any push, and a test of stability.

Six stable dynamical systems learn a letter (extras `lasa` and `stable`). From where a push leaves
the tool, each goes on to the goal. Prints how far each motion is from the demonstrations, whether
all trajectories arrive, and how far the tool is from the goal after the push;
writes dynamical_systems.png.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
from leadthrough.models import CLFDM, LPVDS, SEDS, ModifiedDS
from leadthrough.preprocess import frechet_distance
from leadthrough.preprocess.resample import by_arc_length
from leadthrough_studies.systems.fsm_dm import FSMDM
from leadthrough_studies.systems.umic import UMIC

plt.style.use("leadthrough.drawing.figures")
shown = lt.io.lasa.load("Angle")
drawn = by_arc_length(shown[0].motion.positions, 200)
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
push, dt = np.array([8.0, -12.0]), 0.01  # mm, s

print(f"{'model':12s} {'off by':>8s} {'arrive':>14s} {'pushed, to the goal':>20s}")
figure = plt.figure(layout="constrained")
axes = figure.subplots()
axes.plot(*drawn.T, "C6", linewidth=5, label="shown")
for model in (SEDS(), LPVDS(), FSMDM(), UMIC(), CLFDM(), ModifiedDS()):
    skill = model.fit(shown)
    made = skill.generate(start=drawn[0])
    apart = frechet_distance(drawn, by_arc_length(made.positions, 200))
    report = skill.stability(500)
    assert report.ok

    # A control loop: the velocity of wherever the tool is, and a push after 1 s.
    tool, trace = drawn[0].copy(), []
    for tick in range(1_000):
        trace.append(tool.copy())
        tool += dt * skill.policy(tool)
        if tick == 100:
            tool += push
    left = np.linalg.norm(tool - made.positions[-1])
    counts = f"{report.arrived:,} of {report.starts:,}"
    print(f"{type(model).__name__:12s} {apart:5.1f} mm {counts:>16s} {left:11.3f} mm")
    axes.plot(*np.transpose(trace), label=type(model).__name__)
axes.legend()
figure.savefig(folder / "dynamical_systems.png")
print(f"wrote {folder / 'dynamical_systems.png'}")
