"""An arm that is led by its tip: inside its limits, clear of itself and of obstacles.

The tip follows a target with a short lag, as fast as the joints may move; where something is in its
path it slides along or stops.
"""

from __future__ import annotations

import json
import math

import numpy as np

from leadthrough import rotations
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.motion import JointTrajectory
from leadthrough.shapes import Scene
from leadthrough.show.animation import link_motion

# Time in which the tip comes nearer to its target by a factor of e, s: a pointer's jitter is gone.
_LAG = 0.06
_MAX_SPEED = 0.6  # m/s, of a tip that is led by hand
_MAX_TURN = 1.5  # rad/s
# Fraction of the joints' velocity limits at which the arm is led.
_OF_LIMITS = 0.9
# An inverse kinematics that answers with farther joints has changed to another branch, rad.
_MAX_JUMP = 0.4
# Parts of a blocked step that are tried in turn: along obstacles, and less of it.
_PARTS = np.array(
    [(1, 1, 1), (1, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1), (1, 0, 0), (0, 1, 0), (0.3, 0.3, 0.3)]
)
_FULL_POSE = 6  # joints; with fewer, the orientation is left free
_CANDIDATES, _SHORT_LIST = 2000, 60
# Of the tip at the first configuration, as fractions of the largest coordinate that it can have.
_IN_FRONT, _ABOVE = 0.5, 0.15
_DOWN = np.array([0.0, 1.0, 0.0, 0.0])  # w, x, y, z


class LedArm:
    """The configuration of an arm and the target that its tip follows."""

    def __init__(self, arm: Arm, scene: Scene) -> None:
        self.arm, self.scene = arm, scene
        self.q = first_configuration(arm, scene)
        self.blocked = ""  # the reason why the tip does not follow its target
        self._target: tuple[Float64Array, Float64Array] | None = None

    @property
    def tip(self) -> tuple[Float64Array, Float64Array]:
        """Position (3,) and orientation (4,) of the tip."""
        return self.arm.forward_kinematics(self.q)

    def lead(self, position: Float64Array) -> None:
        """Sets the position that the tip follows."""
        self._target = position, (self._target or self.tip)[1]

    def turn(self, vector: Float64Array) -> None:
        """Turns the target by a rotation vector (3,) in the base frame."""
        position, orientation = self._target or self.tip
        turned = rotations.compose(rotations.exp(vector[None]), orientation[None])[0]
        self._target = position, turned

    def message(self) -> str:
        """Poses of the links, and the reason why the tip does not follow, for the page."""
        _, positions, orientations = link_motion(self.arm, self.q[None])
        poses = np.concatenate([positions, orientations], axis=2).ravel().round(5).tolist()
        return json.dumps({"kind": "poses", "poses": poses, "why": self.blocked})

    def release(self) -> None:
        """The tip stays where it is."""
        self._target, self.blocked = None, ""

    def put(self, q: Float64Array) -> None:
        """Takes a configuration (joints,) without a motion."""
        self.release()
        self.q = np.clip(q, self.arm.limits.lower, self.arm.limits.upper)

    def advance(self, dt: float) -> bool:
        """Follows the target for dt s; whether the arm moved."""
        if self._target is None:
            return False
        near = 1.0 - math.exp(-dt / _LAG)
        position, orientation = self.tip
        step = near * (self._target[0] - position)
        step *= min(1.0, _MAX_SPEED * dt / (float(np.linalg.norm(step)) or 1.0))
        back = rotations.inverse(orientation[None])
        turn = near * rotations.log(rotations.compose(self._target[1][None], back))[0]
        turn *= min(1.0, _MAX_TURN * dt / (float(np.linalg.norm(turn)) or 1.0))
        before, self.blocked = self.q, ""
        self.q = self._stepped(position, orientation, step, turn, dt)
        return not np.array_equal(before, self.q)

    def _stepped(
        self, position: Float64Array, orientation: Float64Array, step: Float64Array,
        turn: Float64Array, dt: float,
    ) -> Float64Array:  # fmt: skip
        """The configuration after the largest part of a step that the arm can make."""
        for part in _PARTS:
            turned = rotations.compose(rotations.exp(part.min() * turn[None]), orientation[None])[0]
            q = self._solved(position + part * step, turned, dt)
            if q is not None:
                return q
        return self.q

    def _solved(
        self, position: Float64Array, orientation: Float64Array, dt: float
    ) -> Float64Array | None:
        """A clear configuration at a pose, or on the way there; None if there is none nearby."""
        free = len(self.arm.joint_names) < _FULL_POSE
        found = self.arm.inverse_kinematics(position, None if free else orientation, q0=self.q)
        move = found.q - self.q
        if not found.success or np.abs(move).max() > _MAX_JUMP:
            limits = " and ".join(found.limiting_joints)
            self.blocked = f"{limits}: at its limit" if limits else "out of reach"
            return None
        most = float((np.abs(move) / (_OF_LIMITS * self.arm.limits.velocity * dt)).max())
        q = self.q + move / max(most, 1.0)
        edge = JointTrajectory(
            np.array([0.0, 1.0]), np.stack([self.q, q]), joint_names=self.arm.joint_names
        )
        if not self.arm.is_clear(edge, self.scene):
            self.blocked = "an obstacle or the arm itself is in the way"
            return None
        return q


def first_configuration(arm: Arm, scene: Scene) -> Float64Array:
    """A clear configuration (joints,) with room to lead the tip, in front of the base."""
    low, high = _bounds(arm)
    random = np.random.default_rng(0).uniform(0.15, 0.85, (_CANDIDATES, len(low)))
    rows = low + random * (high - low)
    best = rows[np.argsort(-_worth(arm, rows))][:_SHORT_LIST]
    tips = _tips(arm, best)
    down = [arm.inverse_kinematics(p, _DOWN, q0=q) for p, q in zip(tips, best, strict=True)]
    listed = np.array([each.q for each in down if each.success] or best)
    ranked = listed[np.argsort(-_worth(arm, listed))]
    clear = ranked[np.asarray(arm.is_clear(ranked, scene))]
    return np.asarray(clear[0] if len(clear) else ranked[0])


def _bounds(arm: Arm) -> tuple[Float64Array, Float64Array]:
    """The joints' limits, at most half a turn."""
    return arm.limits.lower.clip(-math.pi, math.pi), arm.limits.upper.clip(-math.pi, math.pi)


def _tips(arm: Arm, q: Float64Array) -> Float64Array:
    return arm.forward_kinematics(q)[0]


def _worth(arm: Arm, q: Float64Array) -> Float64Array:
    """How well the tip can be led from configurations (n, joints), in m per rad or less."""
    tips = _tips(arm, q)
    extent = float(np.abs(tips).max())
    room = np.linalg.svd(arm.jacobian(q)[:, :3], compute_uv=False)[:, -1]
    low, high = _bounds(arm)
    apart = np.minimum(q - low, high - q) / np.maximum(high - low, 1e-9)
    in_front = np.maximum(1.0 - 2.0 * np.abs(tips[:, 0] / extent - _IN_FRONT), 0.05)
    aside = 1.0 - np.minimum(np.abs(tips[:, 1]) / extent, 0.9)
    above = np.where(tips[:, 2] > _ABOVE * extent, 1.0, 0.1)
    return np.asarray(room * np.minimum(4.0 * apart.min(axis=1), 1.0) * in_front * aside * above)
