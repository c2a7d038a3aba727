"""Orientations as three coordinates that springs can move, chosen by `DMP(orientation=...)`.

The orientation of a pose primitive is exp(offset(u)) G(u) E(e), with the springs' coordinates e:

- "anchored": G is a C2 curve through orientations 15 degrees of rotation apart, passed by the angle
  covered up to phase u; e, the remaining rotation vector, stays small. A start or goal rotated from
  the demonstrated one enters as the offset, which changes as the demonstration rotates.
- "lifted": G is the goal, and e the continuous logarithm from there (Lauretti et al. 2023, eqs. 7
  to 9, with the angle counted past half a turn); refused beside whole turns, where there is none.
- "log": the plain logarithm, and "euler": ZYZ angles. Motions that jump there are learned wrongly.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

import leadthrough._core as core
from leadthrough import check, rotations
from leadthrough.check import FitError, Float64Array, InvalidInput, NoContinuousLogarithm, ShortRepr
from leadthrough.models.dmp.progress import running_mean

REPRESENTATIONS = ("anchored", "lifted", "log", "euler")

_ANCHOR_SPACING = np.radians(15.0)  # of rotation
# Largest coordinates about the anchored curve, rad, that are good enough, and that are too much.
# Finer curves follow bursts better, and noise too.
_GOOD_ERROR = np.radians(3.0)
_MAX_ERROR = np.radians(60.0)
_REFINEMENTS = 3
# The speed of rotation is tabulated in this many intervals of the phase, and smoothed by averaging
# twice over this fraction of the motion.
_INTERVALS = 1000
_SMOOTHING = 0.02

# Recorded noise, rad for each axis, that the curve is smoothed for; less is left to the weights.
# It is averaged twice over twice this fraction of the motion.
_NOISY = 0.004
_NOISE_SMOOTHING = 0.03
# Variance of second differences of the steps of white noise, and the median of a squared length in
# three dimensions, both over the variance of the noise.
_DIFFERENCED = 20.0
_MEDIAN = 2.366

_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
_ZERO = np.zeros(3)
_NO_OFFSET = core.DmpPath()


@dataclass(frozen=True, eq=False)
class OrientationCoordinates(ShortRepr):
    """Coordinates of orientations along a demonstrated motion."""

    representation: str  # one of REPRESENTATIONS
    controls: Float64Array  # (k + 3, 4) of the curve G, a cumulative cubic B-spline of k pieces
    speeds: Float64Array  # (m,) on the curve, in pieces per unit of phase, at evenly spaced phases
    start: Float64Array  # orientation (4,) as demonstrated
    goal: Float64Array  # orientation (4,) as demonstrated
    angle: float  # rad, the whole angle that the demonstration covers
    rhythmic: bool = False  # whether the curve closes and repeats

    @cached_property
    def curve(self) -> core.DmpCurve:
        turns = rotations.compose(rotations.inverse(self.controls[:-1]), self.controls[1:])
        covered = _covered(self.speeds)
        zyz = self.representation == "euler"
        return core.DmpCurve(
            self.controls, rotations.log(turns), self.speeds, covered, zyz, self.rhythmic
        )

    def offsets(
        self, start: Float64Array, goal: Float64Array, near: Float64Array | None = None
    ) -> tuple[Float64Array, Float64Array]:
        """Rotation vectors that rotate the curve at its start and at its end."""
        if self.representation == "euler":
            return _ZERO, _ZERO
        if self.representation != "anchored":
            last = core.dmp_offset(goal, self.goal, _ZERO)
            return last, last
        first = core.dmp_offset(start, self.start, _ZERO)
        return first, core.dmp_offset(goal, self.goal, first if near is None else near)

    def coordinates(
        self,
        orientation: Float64Array,
        *,
        phase: float,
        offset: core.DmpPath,
        near: Float64Array,
        velocity: Float64Array = _ZERO,
    ) -> tuple[Float64Array, Float64Array]:
        if self.representation == "log":
            near = _ZERO
        return core.dmp_coordinates(self.curve, offset, phase, orientation, velocity, near)

    def orientations(
        self,
        phases: Float64Array,
        values: Float64Array,
        offset: core.DmpPath = _NO_OFFSET,
    ) -> Float64Array:
        """Orientations of coordinates, sign-continuous."""
        return core.dmp_orientations(self.curve, offset, phases, values)

    def arrays(self) -> dict[str, Float64Array]:
        return {
            "controls": self.controls,
            "speeds": self.speeds,
            "start_orientation": self.start,
            "goal_orientation": self.goal,
            "angle": np.array(self.angle),
        }

    @staticmethod
    def from_arrays(
        representation: str, arrays: Mapping[str, Any], *, rhythmic: bool = False
    ) -> OrientationCoordinates:
        controls = check.unit_quaternions(arrays["controls"], "controls", shape=("n", 4))
        if len(controls) < 4:
            raise InvalidInput(f"controls: expected at least 4, got {len(controls)}")
        return OrientationCoordinates(
            representation,
            controls,
            check.frozen(arrays["speeds"], "speeds", shape=(_INTERVALS + 1,)),
            check.unit_quaternions(arrays["start_orientation"], "start_orientation", shape=(4,)),
            check.unit_quaternions(arrays["goal_orientation"], "goal_orientation", shape=(4,)),
            check.number(arrays["angle"], "angle", at_least=0.0),
            rhythmic,
        )


def learn(
    phases: Float64Array, orientations: Float64Array, representation: str
) -> tuple[OrientationCoordinates, Float64Array]:
    """Coordinates of a representation learned from orientations (n, 4), and their values (n, 3)."""
    q = rotations.align_signs(orientations)
    if representation == "anchored":
        return _anchored(phases, q)
    fixed = _IDENTITY if representation == "euler" else q[-1]
    angle = float(rotations.distance(q[:-1], q[1:]).sum())
    controls = np.repeat(fixed[None], 4, axis=0)
    coordinates = OrientationCoordinates(
        representation, controls, np.zeros(_INTERVALS + 1), q[0], q[-1], angle
    )
    if representation == "euler":
        with warnings.catch_warnings():  # of gimbal lock, where one of the angles is arbitrary
            warnings.simplefilter("ignore", UserWarning)
            return coordinates, rotations.to_euler(q, convention="ZYZ")
    from_goal = rotations.compose(np.repeat(rotations.inverse(q[-1:]), len(q), axis=0), q)
    if representation == "log":
        return coordinates, rotations.log(from_goal)
    try:
        return coordinates, rotations.lift(from_goal, anchor="goal")
    except NoContinuousLogarithm as error:
        raise FitError(
            f'demonstrations: orientation="lifted" finds no continuous logarithm at sample '
            f'{error.index}, beside a whole number of turns from the goal; use "anchored"'
        ) from None


def learn_closed(
    phases: Float64Array, orientations: Float64Array
) -> tuple[OrientationCoordinates, Float64Array]:
    """As `learn` with "anchored", for a motion that ends with its first orientation."""
    return _anchored(phases, rotations.align_signs(orientations), rhythmic=True)


def _anchored(
    phases: Float64Array, q: Float64Array, *, rhythmic: bool = False
) -> tuple[OrientationCoordinates, Float64Array]:
    smooth = q if rhythmic else _smoothed(q)
    steps = rotations.distance(smooth[:-1], smooth[1:])
    covered = np.concatenate([[0.0], np.cumsum(steps)])
    controls_of, mode = (_closed_controls, "wrap") if rhythmic else (_controls, "nearest")
    for refinement in range(_REFINEMENTS + 1):
        finer = 0.5**refinement
        anchors = _anchors(covered, smooth, _ANCHOR_SPACING * finer)
        speeds = _speeds(phases, covered, len(anchors) - 1, _SMOOTHING * finer, mode)
        controls = controls_of(anchors)
        coordinates = OrientationCoordinates(
            "anchored", controls, speeds, q[0], q[-1], float(covered[-1]), rhythmic
        )
        # Phase 1 of a closed curve is its phase 0.
        inside = np.minimum(phases, np.nextafter(1.0, 0.0))
        curve = coordinates.orientations(inside, np.zeros((len(q), 3)))
        error = rotations.log(rotations.compose(rotations.inverse(curve), smooth))
        largest = np.linalg.norm(error, axis=1).max()
        if largest < _GOOD_ERROR:
            break
    if largest > _MAX_ERROR:
        raise FitError(
            "demonstrations: rotate too far from one sample to the next; record at a higher rate"
        )
    if smooth is not q:
        error = rotations.log(rotations.compose(rotations.inverse(curve), q))
    return coordinates, error


def _smoothed(q: Float64Array) -> Float64Array:
    """The orientations (n, 4), or smoothed ones where they are noisy; the ends stay."""
    if noise_of(q) < _NOISY:
        return q
    smooth = q
    for _ in range(2):
        size = max(int(_NOISE_SMOOTHING * len(q)), 1)
        smooth = running_mean(smooth, 2 * size + 1)
        smooth = smooth / np.linalg.norm(smooth, axis=1, keepdims=True)
    smooth[[0, -1]] = q[[0, -1]]
    return np.asarray(rotations.align_signs(smooth))


def noise_of(q: Float64Array) -> float:
    """The standard deviation, rad for each axis, of the noise in orientations (n, 4)."""
    if len(q) < 5:
        return 0.0
    steps = rotations.log(rotations.compose(rotations.inverse(q[:-1]), q[1:]))
    rough = (np.diff(steps, n=2, axis=0) ** 2).sum(axis=1)
    return float(np.sqrt(np.median(rough) / (_MEDIAN * _DIFFERENCED)))


def _anchors(covered: Float64Array, q: Float64Array, spacing: float) -> Float64Array:
    """Orientations at evenly spaced angles along them, at most `spacing` apart, ends included."""
    moving = np.concatenate([[True], np.diff(covered) > 0.0])
    at, samples = covered[moving], q[moving]
    if len(at) == 1:
        return np.repeat(q[:1], 2, axis=0)
    count = int(np.ceil(at[-1] / spacing))
    anchors = rotations.interpolate(at, samples, np.linspace(0.0, at[-1], count + 1))
    anchors[[0, -1]] = q[[0, -1]]
    return rotations.align_signs(anchors)


def _controls(anchors: Float64Array) -> Float64Array:
    """The anchors, with the first and last step repeated: so the curve starts and ends there."""
    outwards = rotations.compose(anchors[[0, -1]], rotations.inverse(anchors[[1, -2]]))
    ends = rotations.compose(outwards, anchors[[0, -1]])
    return np.concatenate([ends[:1], anchors, ends[1:]])


def _closed_controls(anchors: Float64Array) -> Float64Array:
    """The anchors of a cycle, with the last one before it and the first one after it."""
    back = rotations.compose(rotations.inverse(anchors[-1:]), anchors[-2:-1])
    on = rotations.compose(rotations.inverse(anchors[:1]), anchors[1:2])
    before, after = rotations.compose(anchors[:1], back), rotations.compose(anchors[-1:], on)
    return rotations.align_signs(np.concatenate([before, anchors, after]))


def _speeds(
    phases: Float64Array, covered: Float64Array, pieces: int, smoothing: float, mode: str
) -> Float64Array:
    """Speeds (intervals + 1,) >= 0 on the curve, in pieces per phase, at evenly spaced phases."""
    nodes = np.linspace(0.0, 1.0, _INTERVALS + 1)
    between = np.diff(np.interp(nodes, phases, covered))
    for _ in range(2):
        between = running_mean(between, max(int(smoothing * _INTERVALS), 1), mode)
    before, after = (between[-1:], between[:1]) if mode == "wrap" else (between[:1], between[-1:])
    around = np.concatenate([before, between, after])
    speeds = 0.5 * (around[1:] + around[:-1])
    speeds = np.maximum(speeds, 0.0)  # running means leave rounding below 0
    whole = _covered(speeds)[-1]
    return np.asarray(speeds * (pieces / whole)) if whole > 0.0 else speeds


def _covered(speeds: Float64Array) -> Float64Array:
    steps = 0.5 * (speeds[1:] + speeds[:-1]) / (len(speeds) - 1)
    return np.concatenate([[0.0], np.cumsum(steps)])
