"""Moving targets: catch a part on a belt, ride with it, and leave it at speed.

Writes moving_targets.png: python python/demos/38_moving_targets.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from leadthrough import trajectories as tr

plt.style.use("leadthrough.drawing.figures")
BELT, PERIOD = 0.25, 0.002  # m/s, s


def caught() -> list[tr.FilterState]:
    """The tool along the belt, from rest until it has ridden with the part for half a second."""
    reach = tr.JerkFilter(velocity=0.8, acceleration=2.0, jerk=20.0)
    states = [tr.FilterState.at_rest([0.0])]
    riding = 0
    while riding < 0.5 / PERIOD:
        part = 0.3 + BELT * PERIOD * len(states)
        states.append(reach.step(states[-1], [part], PERIOD, velocity=[BELT]))
        riding += abs(states[-1].position[0] - part) < 1e-9
    return states


def main(folder: Path) -> None:
    """Catch the part, then leave at its velocity for where another tool takes over."""
    states = caught()
    last = states[-1]
    limits = {"velocity": 0.8, "acceleration": 2.0, "jerk": 20.0}
    leave = tr.double_s(
        last.position, [1.2], **limits, start_velocity=last.velocity, end_velocity=[0.4]
    )
    there = np.linspace(*leave.domain, 200)
    speeds = leave.evaluate(there, 1)
    met = PERIOD * len(states) - 0.5
    print(f"caught after {met:.2f} s, {last.position[0]:.3f} m along the belt")
    fastest = np.abs(speeds).max()
    print(f"handed over {there[-1]:.2f} s later at 0.4 m/s; at most {fastest:.2f} m/s between")

    figure = plt.figure(figsize=(8, 3.2), layout="constrained")
    axes = figure.subplots()
    times = PERIOD * np.arange(len(states))
    axes.plot(times, [state.velocity[0] for state in states], label="catch and ride")
    axes.plot(times[-1] + there, speeds, label="leave and hand over")
    axes.axhline(BELT, color="C6", linestyle=":", label="the belt")
    axes.set(xlabel="time, s", ylabel="speed of the tool, m/s")
    figure.legend(loc="outside lower center", ncols=3)
    figure.savefig(folder / "moving_targets.png", dpi=110)
    print(f"wrote {folder / 'moving_targets.png'}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
