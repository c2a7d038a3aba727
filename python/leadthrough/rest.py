"""How fast a motion is at each of its samples, and when it rests.

Speeds are slopes of straight lines, fitted to the samples in a window about each one: of all linear
estimates the one that white noise disturbs least. How much of them is noise follows from the
recording itself: third differences of its samples are the noise's, as the motion has next to none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import cast

import numpy as np
from numpy.typing import NDArray

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.motion import (
    Demonstration,
    Motion,
    MotionT,
    PoseTrajectory,
    as_demonstration,
    clipped_events,
    kept,
)

# A motion that has begun may become slower than one that begins, by this factor.
HYSTERESIS = 0.5
# Third differences of white noise have this times its standard deviation, sqrt(1 + 9 + 9 + 1).
_THIRD_DIFFERENCES = np.sqrt(20.0)
_TO_SIGMA = 1.4826  # standard deviation per median absolute deviation of a normal distribution
_BEYOND_NOISE = 3.0  # standard deviations beyond the root mean square that noise does not reach
# A hand that holds an arm still moves it a little: by less than this fraction of its usual speed.
_TREMOR = 0.02
_USUAL = 90  # percentile of the speeds while something moves
_FEWEST = 5  # samples of a window
_ROUNDING = 1e-12  # of the extent; a slower motion is rounding
_UNCLEAR = 5.0  # times the speed of a hand at rest: noise of recordings stays below 2.5
_LONG = 0.05  # fraction of the time in motion; shorter rests are slow parts of the motion
# s: a short window finds the beginning to a tenth of a second; noise may need a longer one.
_WINDOWS = (0.2, 0.3, 0.5)


@dataclass(frozen=True)
class Thresholds:
    """At which speeds a motion begins; below `HYSTERESIS` times these it rests."""

    speed: float  # m/s, or the unit of the positions per second; rad/s of joints
    angular_speed: float  # of poses, rad/s


@dataclass(frozen=True, eq=False)
class Speeds:
    """How fast a motion is at its samples, and how much of that may be noise."""

    linear: Float64Array  # (n,) m/s, or the unit of the positions per second
    angular: Float64Array  # (n,) rad/s; 0 if the motion is not of poses
    noise: Float64Array  # bounds of noise alone in both, (n, 2)

    def thresholds(self) -> Thresholds:
        """The thresholds that follow from the noise and from the usual speed."""
        both = zip((self.linear, self.angular), self.noise.T, strict=True)
        return Thresholds(*(_threshold(speeds, noise) for speeds, noise in both))

    @property
    def noise_level(self) -> float:
        """Speeds that noise alone has, over those of a hand at rest in something that moves."""
        both = zip((self.linear, self.angular), self.noise.T, strict=True)
        levels = [(np.median(noise), _tremor(speeds, noise)) for speeds, noise in both]
        return max((float(noise / rest) for noise, rest in levels if rest > 0.0), default=0.0)

    def in_multiples_of(self, thresholds: Thresholds) -> Float64Array:
        """Speeds (n,) in multiples of their threshold; of poses the larger of the two."""
        return np.maximum(self.linear / thresholds.speed, self.angular / thresholds.angular_speed)


def speeds_of(motion: Motion, window: float) -> Speeds:
    groups = [_slopes(motion.times, motion.positions, window)]
    if isinstance(motion, PoseTrajectory):
        # A unit quaternion moves by half the angle.
        groups.append(_slopes(motion.times, 2.0 * motion.orientations, window))
    else:
        groups.append((np.zeros(len(motion.times)),) * 2)
    (linear, its_noise), (angular, noise_of_it) = groups
    return Speeds(linear, angular, np.column_stack([its_noise, noise_of_it]))


def thresholds_of(speeds: Speeds, speed: float | None, angular_speed: float | None) -> Thresholds:
    """The thresholds that a caller gives, each by default from the recording's own noise."""
    own = speeds.thresholds()
    return Thresholds(
        own.speed if speed is None else check.number(speed, "speed", above=0.0),
        own.angular_speed
        if angular_speed is None
        else check.number(angular_speed, "angular_speed", above=0.0),
    )


def runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """The ranges of True in flags (n,), as indices of the first one and after the last one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    return [(int(a), int(b)) for a, b in zip(edges[::2], edges[1::2], strict=True)]


def rests(
    motion: Motion, *, speed: float | None, angular_speed: float | None, pause: float
) -> list[tuple[float, float]]:
    """When the motion rests: start and end of each rest, s."""
    speeds = speeds_of(motion, pause)
    moving = speeds.in_multiples_of(thresholds_of(speeds, speed, angular_speed))
    still = moving < HYSTERESIS
    found = [(float(motion.times[a]), float(motion.times[b - 1])) for a, b in runs(still)]
    return [(start, end) for start, end in found if end - start >= pause]


@kept
def long_rests(motion: Motion) -> list[tuple[float, float]]:
    """Start and end, s, of rests longer than a twentieth of the time in motion; none in noise."""
    times = motion.times
    # Over a longer window, a reversal is as slow as a rest.
    speeds, window = _clearest_speeds(motion, longest=2.0 * _LONG * motion.duration)
    if speeds.noise_level > _UNCLEAR:
        return []
    window = max(window, _FEWEST * float(np.median(np.diff(times))))
    still = np.zeros(len(times), dtype=np.bool_)
    for a, b in runs(speeds.in_multiples_of(speeds.thresholds()) < HYSTERESIS):
        # Slopes rise as soon as half their window is in motion.
        still |= (times >= times[a] - 0.5 * window) & (times <= times[b - 1] + 0.5 * window)
    found = [] if still.all() else [(float(times[a]), float(times[b - 1])) for a, b in runs(still)]
    # Of the time in motion, so that a pause elsewhere does not hide a rest.
    shortest = _LONG * (motion.duration - sum(end - start for start, end in found))
    # Noise that sets the threshold hides the slow ends of a motion.
    margin = shortest if speeds.noise_level > 1.0 else -1.0
    return [
        (start, end)
        for start, end in found
        if end - start > shortest and start - times[0] > margin and times[-1] - end > margin
    ]


def white_noise(values: Float64Array) -> Float64Array:
    """Standard deviations (d,) of the white noise of columns (n, d), of which most is smooth."""
    if len(values) < _FEWEST:
        return np.zeros(values.shape[1])
    thirds = [np.median(np.abs(np.diff(column, 3))) for column in values.T]
    return np.asarray(_TO_SIGMA * np.array(thirds) / _THIRD_DIFFERENCES)


def _threshold(speeds: Float64Array, noise: Float64Array) -> float:
    """From the noise, and from the usual speed where something moves."""
    smallest = float(np.finfo(np.float64).tiny)
    return max(float(np.median(noise)), _tremor(speeds, noise), smallest) / HYSTERESIS


def _tremor(speeds: Float64Array, noise: Float64Array) -> float:
    """How fast a hand may move that holds still, from the usual speed; 0 if nothing moves."""
    moving = speeds[speeds > noise]
    return _TREMOR * float(np.percentile(moving, _USUAL)) if len(moving) else 0.0


def _slopes(
    times: Float64Array, values: Float64Array, window: float
) -> tuple[Float64Array, Float64Array]:
    """The norm (n,) of the slopes of lines fitted around each time, and what noise reaches."""
    if len(times) < 2:
        return np.zeros(len(times)), np.zeros(len(times))
    first, after = _windows(times, window)
    t = times - times[0]
    count = (after - first).astype(np.float64)
    total_t, total_tt = _sums(t, first, after), _sums(t * t, first, after)
    spread = np.maximum(total_tt - total_t**2 / count, np.finfo(np.float64).tiny)
    slopes = np.empty(values.shape)
    for slope, column in zip(slopes.T, values.T, strict=True):  # in turn, for the memory's sake
        x = column - column[0]
        mean = _sums(x, first, after) / count
        slope[:] = (_sums(t * x, first, after) - total_t * mean) / spread
    extent = float(np.ptp(values, axis=0).max())
    sigma = white_noise(values)
    reach = float(np.linalg.norm(sigma)) + _BEYOND_NOISE * float(sigma.max())
    noise = (reach + _ROUNDING * extent) / np.sqrt(spread)
    return np.linalg.norm(slopes, axis=1), noise


def _sums(values: Float64Array, first: NDArray[np.intp], after: NDArray[np.intp]) -> Float64Array:
    """Sums over the samples from `first` to before `after`."""
    running = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray(running[after] - running[first])


def _windows(times: Float64Array, window: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The first sample and the one after the last of the window around each time."""
    least = _FEWEST * float(np.median(np.diff(times)))
    length = min(max(window, least), float(times[-1] - times[0]))
    start = np.clip(times - 0.5 * length, times[0], times[-1] - length)
    first = np.searchsorted(times, start - 1e-9 * length)
    after = np.searchsorted(times, start + (1.0 + 1e-9) * length, side="right")
    first = np.minimum(first, len(times) - 2)
    return first, np.maximum(after, first + 2)


def trim(
    demonstration: Demonstration[MotionT] | MotionT,
    *,
    rest: float = 0.0,
    speed: float | None = None,
    angular_speed: float | None = None,
) -> Demonstration[MotionT]:
    """The demonstration without the standing still at both ends; pauses within it stay.

    The motion goes from where one of its speeds exceeds half its threshold for the first time to
    where it does so for the last time, provided that it exceeds the threshold itself in between.
    Speeds are slopes over 0.2 s, of noisy recordings over up to 0.5 s: some 0.1 s of rest may stay.
    Times are as recorded; events before and after come with the first and the last sample. A
    motion that never moves stays whole.

    Args:
        demonstration: one to trim; a motion stands for a demonstration of it.
        rest: s of standing still to keep before and after, >= 0; infinite keeps all of it.
        speed: threshold, > 0, m/s, or the unit of the positions per second; of joints the norm over
            all of them, rad/s. By default it follows from the recording: twice what its noise
            reaches, and at least 4 % of its usual speed.
        angular_speed: threshold of poses, > 0, rad/s; by default as for `speed`.
    """
    demonstration = as_demonstration(demonstration, "demonstration")
    motion = demonstration.motion
    if rest == math.inf:
        return demonstration
    spare = check.number(rest, "rest", at_least=0.0)
    # Numbers of a damaged file, whose squares overflow, have no speed: the motion stays whole.
    with np.errstate(over="ignore", invalid="ignore"):
        speeds, _ = _clearest_speeds(motion)
        moving = speeds.in_multiples_of(thresholds_of(speeds, speed, angular_speed))
    found = [
        (first, after)
        for first, after in runs(moving >= HYSTERESIS)
        if (moving[first:after] >= 1.0).any()
    ]
    if not found:
        return demonstration
    first, last = motion.times[found[0][0]] - spare, motion.times[found[-1][1] - 1] + spare
    samples = slice(
        int(np.searchsorted(motion.times, first)),
        int(np.searchsorted(motion.times, last, side="right")),
    )
    piece = cast(MotionT, motion[samples])
    kept = replace(piece, events=clipped_events(motion.events, piece.times))
    return replace(demonstration, motion=kept)


def _clearest_speeds(motion: Motion, *, longest: float = math.inf) -> tuple[Speeds, float]:
    """Speeds by the shortest window that noise allows, and that window, s."""
    for each in _WINDOWS:
        window = min(each, longest)
        speeds = speeds_of(motion, window)
        if speeds.noise_level <= 1.0:  # the usual speed sets the thresholds
            break
    return speeds, window


def rest_at_ends(whole: Motion, trimmed: Motion) -> tuple[float, float]:
    """How long a motion stood still before and after what `trim` left of it, s."""
    return (
        float(trimmed.times[0] - whole.times[0]),
        float(whole.times[-1] - trimmed.times[-1]),
    )
