"""DMP of a reach with a hold: new goals, no overshoot, and the hold stays still.

Writes hold.png: python python/demos/23_dmp_holds.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

# A hand reaches 0.4 m within 1.2 s, and holds a tool there for 0.8 s.
times = np.linspace(0.0, 2.0, 201)
reached = lt.trajectories.minimum_jerk_time_scaling(np.clip(times / 1.2, 0.0, 1.0))
shown = lt.Trajectory(times, np.outer(reached, [0.4, 0.0, 0.0]))
skill = lt.DMP().fit([lt.Demonstration(shown, name="reach")])

figure = plt.figure(figsize=(8, 4), layout="constrained")
axes = figure.subplots()
axes.plot(times, shown.positions[:, 0], color="C6", linewidth=3, label="shown")
for goal in (0.2, 0.6):
    made = skill.generate(goal=(goal, 0.0, 0.0), duration=2.0)
    held = made.positions[made.times > 1.25, 0]
    print(f"goal at {goal} m: at most {made.positions[:, 0].max():.4f} m, held within", end=" ")
    print(f"{1000 * np.ptp(held):.2f} mm")
    axes.plot(made.times, made.positions[:, 0], label=f"goal at {goal} m")

# The goal moves while the tool is on its way.
state, rows = skill.begin(), []
while state.phase < 1.0:
    goal = (0.4, 0.0, 0.0) if state.phase < 0.5 else (0.5, 0.0, 0.0)
    state = skill.step(state, 0.01, goal=goal)
    rows.append((state.phase * skill.duration, state.position[0]))
axes.plot(*np.array(rows).T, linestyle="--", label="goal moved to 0.5 m at half time")
print(f"moved on the way: {1000 * abs(state.position[0] - 0.5):.2f} mm off at the end")
axes.set(xlabel="time [s]", ylabel="x [m]", title="what was held is held")
axes.legend()
figure.savefig(folder / "hold.png", dpi=120)
print(f"wrote {folder / 'hold.png'}")
