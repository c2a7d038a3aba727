"""Demonstration quality: seven demonstrations, one spoiled, and the goal to demonstrate next.

Writes judged.png: python python/demos/33_judge_demonstrations.py [FOLDER]
"""

import sys
from dataclasses import replace
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
from leadthrough.validation import TargetRegion

plt.style.use("leadthrough.drawing.figures")
shown = lt.io.lasa.load("Spoon")
spoiled = shown[2].motion
phase = np.linspace(0.0, 1.0, len(spoiled))[:, None]
bump = 12.0 * np.sin(np.pi * phase) ** 2 * [1.0, -1.0]  # mm
shown[2] = replace(shown[2], motion=lt.Trajectory(spoiled.times, spoiled.positions + bump))

found = lt.judge_demonstrations(shown, goals=TargetRegion([-10.0, -10.0], [10.0, 10.0]))
for verdict in found.verdicts:
    told = ", ".join(verdict.faults) or "no fault"
    print(f"{verdict.name}: {told}, suspicion {verdict.suspicion:.1f}, worth {verdict.worth:+.0%}")
print(f"leave out {found.remove}: error {found.error:.2%} -> {found.error_without:.2%}")
assert found.remove == (2,)
assert found.error_without < found.error
if found.next:
    print(f"show next: a motion to {found.next.goal.round(1)} mm")

figure = plt.figure(figsize=(5, 4))
axes = figure.add_subplot()
for verdict, each in zip(found.verdicts, shown, strict=True):
    colour = "C1" if verdict.remove else "C0"
    axes.plot(*each.motion.positions.T, color=colour)
axes.set(xlabel="x / mm", ylabel="y / mm", aspect="equal")
file = Path(sys.argv[1] if len(sys.argv) > 1 else ".") / "judged.png"
figure.savefig(file)
print(f"wrote {file}")
