"""Skills corrected by hand: a point of the motion is moved, and the rest of the path stays.

Corrections are offsets along the path, interpolated by a kernel of compact support: all of them are
met exactly, and farther away than the kernel reaches the motion is that of the skill inside. Start
and goal are kept. Interactive corrections as local changes of a learned motion: Franzese et al.
2021, "ILoSA"; Mészáros et al. 2022, "SIMPLe". A via point of a movement primitive moves all of the
path instead.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, cast

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, rotations
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.models.archive import Arrays, FittedSkill, archived, from_archived, prefixed
from leadthrough.models.protocol import Demonstrations, Parameter, Skill
from leadthrough.models.queries import CheckedQuery, check_place, is_free
from leadthrough.motion import (
    JointTrajectory,
    Motion,
    MotionT_co,
    PoseTrajectory,
    Target,
    lerp,
    normalised_times,
)
from leadthrough.preprocess.resample import arc_length

# A correction changes the motion no farther away than this fraction of the path.
_REACH = 0.2
# A correction nearer to another than this fraction of the path replaces it, and none lies as near
# to the ends: the interpolation would swing.
_NEAR = 0.02
# Fractions of the corrections that are tried until obstacles are cleared; 0 is always clear.
_FADING = (1.0, 0.75, 0.5, 0.25, 0.0)


@dataclass(frozen=True, eq=False)
class Correction(ShortRepr):
    """An offset at a point of the motion.

    Attributes:
        at: fraction of the path, 0 to 1; of a rhythm, of the period.
        offset: (d,), or of poses (6,): of the position, m, and a rotation vector in the base frame.
        mode: index of the mode that it belongs to.
    """

    at: float
    offset: Float64Array
    mode: int = 0


@dataclass(frozen=True, eq=False)
class CorrectedSkill(FittedSkill[MotionT_co]):
    """A skill whose motions pass where they were moved to; made by `FittedSkill.corrected`.

    Obstacles come before corrections, which fade where they would lead into one.

    Attributes:
        skill: the skill without corrections.
        corrections: the offsets; the last one made is the last.
    """

    skill: Skill[MotionT_co]
    corrections: tuple[Correction, ...]

    kind: ClassVar[str] = "corrected"

    @property
    def model(self) -> Any:
        """The settings that the skill was fitted with."""
        return self.skill.model

    @property
    def duration(self) -> float:
        """Of the motion, s."""
        own: Any = self.skill  # those of other packages need not have one
        return float(getattr(own, "duration", None) or own.generate().duration)

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours: those of every skill."""
        return self.skill.supports & {"start", "goal", "duration", "obstacles"}

    @property
    def modes(self) -> tuple[Any, ...]:
        """A corrected skill for each demonstrated mode."""
        known = _modes_of(self.skill)
        if len(known) == 1:
            return (self,)
        return tuple(
            CorrectedSkill(each, tuple(replace(c, mode=0) for c in self.corrections if c.mode == i))
            for i, each in enumerate(known)
        )

    @classmethod
    def around(cls, skill: Any) -> CorrectedSkill[Any]:
        """A skill that can be corrected: the same with its corrections, or without any so far."""
        return skill if isinstance(skill, cls) else cls(skill, ())

    def undone(self) -> CorrectedSkill[MotionT_co]:
        """The skill without the last correction."""
        return CorrectedSkill(self.skill, self.corrections[:-1])

    def with_correction(
        self, at: float | ArrayLike, place: Target, query: CheckedQuery, mode: int
    ) -> CorrectedSkill[MotionT_co]:
        """The skill that passes a place instead of a point of the answer to a query."""
        inside = _modes_of(self.skill)[mode]
        motion = _answer_of(inside, query)
        if not np.isscalar(at):
            at = _nearest_time(self.modes[mode].generate(**query.given()), at)
        when = check.number(at, "at", at_least=0.0, at_most=motion.duration)
        fraction = float(np.interp(when, motion.times - motion.times[0], self._progress(motion)))
        self._check_inside(fraction)
        check_place(place, motion, "position")
        offset = _offset(motion, when + float(motion.times[0]), place)
        kept = [
            each
            for each in self.corrections
            if each.mode != mode or self._apart(each.at, fraction) >= _NEAR
        ]
        made = Correction(fraction, check.frozen(offset, "offset", shape=("n",)), mode)
        return CorrectedSkill(self.skill, (*kept, made))

    def corrected_points(self, **query: Any) -> Float64Array:
        """Positions (k, d) of the answer to a query where it was corrected."""
        inside: Any = self.skill.generate(**query)
        at = np.interp([each.at for each in self.corrections], self._progress(inside), inside.times)
        return lerp(at, inside.times, self.generate(**query).positions)

    def parameters(self, demonstrations: Demonstrations[Motion] = ()) -> Sequence[Parameter[Any]]:
        """Adjustable parameters of the skill inside, which stays corrected."""

        def corrected(inside: Callable[[float], Skill[Any]]) -> Callable[[float], Skill[Any]]:
            return lambda value: CorrectedSkill(inside(value), self.corrections)

        found = self.skill.parameters(demonstrations)
        return [replace(each, apply=corrected(each.apply)) for each in found]

    @property
    def _offsets(self) -> Float64Array:
        return np.array([each.offset for each in self.corrections] or np.empty((0, 0)))

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        settings, arrays = archived(self.skill)
        inside = {f"skill_{name}": value for name, value in arrays.items()}
        own = {
            "at": np.array([each.at for each in self.corrections]),
            "offsets": self._offsets,
            "mode": np.array([each.mode for each in self.corrections], dtype=np.float64),
        }
        return {"kind": self.skill.kind, "skill": settings}, inside | own

    def _answer(self, query: CheckedQuery) -> MotionT_co:
        motion: Any = self.skill.generate(**query.given())
        if not self.corrections:
            return cast(MotionT_co, motion)
        rows = self._kernel(self._progress(motion)) @ self._weights
        for fraction in _FADING:
            made = _moved(motion, fraction * rows)
            if fraction == 0.0 or not query.obstacles or is_free(made.positions, query.obstacles):
                break
        return cast(MotionT_co, made)

    @property
    def _rhythmic(self) -> bool:
        return hasattr(self.skill, "period")

    def _progress(self, motion: Motion) -> Float64Array:
        """Fractions (n,) of the path at each sample; of a rhythm, of the period."""
        if self._rhythmic:
            return np.asarray((motion.times - motion.times[0]) / self.skill.period)  # type: ignore[attr-defined]
        if (motion.positions != motion.positions[0]).any():
            covered = arc_length(motion.positions)
        elif isinstance(motion, PoseTrajectory):
            turns = rotations.distance(motion.orientations[1:], motion.orientations[:-1])
            covered = np.concatenate([[0.0], np.cumsum(turns)])
        else:
            covered = normalised_times(motion.times)
        return np.asarray(covered / (covered[-1] or 1.0))

    def _apart(self, one: Any, other: Any) -> Any:
        gap = np.abs(one - other)
        return np.minimum(gap % 1.0, -gap % 1.0) if self._rhythmic else gap

    def _check_inside(self, fraction: float) -> None:
        if not self._rhythmic and not _NEAR <= fraction <= 1.0 - _NEAR:
            end = "start" if fraction < 0.5 else "goal"
            raise InvalidInput(
                f"at: expected a point along the path, got one within {_NEAR:.0%} of its "
                f"{end}; give another {end} to generate"
            )

    @cached_property
    def _nodes(self) -> Float64Array:
        """Fractions (m,) of the path where the offset is known: at corrections and at the ends."""
        ends = [] if self._rhythmic else [0.0, 1.0]
        return np.array([*(each.at for each in self.corrections), *ends])

    @cached_property
    def _weights(self) -> Float64Array:
        """Weights (m, width) of the kernels, so that each correction is met and the ends stay."""
        ends = len(self._nodes) - len(self.corrections)
        wanted = np.pad(self._offsets, ((0, ends), (0, 0)))
        return np.asarray(np.linalg.solve(self._kernel(self._nodes), wanted))

    def _kernel(self, at: Float64Array) -> Float64Array:
        """Values (n, m) of the kernel of each node."""
        # Of Wendland 1995, "Piecewise polynomial, positive definite ... radial functions", in C4.
        r = np.minimum(self._apart(at[:, None], self._nodes[None]) / _REACH, 1.0)
        return np.asarray((1.0 - r) ** 5 * (8.0 * r**2 + 5.0 * r + 1.0))


def from_archive(settings: dict[str, Any], arrays: Arrays) -> CorrectedSkill[Any]:
    at = check.array(arrays["at"], "at", shape=("k",))
    offsets = check.array(arrays["offsets"], "offsets", shape=(len(at), "width"))
    modes = check.array(arrays["mode"], "mode", shape=(len(at),))
    skill = from_archived(settings["kind"], settings["skill"], prefixed(arrays, "skill_"))
    rows = zip(at.tolist(), offsets, modes.tolist(), strict=True)
    return CorrectedSkill(
        skill, tuple(Correction(where, offset, int(mode)) for where, offset, mode in rows)
    )


def _modes_of(skill: Any) -> tuple[Any, ...]:
    return tuple(getattr(skill, "modes", (skill,)))


def _answer_of(skill: Any, query: CheckedQuery) -> Motion:
    """The skill's motion; its own one, which may have longer steps, is kept by it."""
    given = query.given()
    own = getattr(skill, "_own_motion", None) if given == {"dt": CheckedQuery.dt} else None
    motion: Motion = skill.generate(**given) if own is None else own
    return motion


def _nearest_time(motion: Motion, at: Any) -> float:  # Any: checked here
    """The time, s, at which a motion is nearest to a position."""
    point = check.array(at, "at", shape=motion.positions.shape[1:])
    nearest = int(np.linalg.norm(motion.positions - point, axis=1).argmin())
    return float(motion.times[nearest] - motion.times[0])


def _offset(motion: Motion, time: float, place: Any) -> Float64Array:  # Any: checked here
    """Offset (d,), of poses (6,), of a place from the motion at a time, s."""
    if not isinstance(motion, PoseTrajectory):
        wanted = check.array(place, "position", shape=motion.positions.shape[1:])
        return np.asarray(wanted - motion.at(time))
    own, own_q = motion.at(time)
    posed = isinstance(place, tuple | list) and len(place) == 2
    wanted = check.array(place[0] if posed else place, "position", shape=(3,))
    turn = np.zeros(3)
    if posed:
        q = check.quaternions(place[1], "position", shape=(4,))
        turn = rotations.log(rotations.compose(q[None], rotations.inverse(own_q[None])))[0]
    return np.concatenate([wanted - own, turn])


def _moved(motion: Motion, offsets: Float64Array) -> Motion:
    """The motion with offsets (n, width) of its samples, and the rates that belong to them."""
    if isinstance(motion, PoseTrajectory):
        q = rotations.compose(rotations.exp(offsets[:, 3:]), motion.orientations)
        positions = motion.positions + offsets[:, :3]
        return PoseTrajectory(motion.times, positions, q, motion.events, motion.joints)
    positions = motion.positions + offsets
    if not isinstance(motion, JointTrajectory):
        return replace(motion, positions=positions)
    from scipy.interpolate import CubicSpline

    along = CubicSpline(motion.times, offsets)
    rates = [
        None if rate is None else rate + along(motion.times, order)
        for order, rate in ((1, motion.velocities), (2, motion.accelerations))
    ]
    return replace(motion, positions=positions, velocities=rates[0], accelerations=rates[1])
