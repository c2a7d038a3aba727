"""Motions of poses that turn far, and measures of how they were learned."""

from functools import cache

import numpy as np
from motions import minimum_jerk

import leadthrough as lt
from leadthrough import rotations

DURATION = 4.0
FIXED = np.array([1.0, 2.0, 2.0]) / 3.0


def about_fixed_axis(degrees, rate):
    """Turned by `degrees` (a function of the phase), sampled at `rate` Hz."""
    u = np.linspace(0.0, 1.0, int(DURATION * rate) + 1)
    return u, rotations.exp(np.radians(degrees(u))[:, None] * FIXED)


@cache
def about_turning_axis(degrees, rate):
    """A body that turns about an axis which turns itself by 50 degrees meanwhile."""
    u = np.linspace(0.0, 1.0, 4001)
    lean = 0.8 * u
    axis = np.column_stack([np.sin(lean), 0.3 * np.sin(2.0 * lean), np.cos(lean)])
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    speed = np.radians(degrees) * 30.0 * u**2 * (1.0 - u) ** 2
    q = rotations.integrate(u, speed[:, None] * axis, (1.0, 0.0, 0.0, 0.0))
    step = int(1000 / rate)
    return u[::step], q[::step]


def turn(degrees, rate):
    return about_fixed_axis(lambda u: degrees * minimum_jerk(u), rate)


def with_pause(rate):
    """250 degrees, with a pause of half the duration in the middle."""
    return about_fixed_axis(
        lambda u: 125.0 * (minimum_jerk(4.0 * u) + minimum_jerk(4.0 * u - 3.0)), rate
    )


def with_burst(rate):
    """200 of 240 degrees in a tenth of the duration."""
    return about_fixed_axis(
        lambda u: 40.0 * minimum_jerk(u) + 200.0 * minimum_jerk(10.0 * u - 5.0), rate
    )


def noisy(q, degrees):
    noise = np.random.default_rng(1).normal(0.0, np.radians(degrees), (len(q), 3))
    return rotations.compose(q, rotations.exp(noise))


def positions(u):
    s = minimum_jerk(u)
    return np.column_stack([0.3 * s, 0.1 * np.sin(2.0 * s), 0.2 * s**2])


def demonstration(u, q):
    return lt.PoseTrajectory(DURATION * u, positions(u), q)


def fitted(u, q, **settings):
    return lt.DMP(**settings).fit([demonstration(u, q)])


def errors_of(skill, u, q):
    """Degrees away from orientations at even phases."""
    made = skill.generate(dt=DURATION / (len(u) - 1))
    assert len(made.times) == len(u)
    return np.degrees(rotations.distance(made.orientations, q))


def angle_turned(q):
    return np.degrees(rotations.distance(q[:-1], q[1:]).sum())


def peak_speed(motion):
    steps = rotations.distance(motion.orientations[:-1], motion.orientations[1:])
    return (steps / np.diff(motion.times)).max()


def across(axis, count):
    """Unit vectors (count, 3) around an axis, square to it."""
    side = np.cross(axis, (0.0, 0.0, 1.0))
    side /= np.linalg.norm(side)
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)[:, None]
    return np.cos(angle) * side + np.sin(angle) * np.cross(axis, side)


def turned_by(q, degrees, axis):
    """An orientation (4,) turned about an axis of the base."""
    offset = rotations.exp(np.radians(degrees) * np.asarray(axis)[None])
    return rotations.compose(offset, q[None])[0]


def moved_goal(q, degrees):
    """The last orientation, turned about an axis across that of the motion."""
    return turned_by(q[-1], degrees, across(FIXED, 1)[0])


HARD = {
    "90 degrees, 1 kHz": turn(90, 1000),
    "exactly 180 degrees, 1 kHz": turn(180, 1000),
    "200 degrees, 100 Hz": turn(200, 100),
    "350 degrees, 100 Hz": turn(350, 100),
    "720 degrees, 1 kHz": turn(720, 1000),
    "720 degrees about a turning axis, 100 Hz": about_turning_axis(720, 100),
    "1080 degrees about a turning axis, 100 Hz": about_turning_axis(1080, 100),
    "170 degrees, 100 Hz": turn(170, 100),
    "250 degrees with a pause, 100 Hz": with_pause(100),
    "200 degrees in a burst, 100 Hz": with_burst(100),
}

HARD_AT_50_HZ = {
    **{f"{degrees} degrees": turn(degrees, 50) for degrees in (90, 170, 180, 200, 350, 720)},
    "720 degrees about a turning axis": about_turning_axis(720, 50),
    "1080 degrees about a turning axis": about_turning_axis(1080, 50),
    "a pause": with_pause(50),
    "a burst": with_burst(50),
}

WAVE = fitted(*about_turning_axis(720, 100))
