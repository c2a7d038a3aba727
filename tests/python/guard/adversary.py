"""Streams of adversarial chunks, and the answers of a guard to them.

PYTHONPATH=tests/python python -m guard.adversary --chunks 100000 --robot panda
"""

import argparse
import json
import time

import numpy as np
from guard.judge import EXCESS, CoalScene, meeting, worst_use

import leadthrough as lt

RATE = 50.0
SAMPLES = 50
MARGIN = 0.005
HOMES = {
    "panda": np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7]),
    "ur3": np.array([0.0, -1.2, 1.4, -1.7, -1.5, 0.3]),
}
KINDS = (
    "smooth", "jump", "reversal", "noise", "fast", "far", "constant", "one", "spikes", "nan",
    "steps", "huge",
)  # fmt: skip


def smooth(rng, q, size=0.4):
    """A sum of slow waves that begins at a place."""
    t = np.arange(1, SAMPLES + 1)[:, None] / RATE
    turns = rng.uniform(0.1, 0.6, len(q))
    return q + size * rng.normal(size=len(q)) * (1.0 - np.cos(2.0 * np.pi * turns * t))


def chunk(rng, kind, q):
    """An adversarial chunk for an arm at a place."""
    rows = smooth(rng, q)
    joints = len(q)
    if kind == "jump":
        rows[rng.integers(1, SAMPLES) :] += rng.normal(0.0, 0.7, joints)
    elif kind == "reversal":
        rows = np.concatenate([rows[: SAMPLES // 2], rows[: SAMPLES // 2][::-1]])
    elif kind == "noise":
        rows += rng.normal(0.0, 10.0 ** rng.uniform(-4, -1), rows.shape)
    elif kind == "fast":
        rows = smooth(rng, q, size=2.0)
    elif kind == "far":
        rows += rng.normal(0.0, 3.0, joints)
    elif kind == "constant":
        rows = np.tile(q + rng.normal(0.0, 0.3, joints), (int(rng.integers(1, 20)), 1))
    elif kind == "one":
        rows = (q + rng.normal(0.0, 0.02, joints))[None]
    elif kind == "spikes":
        hit = rng.random(rows.shape) < 0.02
        rows = rows + hit * rng.normal(0.0, 2.0, rows.shape)
    elif kind == "nan":
        rows[rng.integers(SAMPLES), rng.integers(joints)] = rng.choice([np.nan, np.inf, -np.inf])
    elif kind == "steps":
        rows = rows[(np.arange(SAMPLES) // 7) * 7]
    elif kind == "huge":
        rows = rows + 10.0 ** rng.uniform(1, 300)
    return rows


def obstacle(rng):
    """A shape somewhere in the arm's reach."""
    place = rng.uniform([-0.8, -0.8, -0.1], [0.8, 0.8, 1.0])
    kind = rng.integers(3)
    if kind == 0:
        return lt.Box(rng.uniform(0.04, 0.3, 3), place)
    if kind == 1:
        return lt.Sphere(rng.uniform(0.03, 0.15), place)
    return lt.Capsule(rng.uniform(0.02, 0.08), rng.uniform(0.1, 0.5), place)


def clear_obstacles(rng, arm, q, count, room):
    """Obstacles that keep a distance from the arm where it is."""
    found = []
    while len(found) < count:
        one = obstacle(rng)
        if arm.distance(q, [one]) > room:
            found.append(one)
    return found


def run_stream(arm, rng, scene, *, chunks, appear=0.1):
    """One stream: the commands, the worlds that they were given in, and the guard's answers.

    Args:
        arm: the arm.
        rng: of all that is drawn.
        scene: makes a judge of contacts of obstacles.
        chunks: how many.
        appear: probability that the obstacles change before a chunk.
    """
    q = HOMES["panda" if len(arm.joint_names) == 7 else "ur3"]
    world = clear_obstacles(rng, arm, q, 5, 0.05)
    guard = lt.Guard(arm, lt.Scene(world, MARGIN), rate=RATE)
    guard.admit(q[None], q)
    commanded, contacts, unsafe, unsafe_hits = [q], 0, 0, 0
    verdicts = {"allowed": 0, "changed": 0, "braking": 0}
    spent = []
    judge = scene(world)

    def run(count):
        nonlocal contacts, unsafe_hits
        safe, first = guard.safe, len(commanded) - 1
        commanded.extend(guard.next().q for _ in range(count))
        hits = judge.contacts(np.array(commanded[first:]))
        if safe:
            contacts += hits
        else:
            unsafe_hits += hits

    for _ in range(chunks):
        if rng.random() < appear:
            room = 0.03 if rng.random() < 0.9 else -1.0
            world = clear_obstacles(rng, arm, commanded[-1], 5, room)
            judge = scene(world)
            answer = guard.update_obstacles(world)
            unsafe += not answer.safe
        kind = KINDS[rng.integers(len(KINDS))]
        rows = chunk(rng, kind, commanded[-1])
        begin = time.process_time()
        answer = guard.admit(rows)
        spent.append(time.process_time() - begin)
        verdicts[answer.verdict] += 1
        late = rng.random() < 0.1
        run(int(rng.integers(80, 120) if late else rng.integers(1, 25)))
    run(guard.remaining + 3)
    return {
        "positions": np.array(commanded), "contacts": contacts, "unsafe": unsafe,
        "unsafe_hits": unsafe_hits, "verdicts": verdicts, "spent": spent,
    }  # fmt: skip


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--chunks", type=int, default=1000)
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    arm = lt.Arm.load(options.robot)
    meet = meeting(arm)
    total = dict.fromkeys(("chunks", "samples", "violations", "contacts", "moving_at_end"), 0)
    total |= dict.fromkeys(("unsafe", "unsafe_hits", "allowed", "changed", "braking"), 0)
    worst, spent = 0.0, []
    for number in range(-(-options.chunks // 40)):
        rng = np.random.default_rng([options.seed, number])
        found = run_stream(arm, rng, lambda w: CoalScene(arm, options.robot, w, meet), chunks=40)
        used = worst_use(found["positions"], arm.limits, RATE)
        worst = max(worst, used)
        total["chunks"] += 40
        total["samples"] += len(found["positions"])
        total["violations"] += used > 1.0 + EXCESS
        total["moving_at_end"] += bool(np.ptp(found["positions"][-3:], axis=0).any())
        for name in ("contacts", "unsafe", "unsafe_hits"):
            total[name] += found[name]
        for name, count in found["verdicts"].items():
            total[name] += count
        spent += found["spent"]
    total |= {"worst_use": worst, "median_ms": 1e3 * float(np.median(spent))}
    total |= {"p99_ms": 1e3 * float(np.quantile(spent, 0.99)), "most_ms": 1e3 * max(spent)}
    print(json.dumps(total, indent=1))


if __name__ == "__main__":
    main()
