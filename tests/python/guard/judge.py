"""Judges of what a guard lets through that share no code with it: differences, and coal."""

from itertools import pairwise

import motions
import numpy as np
import pinocchio as pin

from leadthrough_studies.coal_arm import CoalArm

EXCESS = 1e-6
_ROUNDING = 1e-9  # rad, of positions
_TOUCHING = 1e-6  # m
_STEP = 0.01  # rad, between configurations that are looked at


def worst_use(positions, limits, rate):
    """The largest ratio of a limit of velocity, acceleration and jerk that a stream uses.

    The arm rests before and after. Differences due to rounding of the positions are taken
    off. A position outside of its limits counts as infinite.
    """
    outside = (positions < limits.lower - _ROUNDING) | (positions > limits.upper + _ROUNDING)
    if outside.any() or not np.isfinite(positions).all():
        return np.inf
    padded = np.concatenate([positions[:1].repeat(3, 0), positions, positions[-1:].repeat(3, 0)])
    ulp = np.spacing(np.abs(padded).max(axis=0))
    worst = 0.0
    jerk = 7.0 / 6.0 * limits.jerk
    for order, limit in enumerate((limits.velocity, limits.acceleration, jerk), 1):
        used = np.abs(np.diff(padded, order, axis=0)) - 2.0**order * ulp
        worst = max(worst, float((used * rate**order / limit).max()))
    return worst


class CoalScene:
    """An arm among obstacles, in coal by Pinocchio, with the URDF's own shapes."""

    def __init__(self, arm, name, obstacles, meet):
        urdf = str(motions.urdf(name))
        self.model = pin.buildModelFromUrdf(urdf)
        self.geometry = pin.buildGeomFromUrdf(self.model, urdf, pin.GeometryType.COLLISION)
        own = [(g.name.rpartition("_")[0], i) for i, g in enumerate(self.geometry.geometryObjects)]
        moving = [i for _, i in own if self.geometry.geometryObjects[i].parentJoint > 0]
        for pair in arm.collision_pairs.checked:
            if pair in meet:
                continue
            for i in [i for link, i in own if link == pair[0]]:
                for k in [k for link, k in own if link == pair[1]]:
                    self.geometry.addCollisionPair(pin.CollisionPair(min(i, k), max(i, k)))
        peer = CoalArm(arm)
        for number, obstacle in enumerate(obstacles):
            shape, placement = peer.solid(getattr(obstacle, "shape", obstacle))
            thing = pin.GeometryObject(f"obstacle {number}", 0, 0, placement, shape)
            at = self.geometry.addGeometryObject(thing)
            for i in moving:
                self.geometry.addCollisionPair(pin.CollisionPair(i, at))
        self.data = self.model.createData()
        self.geometry_data = self.geometry.createData()
        for request in self.geometry_data.collisionRequests:
            request.security_margin = -_TOUCHING

    def touches(self, q):
        full = pin.neutral(self.model)
        for joint, value in zip(list(self.model.joints)[1:], q, strict=True):
            whole = value if joint.nq == 1 else (np.cos(value), np.sin(value))
            full[joint.idx_q : joint.idx_q + joint.nq] = whole
        return pin.computeCollisions(
            self.model, self.data, self.geometry, self.geometry_data, full, True
        )

    def contacts(self, positions):
        """How many of the steps of a stream touch something, looked at finely."""
        count = 0
        for a, b in pairwise(positions):
            parts = max(1, int(np.ceil(np.abs(b - a).max() / _STEP)))
            if (a == b).all():
                continue
            count += any(self.touches(a + (b - a) * k / parts) for k in range(1, parts + 1))
        return count


def meeting(arm):
    """Pairs of links that touch by their URDF and never overlap: no guard can keep them apart."""
    coal_arm = CoalArm(arm)
    rng = np.random.default_rng(0)
    lower, upper = np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)
    gaps = []
    for q in rng.uniform(lower, upper, (100, len(lower))):
        coal_arm.place(q)
        gaps.append([coal_arm.link_distance(*pair) for pair in arm.collision_pairs.checked])
    least = np.min(gaps, axis=0)
    return {
        pair
        for pair, gap in zip(arm.collision_pairs.checked, least, strict=True)
        if abs(gap) < _TOUCHING
    }
