"""Fitted skills, and their files: NumPy archives without pickle, versioned, written in one go."""

from __future__ import annotations

import copy
import json
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Self, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from leadthrough import check
from leadthrough.check import InvalidInput, UnsupportedQuery
from leadthrough.drawing import Drawn
from leadthrough.io import npz
from leadthrough.models.certificate import Certificate
from leadthrough.models.protocol import (
    Choice,
    Corrected,
    Demonstrations,
    Distributed,
    Parameter,
    Skill,
    fit_all,
)
from leadthrough.models.queries import CheckedQuery, Via, checked_query, ends_apart, is_free
from leadthrough.models.registry import entry_of_skill
from leadthrough.motion import Motion, MotionT_co, Target
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.drawing import Panel


FORMAT = "leadthrough skill"
VERSION = 1
_BESIDE_FIELDS = _CERTIFICATE, _CHOICE, _MODES = "certificate", "choice", "modes"
# Of a skill's own motion: the step, s, unless it is so long that fewer tell its extent and ends.
_DT, _STEPS = 0.01, 2000

Arrays = Mapping[str, NDArray[Any]]


class FittedSkill(Drawn, Generic[MotionT_co]):
    """Base of fitted skills: saved as settings and arrays, drawn by their own motion.

    A derived frozen dataclass has `model`, its settings, `supports` and `to_archive`, and answers
    the checked queries of `generate` by a method `_answer`.

    Attributes:
        kind: name of this kind of skill in files.
    """

    kind: ClassVar[str]

    @property
    @abstractmethod
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours."""

    @checked_query
    def generate(
        self,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
        mode: int | None = None,
    ) -> MotionT_co:
        """A motion of the demonstrated type; parts that are left out are as demonstrated.

        Args:
            start: point or joints (d,); of poses a position (3,), or (position (3,), orientation
                (4,) as w, x, y, z).
            goal: likewise, at the end.
            duration: s, > 0.
            dt: s, > 0, upper bound of the sampling step.
            obstacles: shapes to keep clear of, in the demonstrations' frame; a drawing of two
                dimensions lies in the plane z = 0.
            mode: index in `modes`; by default the one that starts and ends nearest, or with
                obstacles the nearest one that is free of them, if there is any.

        Raises:
            UnsupportedQuery: for a part that is not among `supports`.
            NoPath: if obstacles leave no path, or the goal is not reached.
        """
        return self._in_mode(CheckedQuery(start, goal, duration, dt, obstacles), mode)

    @property
    def modes(self) -> tuple[Self, ...]:
        """A skill for each demonstrated mode, the most demonstrated one, which this is, first."""
        return vars(self).get(_MODES) or (self,)

    def with_modes(self, modes: Sequence[Self]) -> Self:
        """The same skill, which knows several modes; it is the first of them."""
        if len(modes) == 1:
            return self
        same = copy.copy(self)
        vars(same)[_MODES] = tuple(modes)
        return same

    def _in_mode(self, query: CheckedQuery, mode: int | None) -> MotionT_co:
        """The answer to a query of the mode of a number, or of the one that fits best."""
        self.refuse_obstacles(query)
        return self.modes[self.mode_of(query, mode)]._answer(query)

    def mode_of(self, query: CheckedQuery, mode: int | None) -> int:
        """The index of the mode that answers a query: the given one, or the one that fits best."""
        modes = self.modes
        if mode is not None:
            return check.integer(mode, "mode", at_least=0, at_most=len(modes) - 1)
        if len(modes) == 1:
            return 0
        ranked = sorted(range(len(modes)), key=lambda i: modes[i]._distance(query))
        return next((i for i in ranked if modes[i]._is_free(query)), ranked[0])

    def _distance(self, query: CheckedQuery) -> float:
        """Of the query's start and goal from those of its own motion."""
        return ends_apart(query, self._own_motion)

    def _is_free(self, query: CheckedQuery) -> bool:
        """Whether its motion keeps out of the query's obstacles as it is."""
        if not query.obstacles:
            return True
        return is_free(self._answer(replace(query, obstacles=())).positions, query.obstacles)

    def refuse_obstacles(self, query: CheckedQuery) -> None:
        """Raises UnsupportedQuery for obstacles that the skill does not avoid."""
        if query.obstacles and "obstacles" not in self.supports:
            name = type(getattr(self, "model", self)).__name__
            raise UnsupportedQuery(
                f"obstacles: {name} cannot avoid them; leave them out or use FastMarching"
            )

    def corrected(
        self,
        at: float | ArrayLike,
        position: Target,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        duration: float | None = None,
        obstacles: Sequence[Shape] = (),
        mode: int | None = None,
    ) -> Corrected[MotionT_co]:
        """A skill whose motion passes a position; call it again for more.

        The motion changes within a fifth of the path's length and is the same elsewhere; start and
        goal stay. A new start or goal moves the correction along with the path, and saved skills
        keep it. Corrections made before are still met, except one at the same point, which is
        replaced; `undone` takes the last one back.

        Args:
            at: the point that is moved, of the motion that `generate` returns for the arguments
                below: its time, s, or a position (d,), which the nearest point stands for.
            position: its new position (d,); of poses (3,), which keeps the orientation, or
                (position (3,), orientation (4,)).
            start: of the motion that is corrected, as for `generate`, and so are those that follow.

        Raises:
            InvalidInput: for a time outside the motion, or at its start or goal.
            UnsupportedQuery, NoPath: as in `generate`.
        """
        query = CheckedQuery(start, goal, duration, obstacles=obstacles)
        whole: Any = entry_of_skill("corrected").load().around(self)  # its module builds upon this
        made: Corrected[MotionT_co] = whole.with_correction(
            at, position, query, whole.mode_of(query, mode)
        )
        return made

    @abstractmethod
    def _answer(self, query: CheckedQuery) -> MotionT_co:
        """The motion that answers a query."""

    @abstractmethod
    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        """Settings, plain values only, and arrays of numbers, for `from_archive` of its model."""

    def parameters(self, demonstrations: Demonstrations[Motion] = ()) -> Sequence[Parameter[Any]]:
        """Adjustable parameters: by default the `slider` of its model, if any.

        Args:
            demonstrations: those that it was fitted to, to fit it again.
        """
        model = getattr(self, "model", None)
        slider = getattr(model, "slider", None)
        if slider is None or len(demonstrations) == 0:
            return []
        setting, least, most = slider
        value = getattr(model, setting)

        def fitted(number: float) -> Skill[Any]:
            changed: Any = replace(model, **{setting: round(number)})  # type: ignore[type-var]
            return self._fitted_again(changed, demonstrations)

        return [Parameter(setting, value, min(least, value), max(most, value), 1.0, fitted)]

    def _fitted_again(self, model: Any, demonstrations: Demonstrations[Motion]) -> Skill[Any]:
        """The skill of a model with another setting."""
        return fit_all(model, demonstrations)

    @property
    def certificate(self) -> Certificate | None:
        """The result of its validation; None before one, and after a change."""
        certificate: Certificate | None = vars(self).get(_CERTIFICATE)
        return certificate

    def certified(self, certificate: Certificate | None) -> Self:
        """The same skill with a certificate, also saved in its file.

        Args:
            certificate: of a validation; None removes it.
        """
        same = copy.copy(self)
        vars(same)[_CERTIFICATE] = certificate
        return same

    @property
    def choice(self) -> Choice | None:
        """The families that `lt.learn` compared before it chose this one; None of other skills."""
        choice: Choice | None = vars(self).get(_CHOICE)
        return choice

    def __reduce_ex__(self, protocol: SupportsIndex) -> str | tuple[Any, ...]:
        """Copies and pickles keep modes, choice and certificate, which are no fields."""
        made = super().__reduce_ex__(protocol)
        own = {name: vars(self)[name] for name in _BESIDE_FIELDS if name in vars(self)}
        return (*made, own) if own and isinstance(made, tuple) and len(made) == 2 else made

    def with_choice(self, choice: Choice) -> Self:
        """The same skill with the reason for its family, also saved in its file."""
        same = copy.copy(self)
        vars(same)[_CHOICE] = choice
        return same

    def save(self, path: str | PathLike[str]) -> None:
        """Writes the skill to a .npz file that `load_skill` reads.

        Args:
            path: the file; one that exists is replaced in one go.

        Raises:
            InvalidInput: if the file cannot be written.
        """
        archive = archived(self)
        write(path, self.kind, *archive, certificate=self.certificate, choice=self.choice)

    def export(self, path: str | PathLike[str]) -> None:
        """Writes the skill to a file that `leadthrough/skill.hpp` in C++ runs.

        Its steps are then those of this skill to the bit, without Python. The file has tables
        instead of settings: `load_skill` reads what `save` writes. Of several modes it has the
        first; of Fast Marching, the policy to the demonstrations' goal.

        Args:
            path: the file; one that exists is replaced in one go.

        Raises:
            UnsupportedQuery: unless it is a DMP of the form "blended" (of poses with the
                orientation "anchored"), a ProMP of points or joints with the basis "gaussian" or
                "rhythmic", or of Fast Marching.
            InvalidInput: if the file cannot be written.
        """
        npz.write_tables(path, self.kind, self._tables())

    def _tables(self) -> Mapping[str, Any]:
        raise self._not_exported()

    def _not_exported(self) -> UnsupportedQuery:
        return UnsupportedQuery(
            "export: expected a DMP of the form 'blended' (of poses, with the orientation "
            "'anchored'), a ProMP of points or joints with a basis other than 'bspline', or Fast "
            f"Marching, got a {type(self).__name__} of {getattr(self, 'model', self)!r}"
        )

    @cached_property
    def _own_motion(self) -> Motion | None:
        """Its own motion, to compare queries with; None without demonstrations."""
        dt = max(_DT, getattr(self, "duration", 0.0) / _STEPS)
        try:
            return self.generate(dt=dt)
        except InvalidInput:  # without demonstrations, a motion needs a start and a goal
            return None

    def _repr_parts(self) -> list[str]:
        model, duration = getattr(self, "model", None), getattr(self, "duration", None)
        parts = [] if model is None else [repr(model)]
        if duration is not None:
            parts.append(f"{duration:.4g} s")
        return [*parts, f"supports {', '.join(sorted(self.supports))}"]

    def _panels(self) -> Sequence[Panel]:
        motion = self.generate()
        if not isinstance(self, Distributed):
            return motion._panels()
        times = np.minimum(motion.times - motion.times[0], self.duration)
        _, covariance = self.distribution(times)
        deviations = np.sqrt(np.einsum("nii->ni", covariance))
        return motion._panels(deviations[:, : motion.positions.shape[1]])


class SteppedSkill(FittedSkill[MotionT_co]):
    """A skill whose motions pass via points, and go on step by step in a control loop."""

    # A derived class also has `step(state, dt, ...)`, and `_begin` for a query's first state.

    @checked_query
    def generate(
        self,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
        via: Via = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
        limits: tuple[ArrayLike, ArrayLike] | None = None,
        mode: int | None = None,
    ) -> MotionT_co:
        """A motion of the demonstrated type; parts that are left out are as demonstrated.

        The other arguments are those of `FittedSkill.generate`; of poses the position keeps clear
        of obstacles, whatever the orientation.

        Args:
            via: (fraction of the duration in (0, 1), position (d,)), in order.
            start_velocity: (d,) per second; of poses (3,) m/s.
            final_velocity: as start_velocity.
            limits: (lower (d,), upper (d,)), which the motion does not leave; not of poses.

        Raises:
            UnsupportedQuery: for a part that is not among `supports`.
            NoPath: if steering does not clear the obstacles.
        """
        ends = via, start_velocity, final_velocity
        query = CheckedQuery(start, goal, duration, dt, obstacles, *ends, limits)
        return self._in_mode(query, mode)

    def begin(
        self,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        duration: float | None = None,
        via: Via = (),
        start_velocity: ArrayLike | None = None,
        final_velocity: ArrayLike | None = None,
    ) -> Any:
        """The state at the start, for `step`; arguments and errors as in `generate`."""
        query = CheckedQuery(
            start,
            goal,
            duration,
            via=via,
            start_velocity=start_velocity,
            final_velocity=final_velocity,
        )
        return self._begin(query)

    @abstractmethod
    def _begin(self, query: CheckedQuery) -> Any:
        """The state at the start of a query."""


def load_skill(path: str | PathLike[str]) -> Skill:
    """The skill in a file that its `save` wrote.

    It generates motions of the demonstrated type; a file does not tell a type checker which.

    Args:
        path: the file.

    Raises:
        InvalidInput: if it is no skill, is damaged, or of a newer format version.
    """
    head, arrays = _read(path)
    skill: Any = restored(path, head["kind"], head["settings"], arrays)
    if _CHOICE in head:
        skill = skill.with_choice(head[_CHOICE])
    if _CERTIFICATE in head:
        skill = skill.certified(head[_CERTIFICATE])
    loaded: Skill = skill
    return loaded


def archived(skill: Any) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Settings and arrays of a skill with all its modes."""
    settings, arrays = skill.to_archive()
    others = [each.to_archive() for each in vars(skill).get(_MODES, ())[1:]]
    parts = dict(arrays)
    for i, (_, own) in enumerate(others):
        parts |= {f"{name}{_of_mode(i)}": array for name, array in own.items()}
    return {**settings, _MODES: [each for each, _ in others]} if others else settings, parts


def from_archived(kind: str, settings: dict[str, Any], arrays: Arrays) -> Skill:
    """The skill that `archived` took apart, without checks of the file."""
    entry, own, parts = entry_of_skill(kind), dict(settings), dict(arrays)
    others: list[Any] = []
    for i, each in enumerate(own.pop(_MODES, ())):
        names = [name for name in parts if name.endswith(_of_mode(i))]
        theirs = {name.removesuffix(_of_mode(i)): parts.pop(name) for name in names}
        others.append((each, theirs))
    skills: list[Any] = [entry.restored(own, parts), *(entry.restored(*each) for each in others)]
    skill: Skill = skills[0].with_modes(skills) if others else skills[0]
    return skill


def prefixed(arrays: Arrays, prefix: str) -> dict[str, NDArray[Any]]:
    """The arrays whose names begin with a prefix, by the rest of their names."""
    return {n.removeprefix(prefix): a for n, a in arrays.items() if n.startswith(prefix)}


def _of_mode(number: int) -> str:
    """The end of the names of a further mode's arrays."""
    return f"_of_mode_{number + 1}"


def restored(
    path: str | PathLike[str], kind: str, settings: dict[str, Any], arrays: Arrays
) -> Skill:
    """The skill that `archived` took apart."""
    entry_of_skill(kind)
    try:
        return from_archived(kind, settings, arrays)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise InvalidInput(f"path: {path} is damaged ({error})") from None


def write(
    path: str | PathLike[str],
    kind: str,
    settings: Mapping[str, Any],
    arrays: Arrays,
    *,
    certificate: Certificate | None = None,
    choice: Choice | None = None,
) -> None:
    head = {"format": FORMAT, "version": VERSION, "kind": kind, "settings": dict(settings)}
    if certificate is not None:
        head[_CERTIFICATE] = certificate.to_settings()
    if choice is not None:
        head[_CHOICE] = asdict(choice)
    npz.write_arrays(path, {"head": np.array(json.dumps(head)), **arrays})


def read(
    path: str | PathLike[str],
) -> tuple[str, dict[str, Any], dict[str, NDArray[Any]], Choice | None]:
    """Kind, settings and arrays of a skill in a file, and the reason for its family, if any."""
    head, arrays = _read(path)
    return head["kind"], head["settings"], arrays, head.get(_CHOICE)


def _read(path: str | PathLike[str]) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """The checked head of a skill in a file, and its arrays."""
    with suppress(OSError):  # a name that no file can have: reading says so
        if isinstance(path, str | PathLike) and not Path(path).exists():
            raise InvalidInput(f"path: no such file: {path}")
    try:
        arrays = npz.arrays(Path(path))
        if "exported" in arrays:
            raise InvalidInput("it is an export, for C++; load what `save` wrote")
        head = json.loads(str(arrays.pop("head")))
        if head["format"] != FORMAT:
            raise InvalidInput(f"format: expected {FORMAT!r}, got {head['format']!r}")
        version = int(head["version"])
        head |= {"kind": str(head["kind"]), "settings": dict(head["settings"])}
        if _CHOICE in head:
            head[_CHOICE] = Choice(**head[_CHOICE])
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise InvalidInput(f"path: expected a saved skill, got {path} ({error})") from None
    if version > VERSION:
        raise InvalidInput(
            f"path: expected a skill of format version {VERSION} or earlier, got {path} of version "
            f"{version}; update leadthrough"
        )
    if _CERTIFICATE in head:
        head[_CERTIFICATE] = Certificate.from_settings(head[_CERTIFICATE])
    return head, arrays
