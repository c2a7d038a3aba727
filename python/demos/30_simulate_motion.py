"""Simulation under gravity, with real drives and four controllers, without and with faults.

Writes simulated.html: python python/demos/30_simulate_motion.py [FOLDER]   (extra `simulation`)
"""

import sys
from pathlib import Path

import numpy as np

import leadthrough as lt
from leadthrough.simulation import (
    CartesianImpedance,
    ComputedTorque,
    Disturbances,
    JointImpedance,
    PositionServo,
)

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda").with_attached(lt.Capsule(0.03, 0.1, (0.0, 0.0, 0.05)), mass=1.0)
start = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
reach = np.array([0.9, 0.5, -0.3, 0.5, 0.3, -0.2, 0.3])
way = lt.trajectories.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, 101))
motion = lt.retime(start + np.outer(way, reach), arm.limits)
tip, _ = arm.forward_kinematics(start + 0.6 * reach)
post = lt.Cylinder(0.03, 0.8, (tip[0], tip[1], 0.4))

for controller in (ComputedTorque(), PositionServo(), JointImpedance(), CartesianImpedance(2000.0)):
    report = lt.simulate(arm, motion, controller=controller)
    theory = 1e3 * np.abs(report.expected).max()
    print(
        f"{type(controller).__name__}: joints off by {1e3 * np.abs(report.errors).max():.1f} mrad "
        f"(theory {theory:.1f}), tip by {1e3 * report.tip_errors.max():.1f} mm, "
        f"{report.energy.sum():.1f} J"
    )

print("\nand what is found:")
weak = {**vars(arm.limits), "effort": 0.4 * arm.limits.effort}
faults = {
    "the payload is three times as heavy": lt.simulate(
        arm, motion, disturbances=Disturbances(payload=3.0)
    ),
    "a post that was not planned for": lt.simulate(arm, motion, [post]),
    "twice as fast": lt.simulate(arm, lt.JointTrajectory(0.5 * motion.times, motion.positions)),
    "less than half the torque": lt.simulate(
        lt.Arm.load("panda", limits=lt.arm.JointLimits(**weak)), motion
    ),
}
for name, report in faults.items():
    print(f"{name}: {report}")

lt.show.simulation_page(faults["a post that was not planned for"], folder / "simulated.html")
print(f"\nwrote {folder / 'simulated.html'}")
