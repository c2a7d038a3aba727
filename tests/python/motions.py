"""Motions and arms that tests share; none is built before a test asks for it."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

import leadthrough as lt
from leadthrough import rotations
from leadthrough.motion import with_derivatives  # noqa: F401


def minimum_jerk(phase):
    """The quintic that rises from 0 to 1 with phases in [0, 1], at rest at both ends."""
    u = np.clip(phase, 0.0, 1.0)
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2)


def urdf(name):
    """The path of a robot's URDF."""
    return Path(__file__).parents[2] / "robots" / name / f"{name}.urdf"


@cache
def arm(name):
    """A robot of the package."""
    return lt.Arm.load(name)


def configurations(arm, count, seed):
    """Random configurations (count, joints) inside the limits and within a half turn."""
    lower, upper = np.maximum(arm.limits.lower, -np.pi), np.minimum(arm.limits.upper, np.pi)
    return np.random.default_rng(seed).uniform(lower, upper, (count, len(lower)))


def motion_of(kind, times, positions, rotation_vectors=None, events=()):
    """A motion of "points", "joints" (a, b, c, ...) or "poses", along the same positions."""
    if kind == "points":
        return lt.Trajectory(times, positions, events)
    if kind == "joints":
        names = tuple("abcdefg"[: np.shape(positions)[1]])
        return lt.JointTrajectory(times, positions, joint_names=names, events=events)
    return lt.PoseTrajectory(times, positions, rotations.exp(rotation_vectors), events)


def arch(kind, shift=0.0, scale=1.0, *, turn=5.0, events=()):
    """An arch of 0.3 m in 1.5 s; poses turn by 290 degrees about an axis that leans with the shift.

    Points are drawings in a plane.
    """
    t = np.linspace(0.0, 1.0, 150)
    u = minimum_jerk(t)
    bow = 0.1 * np.sin(np.pi * u) + shift * (1 - u)
    third = {"points": [], "joints": [-0.2 * u], "poses": [0.1 * u]}[kind]
    positions = scale * np.column_stack([0.3 * u, bow, *third])
    return motion_of(kind, 1.5 * t, positions, np.outer(turn * u, [shift, 0.6, 0.8]), events)


def ring(kind, shift=0.0, scale=1.0):
    """One round of an ellipse in 1.5 s; poses swing about the first axis meanwhile."""
    t = np.linspace(0.0, 1.0, 150)
    angle = 2 * np.pi * np.append(t[:-1], 1.0)
    flat = np.column_stack([0.1 * np.cos(angle), (0.1 + shift) * np.sin(angle)])
    positions = np.pad(flat, ((0, 0), (0, kind == "poses")))
    swing = np.outer(0.5 * np.sin(2 * np.pi * t), [1.0, 0.0, 0.0])
    return motion_of(kind, 1.5 * t, scale * positions, swing)


def backwards(motion):
    """A motion from its last sample to its first, at the same times."""
    turned = {"positions": motion.positions[::-1]}
    if isinstance(motion, lt.PoseTrajectory):
        turned["orientations"] = motion.orientations[::-1]
    return replace(motion, **turned)


def reach(kind, seed, *, pace=1.0):
    """A reach of 0.3 m with a bow and a hold, each seed's a little different; also "drawings"."""
    rng = np.random.default_rng(seed)
    u = np.linspace(0.0, 1.0, 121)
    s = minimum_jerk(u / rng.uniform(0.65, 0.75))
    bow = np.sin(np.pi * s) * rng.uniform(0.08, 0.12)
    off = rng.normal(0.0, 0.01, 3)
    points = np.column_stack([0.3 * s, bow, 0.1 * s**2]) + np.outer(1.0 - s, off)
    times = pace * rng.uniform(1.8, 2.2) * u
    if kind == "drawings":
        return lt.Trajectory(times, points[:, :2])
    axis = np.array([0.2, 0.6, 0.8]) + rng.normal(0.0, 0.02, 3)
    return motion_of(kind, times, points, np.outer(1.5 * s, axis))


def two_pandas():
    """Two arms side by side that look the same way."""
    panda = lt.Arm.load("panda")
    return lt.DualArm(panda, panda, ((0.0, -0.8, 0.0), (1.0, 0.0, 0.0, 0.0)))
