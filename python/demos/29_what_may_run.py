"""A policy's chunks, good and bad, before they reach the arm: what may run of them, and why.

Writes commanded.json: python python/demos/29_what_may_run.py [FOLDER]
"""

import sys
from pathlib import Path

import numpy as np

import leadthrough as lt

RATE = 50.0
arm = lt.Arm.load("panda")
q = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
table = lt.Box((1.0, 1.6, 0.05), (0.6, 0.0, 0.0))
post = lt.Cylinder(0.05, 1.0, (0.45, -0.3, 0.5))
guard = lt.Guard(arm, [table, post], rate=RATE)
guard.admit(q[None], q)
commanded = [q]

times = np.arange(1, 51)[:, None] / RATE


def wave(size):
    """A second of motion that begins and ends at rest."""
    return size * (1.0 - np.cos(2.0 * np.pi * times)) * [0.5, 0.3, 0.2, -0.3, 0.4, 0.2, 0.5]


jump, hole = wave(0.2), wave(0.2)
jump[25:] += 0.3
hole[10] = np.nan
chunks = {
    "slow": wave(0.2),
    "with a jump": jump,
    "too fast": wave(1.5),
    "with noise": wave(0.2) + np.random.default_rng(0).normal(0.0, 0.002, (50, 7)),
    "with a NaN": hole,
    "into the post": times**2 * [-1.0, 0.2, 0, 0.2, 0, 0, 0],
}
for name, chunk in chunks.items():
    print(f"{name}: {guard.admit(guard.state.q + chunk)}")
    while guard.remaining:
        commanded.append(guard.next().q)  # what a controller is sent, every period

# A person steps in while the arm moves.
guard.admit(guard.state.q + wave(0.6))
person = lt.guard.Moving(lt.Capsule(0.25, 1.2, (0.2, 0.7, 0.6)), speed=0.8)
print(f"a person: {guard.world([table, post, person])}")
while guard.remaining:
    commanded.append(guard.next().q)

clock = np.arange(len(commanded)) / RATE
sent = lt.connect(q, lt.JointTrajectory(clock, commanded), arm, obstacles=[table, post])
kept = lt.check_limits(sent, arm.limits).ok
print(f"limits kept: {kept}, clear: {arm.check(sent, [table, post]).ok}")
file = Path(sys.argv[1] if len(sys.argv) > 1 else ".") / "commanded.json"
lt.write_motion(sent, file)
print(f"wrote {file}")
