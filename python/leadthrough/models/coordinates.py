"""Motions of any type as columns of numbers that a model may average, and back.

Points and joints stand for themselves. Orientations are rotation vectors in the tangent spaces
along a reference: log(reference(phase)^-1 q), in the reference's own frame. They stay small where
the demonstrations stay near each other, however far all of them rotate.

Rotations have one mean where all lie within a quarter turn of a middle (Afsari 2011, "Riemannian
L^p center of mass"). Elsewhere any choice, such as the first demonstration, would be arbitrary.

The arm's joints beside demonstrations of its tip are averaged by phase where they agree; another
elbow or wrist is another posture, and the most frequent one is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Generic, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check, rotations
from leadthrough.check import FitError, Float64Array, InvalidInput, ShortRepr
from leadthrough.motion import (
    Event,
    Events,
    JointTrajectory,
    Motion,
    MotionT,
    MotionT_co,
    PoseTrajectory,
    Target,
    Trajectory,
    agreed_events,
    events_of_plain,
    in_order,
    joints_with,
    lerp,
    moved_events,
    plain_events,
    with_derivatives,
)
from leadthrough.preprocess.align import frechet_distance

# Phases of the reference orientation and of joints.
NODES = np.linspace(0.0, 1.0, 201)
# Joints farther apart than this at any phase, rad or m, are another posture.
_APART = 1.0
_TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Posture:
    """Joints at evenly spaced phases from 0 to 1."""

    names: tuple[str, ...]  # of the joints, or none
    rows: Float64Array  # (201, joints) rad or m

    def along(self, times: Float64Array, phases: ArrayLike) -> JointTrajectory:
        at = np.asarray(phases)
        rows = lerp(at, NODES, self.rows)
        return JointTrajectory(times, rows, joint_names=self.names)

    def every_round(self, times: Float64Array, rounds: Float64Array) -> JointTrajectory:
        """Joints of a motion that repeats: they repeat too, with whole turns if demonstrated."""
        gap = self.rows[-1] - self.rows[0]
        turns = _TURN * np.round(gap / _TURN)
        closed = self.rows - np.outer(NODES, gap - turns)
        number = np.floor(rounds)
        within = Posture(self.names, closed).along(times, rounds - number)
        positions = within.positions + np.outer(number, turns)
        return JointTrajectory(times, positions, joint_names=self.names)

    def in_order(self, names: tuple[str, ...]) -> Float64Array:
        if self.names == names:
            return self.rows
        return self.rows[:, check.column_order(self.names, names, "joints")]

    def reversed(self) -> Posture:
        return Posture(self.names, self.rows[::-1].copy())

    @staticmethod
    def from_archive(settings: dict[str, Any], arrays: Mapping[str, Any]) -> Posture | None:
        """The posture in a file, taken out of its settings; None where there is none."""
        if "posture" not in settings:
            return None
        names = tuple(map(str, settings.pop("posture")))
        rows = check.frozen(arrays["posture"], "posture", shape=(len(NODES), len(names) or "k"))
        return Posture(names, rows)


def settings_of(posture: Posture | None) -> dict[str, Any]:
    """The plain values of a posture by name, for a file; nothing where there is none."""
    return {} if posture is None else {"posture": list(posture.names)}


def arrays_of(posture: Posture | None) -> dict[str, Float64Array]:
    """The arrays of a posture by name, for a file; nothing where there is none."""
    return {} if posture is None else {"posture": posture.rows}


def demonstrated_posture(
    motions: Sequence[Motion], phases: Sequence[Float64Array], weights: ArrayLike | None = None
) -> Posture | None:
    """The joints that went along with motions of the tip; None where none has any."""
    each = [_posture_of(motion, own) for motion, own in zip(motions, phases, strict=True)]
    return agreed(each, weights)


def agreed(postures: Sequence[Posture | None], weights: ArrayLike | None = None) -> Posture | None:
    """The mean of the postures that lie near the one with the most weight near it."""
    weight = np.ones(len(postures)) if weights is None else np.asarray(weights)
    known = [(own, each) for own, each in zip(weight, postures, strict=True) if each is not None]
    if not known:
        return None
    first = known[0][1]
    if len({each.rows.shape for _, each in known}) > 1:
        raise InvalidInput("joints: expected as many in all demonstrations")
    layers = np.array([each.in_order(first.names) for _, each in known])
    own_weights = np.array([own for own, _ in known])
    around = [_unwound_to(layers, middle) for middle in layers]
    near = [np.abs(a - m).max(axis=(1, 2)) <= _APART for a, m in zip(around, layers, strict=True)]
    chosen = int(np.argmax([own_weights[alike].sum() for alike in near]))
    alike = near[chosen]
    mean = np.average(around[chosen][alike], axis=0, weights=own_weights[alike])
    return Posture(first.names, mean)


def _unwound_to(layers: Float64Array, middle: Float64Array) -> Float64Array:
    """Joints (m, 201, joints) with the whole turns left out by which they differ from others."""
    offsets = (layers - middle).mean(axis=1, keepdims=True)
    return np.asarray(layers - _TURN * np.round(offsets / _TURN))


def _posture_of(motion: Motion, phases: Float64Array) -> Posture | None:
    joints = joints_with(motion)
    if joints is None:
        return None
    return Posture(joints.joint_names, lerp(NODES, phases, joints.positions))


# Columns that vary less than this fraction of the widest are as good as constant.
_MIN_FRACTION = 1e-3
# Reach where all positions, or all orientations, are the same: a millimetre, a milliradian. Those
# of poses that vary less count as the same: the rest is rounding, or inverse kinematics.
_STILL = 1e-3
# For a middle without a quarter turn around it: how much more the rotations must agree on it than
# on any other, as a fraction, and how far off it one may be, short of the half turn of its
# antipode, where rotation vectors jump.
_AGREED = 0.25
_MAX_DISTANCE = np.radians(150.0)
# Within a quarter turn, a mean rotates at most 4 / pi times as fast as the rotations do. More than
# that is a jump from one side to the other, between two samples that both have a mean.
_MAX_SPEEDUP = 1.5
_ROUNDING = 1e-6  # rad
# Nearer than a quarter turn throughout, once warped in time: the same rotation at other times.
_ALIKE = np.pi / 2  # rad
# The Frobenius distance of two rotation matrices is this times the sine of half their angle.
_CHORD = 2.0 * np.sqrt(2.0)


@dataclass(frozen=True, eq=False)
class Coordinates(ShortRepr, Generic[MotionT_co]):
    """Meaning of the columns of a model, which become motions again."""

    kind: str  # "points", "joints" or "poses"
    size: int  # number of columns of a point, of the joints, or of a pose's position
    joint_names: tuple[str, ...] = ()  # of joints
    reference: Float64Array | None = None
    events: tuple[Event, ...] = ()  # at phases
    posture: Posture | None = None  # the arm's joints at phases, or None

    @property
    def width(self) -> int:
        """Number of columns; a pose has its position and then three of its orientation."""
        return self.size + (3 if self.kind == "poses" else 0)

    @cached_property
    def every(self) -> NDArray[np.int64]:
        """The numbers (width,) of its columns."""
        return np.arange(self.width, dtype=np.int64)

    def columns(self, motion: Motion, phases: Float64Array, name: str) -> Float64Array:
        """The columns (n, width) of a motion."""
        if not isinstance(motion, _TYPES[self.kind]) or motion.positions.shape[1] != self.size:
            got = f"{type(motion).__name__} of {motion.positions.shape[1]} columns"
            raise check.refused(name, f"{self.kind} of {self.size} columns", got)
        if isinstance(motion, JointTrajectory):
            return in_order(motion, self.joint_names, name).positions
        if isinstance(motion, Trajectory):
            return motion.positions
        return np.hstack([motion.positions, self.tangent(motion.orientations, phases)])

    def tangent(self, orientations: Float64Array, phases: Float64Array) -> Float64Array:
        """Rotation vectors (n, 3) of orientations (n, 4) from the reference at phases (n,)."""
        reference = rotations.inverse(self.reference_at(phases))
        return rotations.log(rotations.compose(reference, orientations))

    def orientations(self, tangent: Float64Array, phases: Float64Array) -> Float64Array:
        """The orientations (n, 4) that rotation vectors (n, 3) stand for at phases (n,)."""
        return rotated_by(self.reference_at(phases), tangent)

    def reference_at(self, phases: Float64Array) -> Float64Array:
        """The reference orientation (n, 4) at phases (n,) in [0, 1]."""
        assert self.reference is not None
        inside = np.clip(phases, 0.0, 1.0)
        return rotations.squad(NODES, self.reference, inside)

    def motion(
        self, times: Float64Array, phases: Float64Array, columns: Float64Array
    ) -> MotionT_co:
        """A motion of the demonstrated type."""
        happening = moved_events(self.events, phases, times)
        joints = None if self.posture is None else self.posture.along(times, phases)
        made: Motion
        if self.kind == "points":
            made = Trajectory(times, columns, happening, joints)
        elif self.kind == "joints":
            names = self.joint_names
            made = with_derivatives(
                JointTrajectory(times, columns, joint_names=names, events=happening)
            )
        else:
            given = self.orientations(columns[:, 3:], phases)
            made = PoseTrajectory(times, columns[:, :3], given, happening, joints)
        return cast(MotionT_co, made)  # of the type that the coordinates was made for

    def target(self, value: Target, name: str, phase: float) -> Float64Array:
        """A target of a query, in columns."""
        if self.kind != "poses":
            return check.array(value, name, shape=(self.size,))
        if not isinstance(value, tuple | list) or len(value) != 2:
            return check.array(value, name, shape=(3,))
        position = check.array(value[0], name, shape=(3,))
        given = check.quaternions(value[1], name, shape=(4,))
        return np.concatenate([position, self.tangent(given[None], np.array([phase]))[0]])

    def arrays(self) -> dict[str, Any]:
        """Its arrays by name, for a file."""
        reference = {} if self.reference is None else {"reference": self.reference}
        return reference | arrays_of(self.posture)

    def settings(self) -> dict[str, Any]:
        """Its plain values by name, for a file."""
        return {
            "chart": self.kind,
            "size": self.size,
            "joint_names": list(self.joint_names),
            "events": plain_events(self.events),
            **settings_of(self.posture),
        }

    @staticmethod
    def from_archive(settings: dict[str, Any], arrays: Any) -> Coordinates:
        shape = (len(NODES), 4)
        return Coordinates(
            check.choice(settings["chart"], "chart", _TYPES),
            check.integer(settings["size"], "size", at_least=1),
            tuple(settings["joint_names"]),
            check.unit_quaternions(arrays["reference"], "reference", shape=shape)
            if "reference" in arrays
            else None,
            events_of_plain(settings.get("events", ())),
            Posture.from_archive(dict(settings), arrays),
        )


_TYPES: dict[str, type] = {
    "points": Trajectory,
    "joints": JointTrajectory,
    "poses": PoseTrajectory,
}


def mean_orientations(
    layers: Sequence[Float64Array], *, weights: Float64Array | None = None
) -> Float64Array:
    """The mean orientations of several motions; they do not depend on their order."""
    stacked = np.stack(layers)
    try:
        means = rotations.mean(stacked, weights=weights)
    except InvalidInput:
        raise FitError(_disagreement(stacked)) from None
    if _jumps(means, stacked):
        raise FitError(_disagreement(stacked))
    return rotations.align_signs(means)


def middle_orientations(layers: Sequence[Float64Array]) -> Float64Array:
    """Middle orientations of several motions, in any order (Markley et al. 2007)."""
    try:
        return mean_orientations(layers)
    except FitError:
        stacked = np.stack(layers)
        moments = np.einsum("kni,knj->nij", stacked, stacked) / len(stacked)
        values, vectors = np.linalg.eigh(moments)
        middles = rotations.align_signs(vectors[:, :, -1])
        off = max(float(rotations.distance(each, middles).max()) for each in stacked)
        divided = float((values[:, -1] - values[:, -2]).min()) < _AGREED
        if divided or off > _MAX_DISTANCE or _jumps(middles, stacked):
            raise
        return middles


def _jumps(means: Float64Array, stacked: Float64Array) -> bool:
    """Whether means (n, 4) rotate faster than rotations (k, n, 4) that they are means of."""
    jumps = rotations.distance(means[1:], means[:-1])
    steps = [rotations.distance(layer[1:], layer[:-1]) for layer in stacked]
    return bool((jumps > _MAX_SPEEDUP * np.max(steps, axis=0) + _ROUNDING).any())


def groups_of(layers: Sequence[Float64Array]) -> tuple[list[int], list[int], int, float]:
    """Two groups of demonstrations, each around one of the two that come to lie farthest apart."""
    stacked = np.stack(layers)
    count = len(stacked)
    apart = np.zeros((count, count, stacked.shape[1]))
    for i in range(count):
        for j in range(i):
            apart[i, j] = apart[j, i] = rotations.distance(stacked[i], stacked[j])
    one, other, at = np.unravel_index(int(np.argmax(apart)), apart.shape)
    nearer = apart[one, :, at] <= apart[other, :, at]
    near = [i for i in range(count) if nearer[i] == nearer[0]]
    far = [i for i in range(count) if nearer[i] != nearer[0]]
    return near, far, int(at), float(apart[one, other, at])


def _disagreement(stacked: Float64Array) -> str:
    """The message about demonstrations without mean orientations, with the remedy."""
    near, far, at, angle = groups_of(list(stacked))
    fraction = at / max(stacked.shape[1] - 1, 1)
    text = (
        f"demonstrations: no mean orientation: at {fraction:.0%} of the motion, demonstrations "
        f"{near} and {far} turn up to {np.degrees(angle):.0f} degrees apart; "
    )
    if all(_same_rotation(stacked[near[0]], stacked[i]) for i in far):
        return text + (
            "they turn alike, but at different times: leave one out, or bring them into step with "
            "preprocess.align_by_time_warping"
        )
    return text + "fit each group alone, or leave one out"


def _same_rotation(one: Float64Array, other: Float64Array) -> bool:
    """Whether two series of orientations (n, 4) are near each other once one is warped in time."""
    chord = frechet_distance(*(rotations.to_matrix(each).reshape(-1, 9) for each in (one, other)))
    return 2.0 * float(np.arcsin(min(chord / _CHORD, 1.0))) < _ALIKE


def coordinates_of(
    motions: Sequence[MotionT],
    phases: Sequence[Float64Array],
    *,
    middle: Callable[[Sequence[Float64Array]], Float64Array] = mean_orientations,
) -> Coordinates[MotionT]:
    """The coordinates in which motions are near each other."""
    kind = next(kind for kind, each in _TYPES.items() if isinstance(motions[0], each))
    names = motions[0].joint_names if isinstance(motions[0], JointTrajectory) else ()
    poses = [motion for motion in motions if isinstance(motion, PoseTrajectory)]
    reference = middle(_at_nodes(poses, phases)) if poses else None
    happened = [
        each
        for motion, u in zip(motions, phases, strict=True)
        for each in events_by_round(moved_events(motion.events, motion.times, u), u[0], u[-1])
    ]
    size = motions[0].positions.shape[1]
    posture = demonstrated_posture(motions, phases)
    return Coordinates(kind, size, names, reference, agreed_events(happened), posture)


def scales(columns: Sequence[Float64Array], coordinates: Coordinates) -> Float64Array:
    """The reach of the columns of motions, (width,) > 0, in their units."""
    reach = np.sqrt(np.mean([each.var(axis=0) for each in columns], axis=0))
    wide = np.ones(coordinates.width)
    for group in (slice(0, coordinates.size), slice(coordinates.size, coordinates.width)):
        widest = reach[group].max(initial=0.0)
        still = widest < _STILL if coordinates.kind == "poses" else widest == 0.0
        wide[group] = _STILL / _MIN_FRACTION if still else widest
    return np.asarray(np.maximum(reach, _MIN_FRACTION * wide))


def _at_nodes(
    motions: Sequence[PoseTrajectory], phases: Sequence[Float64Array]
) -> list[Float64Array]:
    """The orientations (201, 4) at the nodes of motions whose samples stand at phases."""
    return [
        rotations.interpolate(at, motion.orientations, np.clip(NODES, at[0], at[-1]))
        for motion, at in zip(motions, phases, strict=True)
    ]


def rotated_by(reference: Float64Array, tangent: Float64Array) -> Float64Array:
    """The orientations (n, 4) that rotation vectors (n, 3) stand for from a reference (n, 4)."""
    return rotations.align_signs(rotations.compose(reference, rotations.exp(tangent)))


def carried(before: Float64Array, after: Float64Array) -> Float64Array:
    """Matrices (n, 3, 3) that carry small deviations from one tangent space to another."""
    # log(exp(d) exp(v)) = d + J_r(d)^-1 v + ..., with J_r(d) = J_l(-d); Sola et al. 2018, eq. 151.
    return np.asarray(rotations.left_jacobian_inverse(-after) @ rotations.left_jacobian(-before))


def events_by_round(events: Events, first: float, last: float) -> list[Events]:
    """The events of each round from `first` to `last`, at times 0 to 1 within their round."""
    end = int(np.ceil(last))
    return [
        tuple(
            Event(event.time - k, event.name)
            for event in events
            if k <= event.time < k + 1 or event.time == end == k + 1
        )
        for k in range(int(np.floor(first)), end)
    ]
