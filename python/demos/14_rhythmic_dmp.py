"""Rhythmic DMP: demonstrated stirring continues slower, wider, and in a pot that moves.

Writes stirring.png: python python/demos/14_rhythmic_dmp.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt

plt.style.use("leadthrough.drawing.figures")
folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")

# Four rounds of 1.5 s by a hand with tremor; the spoon always leans outwards.
rng = np.random.default_rng(3)
times = np.linspace(0.0, 6.0, 601)
w = 2.0 * np.pi * times / 1.5
x, y = 0.06 * np.cos(w), 0.05 * np.sin(w) + 0.01 * np.sin(2.0 * w)
positions = np.column_stack([x, y, 0.2 + 0.005 * np.cos(w)]) + rng.normal(0.0, 5e-4, (601, 3))
lean = 0.4 * np.column_stack([-np.sin(w), np.cos(w), 0.0 * w]) + rng.normal(0.0, 2e-3, (601, 3))
shown = lt.PoseTrajectory(times, positions, lt.rotations.exp(lean))

skill = lt.RhythmicDMP(period=1.5).fit([lt.Demonstration(shown, name="stir")])
skill.save(folder / "stir.npz")
skill = lt.load_skill(folder / "stir.npz")

# A control loop: the spoon comes in from above, and after 4 s somebody moves the pot.
state = skill.begin(start=(0.0, 0.0, 0.4), period=2.0, amplitude=1.3)
rows, pot = [], np.array([0.0, 0.0, 0.2])
for tick in range(8000):
    if 4000 <= tick < 5000:
        pot[0] += 0.2e-3
    state = skill.step(state, 0.001, goal=pot)
    rows.append(state.pose)
path = np.array(rows)
speeds = np.degrees(lt.rotations.distance(path[:-1, 3:], path[1:, 3:])) / 0.001
print(f"{state.phase:.1f} rounds; the spoon turns at {speeds.max():.0f} degrees per second at most")

figure = plt.figure(figsize=(10, 4), layout="constrained")
above, over_time = figure.subplots(1, 2)
above.plot(*positions[:, :2].T, color="C6", label="four demonstrated rounds")
above.plot(*path[:, :2].T, color="C0", lw=1, label="continued, pot moved")
above.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
above.legend(loc="upper center", bbox_to_anchor=(0.5, 1.35))
over_time.plot(np.arange(8000) / 1000.0, path[:, :3], label=["x", "y", "z"])
over_time.set(xlabel="time [s]", ylabel="position [m]")
over_time.legend()
figure.savefig(folder / "stirring.png", dpi=120)
print(f"wrote {folder / 'stirring.png'}")
