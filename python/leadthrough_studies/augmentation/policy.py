"""A policy of states that is trained on episodes, and its reaches on a simulated arm.

A network takes the joints and the goal, and returns a chunk of a second: how far the next 30 rows
of joints are from the present ones. Its optimizer is Adam (Kingma and Ba 2015).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.guard import Chunks, Guard
from leadthrough.simulation import SimulatedArm
from leadthrough_studies.augmentation.episodes import CHUNK, GOALS, HOME, RATE, TABLE, Episode
from leadthrough_studies.study import Row

LOOP = 250.0  # Hz, of commands and of the simulation
REACHED = 0.02  # m, of the tip from the goal at the end
AT_REST = 0.05  # rad/s, of every joint at the end
_DURATION = 6.0  # s of a reach
_EVERY = 0.5  # s between two chunks
_LAYERS = (128, 128)
_BATCH = 200  # rows of a gradient update
_UPDATES = 50  # that scikit-learn makes in a call


class Policy:
    """A trained network.

    Args:
        arm: the arm of the episodes.
        episodes: to learn.
        calls: of scikit-learn, each with the same number of gradient updates.
        seed: of the weights and of the rows of each update.
    """

    def __init__(self, arm: Arm, episodes: list[Episode], calls: int, seed: int) -> None:
        network = check.package("sklearn.neural_network", extra="policies")
        ends = arm.forward_kinematics(np.array([q[-1] for q, _ in episodes]))[0]
        pairs = zip(ends, episodes, strict=True)
        inputs = np.vstack([_inputs(q, goal) for goal, (q, _) in pairs])
        moves = np.vstack([wanted - q[:, None] for q, wanted in episodes]).reshape(len(inputs), -1)
        self._unit = float(moves.std())
        outputs = (moves / self._unit).astype(np.float32)
        rng = np.random.default_rng(seed)
        self._network: Any = network.MLPRegressor(
            hidden_layer_sizes=_LAYERS, batch_size=_BATCH, random_state=seed
        )
        for _ in range(calls):
            rows = rng.integers(len(inputs), size=_BATCH * _UPDATES)
            self._network.partial_fit(inputs[rows], outputs[rows])

    def chunk(self, q: Float64Array, goal: Float64Array) -> Float64Array:
        """The next moves (CHUNK, joints) from the present joints."""
        found = self._network.predict(_inputs(q[None], goal))
        return np.asarray(self._unit * found.reshape(CHUNK, -1), np.float64)


def _inputs(q: Float64Array, goal: Float64Array) -> Float64Array:
    """Rows (n, joints + 3) of the network, about one in size."""
    place = (goal - GOALS.middle) / (GOALS.upper - GOALS.middle)
    return np.hstack([2.0 * (q - HOME), np.tile(place, (len(q), 1))]).astype(np.float32)


def reach(arm: Arm, policy: Policy, goal: Float64Array) -> Row:
    """Distance and speed at the end of a reach from home, contacts, and whether it succeeded."""
    robot = SimulatedArm(arm, HOME, [TABLE], rate=LOOP)
    chunks = Chunks(Guard(arm, [TABLE], rate=LOOP), rate=RATE, actions="relative")
    chunks.start(HOME)
    contacts = 0
    for tick in range(round(_DURATION * LOOP)):
        if tick % round(_EVERY * LOOP) == 0:
            q = robot.q
            chunks.put(policy.chunk(q, goal), robot.time + 1.0 / RATE, measured=q)
        robot.step(chunks.next())
        contacts += bool(robot.touches)
    distance = float(np.linalg.norm(arm.forward_kinematics(robot.q)[0] - goal))
    speed = float(np.abs(robot.qd).max())
    success = distance < REACHED and speed < AT_REST and not contacts
    return {
        "success": int(success),
        "distance_m": round(distance, 5),
        "speed": round(speed, 5),
        "contacts": contacts,
    }
