"""Models of dynamical systems: from demonstrations, sampled about their goals, to a skill."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Generic

import numpy as np
from scipy.ndimage import gaussian_filter1d

from leadthrough import rotations
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import FitError, Float64Array, Frozen
from leadthrough.models.coordinates import Coordinates, coordinates_of, mean_orientations
from leadthrough.models.dynamical.field import MAX_DURATION, Field, endpoints
from leadthrough.models.dynamical.skill import DynamicalSkill
from leadthrough.models.protocol import Demonstrations, Outliers, Unfitted, motions_of
from leadthrough.motion import Motion, MotionT, MotionT_co, PoseTrajectory, lerp, normalised_times
from leadthrough.noise import without_noise

# Evenly spaced samples of each demonstration, and the deviation over which they are smoothed.
_SAMPLES, _SMOOTHING = 201, 2.0
# Every second one is fitted.
_EVERY = 2
# A system is nowhere at rest but at its goal: samples at both ends that are slower than these
# fractions of the demonstration's largest speed are left out.
_SLOW_START, _SLOW_END = 0.1, 0.02
# Digits after rounding: the same motion in another unit is then fitted to the same bits.
_DIGITS = 9
NEAR_GOAL = 0.1  # sizes of the motion
_MIN_REACH = 1e-3  # of rotations, rad, where the demonstrations do not turn


@dataclass(frozen=True, eq=False)
class Samples(Frozen, Generic[MotionT_co]):
    """Demonstrations about their goals, normalised.

    Attributes:
        coordinates: of the d columns; of poses the position and a rotation vector from the goal.
        scale: divisors (d,) of the columns; the same for all positions, joints or rotations.
        duration: median duration of the demonstrations, s, the unit of time.
        ends: mean start and goal (2, d) in the columns of `coordinates`.
        positions: positions (n, d) of each demonstration, normalised.
        velocities: velocities (n, d) of each demonstration, normalised.
        approaches: time of each one, in durations, from its first sample until it is within a
            tenth of its size of the goal for good.
    """

    coordinates: Coordinates[MotionT_co]
    scale: Float64Array
    duration: float
    ends: Float64Array
    positions: Sequence[Float64Array]
    velocities: Sequence[Float64Array]
    approaches: Float64Array

    @property
    def x(self) -> Float64Array:
        """All positions (n, d)."""
        return np.concatenate(self.positions)

    @property
    def v(self) -> Float64Array:
        """All velocities (n, d)."""
        return np.concatenate(self.velocities)


def samples_about_goals(
    demonstrations: Demonstrations[MotionT], *, outliers: Outliers = "keep"
) -> Samples[MotionT]:
    """Samples of demonstrations, each about its own goal."""
    motions = motions_of(demonstrations, outliers=outliers)
    phases = [normalised_times(motion.times) for motion in motions]
    coordinates = coordinates_of(motions, phases, middle=_goal)
    columns = [_about_goal(motion) for motion in motions]
    duration = float(np.median([motion.duration for motion in motions]))
    scale = _reach(columns, coordinates)
    starts = np.mean([each[0] for each in columns], axis=0)
    goals = np.mean([motion.positions[-1] for motion in motions], axis=0)
    goal = np.concatenate([goals, np.zeros(coordinates.width - coordinates.size)])
    durations = np.array([motion.duration for motion in motions]) / duration
    parts = [
        _moving_part(normalised_times(motion.times), each / scale, float(lasting))
        for motion, each, lasting in zip(motions, columns, durations, strict=True)
    ]
    return Samples(
        coordinates,
        scale,
        duration,
        np.array([goal + starts, goal]),
        [each[0] for each in parts],
        [each[1] for each in parts],
        np.array([each[2] for each in parts]),
    )


def _goal(layers: Sequence[Float64Array]) -> Float64Array:
    """The mean orientation at the goal, as a reference (201, 4) that does not turn."""
    mean = mean_orientations([each[[-1, -1]] for each in layers])[-1]
    return np.tile(mean, (len(layers[0]), 1))


def _about_goal(motion: Motion) -> Float64Array:
    """The columns (n, d) of a motion, 0 at its own end; rotation vectors are continuous."""
    offsets = motion.positions - motion.positions[-1]
    if not isinstance(motion, PoseTrajectory):
        return np.asarray(offsets)
    goal = rotations.inverse(np.tile(motion.orientations[-1], (len(offsets), 1)))
    vectors: Float64Array = rotations.lift(
        rotations.compose(goal, motion.orientations), anchor="goal"
    )
    if np.linalg.norm(vectors, axis=1).max() >= 2.0 * np.pi:
        raise FitError(
            "demonstrations: expected orientations within a full turn of the goal's, got more; "
            "use DMP for motions that turn further"
        )
    return np.asarray(np.hstack([offsets, vectors]))


def _reach(columns: Sequence[Float64Array], coordinates: Coordinates) -> Float64Array:
    """The mean distance (d,) of the farthest samples from the goal, in each group of columns."""
    scale = np.empty(coordinates.width)
    for group in (slice(0, coordinates.size), slice(coordinates.size, coordinates.width)):
        far = [np.linalg.norm(each[:, group], axis=1).max() for each in columns]
        scale[group] = max(float(np.mean(far)), _MIN_REACH if group.start else 0.0) or 1.0
    return scale


def _moving_part(
    phases: Float64Array, columns: Float64Array, duration: float
) -> tuple[Float64Array, Float64Array, float]:
    """Positions and velocities (n, d) of a demonstration where it moves, and its approach."""
    even = np.linspace(0.0, 1.0, _SAMPLES)
    clean = without_noise(columns)
    path = lerp(even, phases, clean)
    smooth = gaussian_filter1d(path, _SMOOTHING, axis=0, mode="nearest")
    velocity = np.gradient(smooth, duration / (_SAMPLES - 1), axis=0)
    speed = np.linalg.norm(velocity, axis=1)
    first = int(np.argmax(speed > _SLOW_START * speed.max()))
    last = _SAMPLES - int(np.argmax(speed[::-1] > _SLOW_END * speed.max()))
    rows = slice(first, max(last, first + 2), _EVERY)
    far = np.flatnonzero(np.linalg.norm(path, axis=1) > NEAR_GOAL)
    approach = even[far[-1] if len(far) else -1] - even[first]
    steps = max(approach, even[1]) * duration
    return path[rows].round(_DIGITS), velocity[rows].round(_DIGITS), float(steps)


# Largest factor by which a system's speed is changed: a slower one rests somewhere.
_MAX_PACE = 2.0


class DynamicalModel(Unfitted, ABC):
    """Base of models that learn a system; a derived frozen dataclass holds the settings.

    Attributes:
        system: class of the systems that `learn` returns, which files are read with.
        slider: a setting that a person may drag, with its least and largest value.
    """

    system: ClassVar[type[Field]]
    slider: ClassVar[tuple[str, int, int]]

    @one_blas_thread
    def fit(
        self, demonstrations: Demonstrations[MotionT], *, outliers: Outliers = "refuse"
    ) -> DynamicalSkill[MotionT]:
        """A skill from demonstrations.

        Args:
            demonstrations: one or more demonstrations, or motions: all of points, all of the same
                joints or all of poses.
            outliers: treatment of one that contradicts all others: "refuse", "drop" or "keep", as
                for `learn`.

        Raises:
            FitError: if there is none, one does not move or contradicts all others, orientations
                have no mean at the goal or turn by a full turn or more, or the goal is reached from
                no start.
            MissingDependency: if the model needs the extra `stable` and it is not installed.
        """
        samples = samples_about_goals(demonstrations, outliers=outliers)
        field = self.learn(samples)
        return DynamicalSkill(
            self,
            samples.coordinates,
            field,
            samples.scale,
            samples.ends,
            samples.duration,
            _pace(field, samples),
            samples.x,
        )

    @abstractmethod
    def learn(self, samples: Samples) -> Field:
        """The system of normalised demonstrations.

        Args:
            samples: their positions and velocities.
        """


def _pace(field: Field, samples: Samples) -> float:
    """Median ratio of the system's time from the demonstrations' starts to their own."""
    starts = field.states(np.array([each[0] for each in samples.positions]))
    reached = endpoints(field, starts, columns=field.size, near=NEAR_GOAL, longest=MAX_DURATION)
    if not reached.arrived.any():
        raise FitError(
            "demonstrations: the learned system does not reach the goal from any of their "
            "starts; use another model"
        )
    slower = float(np.median((reached.times / samples.approaches)[reached.arrived]))
    return min(max(slower, 1.0 / _MAX_PACE), _MAX_PACE)
