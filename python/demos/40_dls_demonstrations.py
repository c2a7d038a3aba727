"""Damped least squares and a ProMP: poses, joints, demonstrations, a skill (Yang et al., Figure 1).

Goal poses near one another become configurations by damped least squares (DLS), and these joint
motions by linear interpolation, at rest before and after; a ProMP learns the motions, and is
conditioned on one more configuration. Writes dls_demonstrations.png:
python python/demos/40_dls_demonstrations.py [FOLDER]
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import leadthrough as lt
from leadthrough import rotations
from leadthrough_studies.damped_least_squares import damped_inverse_kinematics

plt.style.use("leadthrough.drawing.figures")
READY = np.array([0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])
TIMES = np.linspace(0.0, 4.0, 201)


def main(folder: Path) -> None:
    """Goal poses, their joints by DLS, linear demonstrations, a ProMP, and its new motion."""
    arm, rng = lt.Arm.load("panda"), np.random.default_rng(0)
    position, orientation = arm.forward_kinematics([0.6, 0.2, 0.6, -1.7, 0.9, 1.9, 0.4])
    turns = rotations.exp(rng.normal(0.0, 0.03, (7, 3)))
    goals = rotations.compose(turns, np.tile(orientation, (7, 1)))
    places = position + rng.normal(0.0, 0.02, (7, 3))
    found = damped_inverse_kinematics(arm, places, goals, q0=READY)
    off = 1e3 * found.position_error.max()
    print(f"{found.success.sum()} of 7 poses solved by DLS, at most {off:.4f} mm off")

    covered = np.clip((TIMES - 1.0) / 2.0, 0.0, 1.0)[:, None]  # linear, between rests of 1 s
    shown = [lt.JointTrajectory(TIMES, READY + covered * (q - READY)) for q in found.q[:6]]
    skill = lt.ProMP().fit(shown)
    made = skill.condition(TIMES[-1], found.q[6]).generate(dt=0.02)
    reached = arm.forward_kinematics(made.positions[-1])[0]
    print(
        f"conditioned on the seventh: ends {1e3 * np.linalg.norm(reached - places[6]):.3f} mm off"
    )

    figure = plt.figure(figsize=(8, 3.2), layout="constrained")
    left, right = figure.subplots(1, 2)
    for each in shown:
        left.plot(TIMES, each.positions[:, 0], color="0.7", linewidth=0.8)
    left.plot(made.times, made.positions[:, 0], label="learned, new goal")
    right.plot(TIMES, np.gradient(shown[0].positions[:, 0], TIMES), color="0.7", label="shown")
    right.plot(made.times, np.gradient(made.positions[:, 0], made.times))
    left.set(xlabel="time, s", ylabel="joint 1, rad")
    right.set(xlabel="time, s", ylabel="its velocity, rad/s")
    figure.legend(loc="outside lower center", ncols=2)
    figure.savefig(folder / "dls_demonstrations.png", dpi=110)
    print(f"wrote {folder / 'dls_demonstrations.png'}")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
