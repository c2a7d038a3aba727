"""Copies of real demonstrations, in each of which one is spoiled in a known way."""

from dataclasses import replace

import numpy as np

from leadthrough import PoseTrajectory, rotations


def extent(motion):
    return np.linalg.norm(np.ptp(motion.positions, axis=0))


def fractions(motion):
    return np.linspace(0.0, 1.0, len(motion.times))


def sampled(motion, at):
    """The motion with the same clock, at other fractions of its duration."""
    times = motion.times[0] + at * motion.duration
    positions = np.column_stack([np.interp(times, motion.times, c) for c in motion.positions.T])
    if not isinstance(motion, PoseTrajectory):
        return replace(motion, positions=positions)
    inside = np.clip(times, *motion.times[[0, -1]])
    orientations = rotations.interpolate(motion.times, motion.orientations, inside)
    return replace(motion, positions=positions, orientations=orientations)


def jerky(motion, others, rng):
    """A tremor of 1 % of the extent, with some 20 swings, strongest in the middle."""
    phase = fractions(motion)[:, None]
    size = (3, motion.positions.shape[1])
    swings, shifts = rng.uniform(12, 25, size), rng.uniform(0, 2 * np.pi, size)
    waves = np.sin(2 * np.pi * swings * phase[..., None].repeat(3, 1) + shifts).sum(axis=1)
    tremor = 0.01 * extent(motion) * np.sin(np.pi * phase) * waves
    return replace(motion, positions=motion.positions + tremor)


def stalled(motion, others, rng):
    """Rests for a quarter of the time or more."""
    phase, when, long = fractions(motion), rng.uniform(0.3, 0.7), rng.uniform(0.25, 0.4)
    begin = when * (1 - long)
    return sampled(motion, np.interp(phase, [0, begin, begin + long, 1], [0, when, when, 1]))


def misaligned(motion, others, rng):
    return sampled(motion, fractions(motion) ** rng.choice([2.5, 0.4]))


def outlier(motion, others, rng):
    """A bump of 35 % of the extent."""
    aside = rng.normal(size=motion.positions.shape[1])
    aside *= 0.35 * extent(motion) / np.linalg.norm(aside)
    bump = np.sin(np.pi * fractions(motion)[:, None]) ** 2 * aside
    return replace(motion, positions=motion.positions + bump)


def other_mode(motion, others, rng):
    """The path of another motion between the same ends."""
    other = others[rng.integers(len(others))]
    at = other.times[0] + fractions(motion) * other.duration
    path = np.column_stack([np.interp(at, other.times, c) for c in other.positions.T])
    path *= extent(motion) / extent(other)
    rise = fractions(motion)[:, None]
    ends = motion.positions[[0, -1]] - path[[0, -1]]
    return replace(motion, positions=path + (1 - rise) * ends[0] + rise * ends[1])


FAULTS = (jerky, stalled, outlier, other_mode, misaligned)


def copies(sets, seed):
    """For each set and fault: the motions, and the index of the spoiled one.

    Args:
        sets: motions by name, all of one type and size.
        seed: of the random number generator.
    """
    rng = np.random.default_rng(seed)
    for name, motions in sets.items():
        others = [each[0] for other, each in sets.items() if other != name]
        for fault in FAULTS:
            spoiled = int(rng.integers(len(motions)))
            copy = list(motions)
            copy[spoiled] = fault(motions[spoiled], others, rng)
            yield fault.__name__, copy, spoiled
