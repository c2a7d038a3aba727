"""Online filters: seven joints get a new target, independently, synchronised, on a straight line.

Writes targets.png: python python/demos/19_online_filters.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
from leadthrough import trajectories as tr

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
limits = lt.Arm.load("panda").limits
home = np.array([0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8])
targets = home + np.random.default_rng(3).uniform(-0.8, 0.8, (2, 7))
period, change = 1e-3, 250  # s, and the step at which the second target comes

# Limits need not be symmetric: accelerations may be twice as large in the negative direction.
made = tr.JerkFilter(
    limits.velocity, 0.3 * limits.acceleration, 0.05 * limits.jerk,
    acceleration_down=0.6 * limits.acceleration,
)  # fmt: skip
steps = {
    "independently": made.step,
    "synchronised": made.step_together,
    "on a straight line": tr.StraightFilter(made).step,
}

figure = plt.figure(figsize=(11.0, 4.0), layout="constrained")
for axes, (name, step) in zip(figure.subplots(1, 3, sharey=True), steps.items(), strict=True):
    state, rows, arrival = tr.FilterState.at_rest(home), [home], np.zeros(7)
    while not arrival.all():
        state = step(state, targets[int(len(rows) > change)], period)
        rows.append(state.position)
        there = (state.position == targets[1]) & (state.velocity == 0.0)
        arrival[there & (arrival == 0.0)] = len(rows) * period
    axes.plot(period * np.arange(len(rows)), rows)
    axes.axvline(period * change, color="C6", linewidth=0.8)
    axes.set_title(name, fontsize=10)
    axes.set_xlabel("s")
    print(
        f"{name}: the first joint arrives after {arrival.min():.3f} s, the last {arrival.max():.3f}"
    )
figure.savefig(folder / "targets.png", dpi=110)
print(f"wrote {folder / 'targets.png'}")
