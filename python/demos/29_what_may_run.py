"""A policy's chunks, good and bad, before they reach the arm: what may run of them, and why.

python python/demos/29_what_may_run.py
"""

from time import process_time

import numpy as np

import leadthrough as lt

RATE, SAMPLES = 50.0, 50
arm = lt.Arm.load("panda")
q = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
table = lt.Box((1.0, 1.6, 0.05), (0.6, 0.0, 0.0))
post = lt.Cylinder(0.05, 1.0, (0.45, -0.3, 0.5))
guard = lt.Guard(arm, [table, post], rate=RATE)
guard.admit(q[None], q)

times = np.arange(1, SAMPLES + 1)[:, None] / RATE
rng = np.random.default_rng(0)


def wave(size):
    """A second of motion that begins and ends at rest."""
    return size * (1.0 - np.cos(2.0 * np.pi * times)) * [0.5, 0.3, 0.2, -0.3, 0.4, 0.2, 0.5]


jump = wave(0.2)
jump[25:] += 0.3
hole = wave(0.2)
hole[10] = np.nan
chunks = {
    "slow": wave(0.2),
    "with a jump": jump,
    "too fast": wave(1.5),
    "with noise": wave(0.2) + rng.normal(0.0, 0.002, (SAMPLES, 7)),
    "with a NaN": hole,
    "into the post": times**2 * [-1.0, 0.2, 0, 0.2, 0, 0, 0],
}
for name, chunk in chunks.items():
    begin = process_time()
    answer = guard.admit(guard.state.q + chunk)
    spent = 1e3 * (process_time() - begin)
    print(f"{name} ({spent:.1f} ms): {answer}")
    while guard.remaining:
        guard.next()  # what a controller is sent, every period

# A person steps in while the arm moves: it keeps clear of wherever they may be by then.
guard.admit(guard.state.q + wave(-0.6))
person = lt.guard.Moving(lt.Capsule(0.25, 1.2, (0.2, 1.1, 0.6)), speed=1.0)
print(f"a person: {guard.world([table, post, person])}")
while guard.remaining:
    guard.next()
print(f"at rest: {not guard.next().qd.any()}, clear: {arm.is_clear(guard.state.q, [table, post])}")
