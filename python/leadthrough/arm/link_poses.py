"""Poses of all links of a robot while its arm moves, including links on other branches."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

import leadthrough._core as core
from leadthrough import rotations
from leadthrough.arm.model import ArmModel
from leadthrough.check import Float64Array


def link_poses(arm: ArmModel, q: Float64Array) -> dict[str, tuple[Float64Array, Float64Array]]:
    """Rotations (n, 3, 3) and positions (n, 3), m, of each link in the frame of the arm's base."""
    values = _values(arm, q)
    links = arm.robot.links
    orientations = {0: np.tile(np.eye(3), (len(q), 1, 1))}
    positions = {0: np.zeros((len(q), 3))}
    for joint in arm.robot.tree:
        rotation, shift = _motion(joint, values)
        here = orientations[joint.parent]
        offset = joint.position + shift @ joint.rotation.T
        positions[joint.child] = positions[joint.parent] + np.einsum("nij,nj->ni", here, offset)
        orientations[joint.child] = here @ (joint.rotation @ rotation)
    base = links.index(arm.base)
    back = orientations[base].transpose(0, 2, 1)
    away = {i: positions[i] - positions[base] for i in positions}
    return {
        links[i]: (back @ orientations[i], np.einsum("nij,nj->ni", back, away[i]))
        for i in orientations
    }


def _values(arm: ArmModel, q: Float64Array) -> dict[str, Float64Array]:
    """Positions (n,) of each joint, by its name; meaningless for joints that mimic another."""
    moved = dict(zip(arm.joint_names, q.T, strict=True))
    values = {}
    for joint in arm.robot.tree:
        still = arm.locked_joints.get(joint.name, min(max(0.0, joint.lower), joint.upper))
        values[joint.name] = moved.get(joint.name, np.full(len(q), still))
    return values


def _motion(
    joint: core.Joint, values: Mapping[str, Float64Array]
) -> tuple[Float64Array, Float64Array]:
    """Rotations (n, 3, 3) and shifts (n, 3), m, of a joint's child from its pose at zero."""
    value = values[joint.name]
    if joint.mimic is not None:
        value = joint.mimic.multiplier * values[joint.mimic.joint] + joint.mimic.offset
    along = np.outer(value, joint.axis)
    still = np.zeros_like(along)
    if joint.kind == "prismatic":
        return np.tile(np.eye(3), (len(value), 1, 1)), along
    turn = along if joint.kind in ("revolute", "continuous") else still
    return rotations.to_matrix(rotations.exp(turn)), still
