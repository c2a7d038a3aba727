"""Task-parameterised Gaussian mixtures: motions seen from frames that move with the task.

Components that are the same in every frame; where the frames of a new situation stand, their
Gaussians are multiplied. Source: Calinon 2016, "A tutorial on task-parameterized movement learning
and retrieval", sections 2 to 4; here the time counts once and not once a frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.io.atomic import StrPath
from leadthrough.models import archive
from leadthrough.models.chart import SAMPLES, Chart, chart_of, motions_of, normalised, timed_columns
from leadthrough.models.gmr_skill import GMRSkill
from leadthrough.models.mixture import Mixture
from leadthrough.models.mixture_em import Blocks, fit_blocks, standard
from leadthrough.motion import Demonstration
from leadthrough.shapes import Shape

_ORTHONORMAL = 1e-6


@dataclass(frozen=True, eq=False)
class Frame:
    """Where something of the task stands: a start, a goal, an object.

    origin: (d,). axes: (d, d) orthonormal, its axes as columns; by default those of the base frame.
    """

    origin: Float64Array
    axes: Any = None

    def __post_init__(self) -> None:
        origin = check.frozen(self.origin, "origin", shape=("d",))
        size = len(origin)
        given = np.eye(size) if self.axes is None else self.axes
        axes = check.frozen(given, "axes", shape=(size, size))
        if np.abs(axes.T @ axes - np.eye(size)).max() > _ORTHONORMAL:
            raise InvalidInput("axes: expected orthonormal columns")
        object.__setattr__(self, "origin", origin)
        object.__setattr__(self, "axes", axes)

    def local(self, points: Float64Array) -> Float64Array:
        """Points (n, d) of the base frame, seen from this one."""
        return np.asarray((points - self.origin) @ self.axes)


@dataclass(frozen=True)
class TaskGMR:
    """A task-parameterised mixture of points. components: >= 1. seed: of the starts of EM."""

    components: int = 8
    seed: int = 0

    def __post_init__(self) -> None:
        check.integer(self.components, "components", at_least=1, at_most=SAMPLES)
        check.integer(self.seed, "seed", at_least=0)

    def fit(
        self,
        demonstrations: Sequence[Demonstration],
        *,
        frames: Sequence[Sequence[Frame]] | None = None,
    ) -> TaskGMRSkill:
        """A skill from demonstrations of points.

        frames: those of each demonstration, in the same order in all; by default two, at its start
        and at its goal. Raises InvalidInput; FitError for a demonstration that does not move.
        """
        motions = motions_of(demonstrations)
        phases = [normalised(motion) for motion in motions]
        chart = chart_of(motions, phases)
        if chart.kind != "points":
            raise InvalidInput(f"demonstrations: expected points, got {chart.kind}")
        duration = float(np.median([motion.duration for motion in motions]))
        samples = timed_columns(motions, phases, chart, duration)
        seen_from = (
            [(Frame(each[0, 1:]), Frame(each[-1, 1:])) for each in samples]
            if frames is None
            else _checked(frames, len(motions), chart.size)
        )
        seen = [
            np.concatenate(
                [
                    np.column_stack([each[:, 0], own[i].local(each[:, 1:])])
                    for each, own in zip(samples, seen_from, strict=True)
                ]
            )
            for i in range(len(seen_from[0]))
        ]
        components = _fitted(seen, self.components, self.seed)
        ends = np.mean([each[[0, -1], 1:] for each in samples], axis=0)
        return TaskGMRSkill(chart, components, duration, ends, at_ends=frames is None)


@dataclass(frozen=True, eq=False)
class TaskGMRSkill:
    """What was learned; made by `TaskGMR.fit`.

    components: over the time, s, and the position in each frame. duration: s. ends: (2, d) where
    the demonstrations start and end on the mean. at_ends: whether its two frames stand there.
    """

    chart: Chart
    components: Blocks
    duration: float
    ends: Float64Array
    at_ends: bool

    kind: ClassVar[str] = "task_gmr"

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours; with frames of its own, see `at`."""
        return frozenset({"start", "goal", "duration"} if self.at_ends else {"duration"})

    def at(self, frames: Sequence[Frame]) -> GMRSkill:
        """The skill in a situation, with frames as it was fitted with. Raises InvalidInput."""
        (given,) = _checked([frames], 1, self.chart.size)
        if len(given) != len(self.components.means):
            raise InvalidInput(
                f"frames: expected {len(self.components.means)} of them, got {len(given)}"
            )
        mixture = _multiplied(self.components, given)
        ends, _ = mixture.regress([[0.0], [self.duration]], inputs=[0])
        return GMRSkill(self.chart, mixture, self.duration, ends, 1)

    def generate(
        self,
        *,
        start: Any = None,
        goal: Any = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> Any:
        """The mean motion from a start to a goal, (d,) each, by default the mean ones.

        duration, dt: s, > 0. Raises InvalidInput; UnsupportedQuery for obstacles, and for a skill
        with frames other than those at start and goal.
        """
        if not self.at_ends:
            raise UnsupportedQuery("start: this skill has frames of its own; ask skill.at(frames)")
        ends = self.ends.copy()
        for row, (value, name) in enumerate(((start, "start"), (goal, "goal"))):
            if value is not None:
                ends[row] = check.array(value, name, shape=(self.chart.size,))
        return self.at([Frame(end) for end in ends]).generate(
            start=ends[0], goal=ends[1], duration=duration, dt=dt, obstacles=obstacles
        )

    def save(self, path: StrPath) -> None:
        """Writes the skill to a .npz file that `load_skill` reads. Raises InvalidInput."""
        archive.write(path, self.kind, *self.to_archive())

    def to_archive(self) -> tuple[dict[str, Any], archive.Arrays]:
        """Settings and arrays that `from_archive` puts together again."""
        settings = {
            "duration": self.duration,
            "at_ends": self.at_ends,
            "frames": len(self.components.means),
            **self.chart.settings(),
        }
        arrays = {"weights": self.components.weights, "ends": self.ends}
        for i, means in enumerate(self.components.means):
            arrays[f"means_{i}"] = means
            arrays[f"covariances_{i}"] = self.components.covariances[i]
        return settings, arrays

    @classmethod
    def from_archive(cls, settings: dict[str, Any], arrays: archive.Arrays) -> TaskGMRSkill:
        """The skill that `save` took apart. Raises KeyError, TypeError, ValueError."""
        mixtures = [
            Mixture(arrays["weights"], arrays[f"means_{i}"], arrays[f"covariances_{i}"])
            for i in range(int(settings["frames"]))
        ]
        components = Blocks(
            mixtures[0].weights,
            tuple(each.means for each in mixtures),
            tuple(each.covariances for each in mixtures),
        )
        duration = check.number(settings["duration"], "duration", above=0.0)
        chart = Chart.from_archive(settings, arrays)
        ends = check.frozen(arrays["ends"], "ends", shape=(2, chart.size))
        return cls(chart, components, duration, ends, at_ends=bool(settings["at_ends"]))


def _fitted(seen: Sequence[Float64Array], count: int, seed: int) -> Blocks:
    """Components of times and positions (n, 1 + d) as seen from each frame."""
    units = [standard(each) for each in seen]
    scaled = [(each - m) / s for each, (m, s) in zip(seen, units, strict=True)]
    # Seeded by the time alone: places would tell the demonstrations apart and not their phases.
    found, _ = fit_blocks(scaled, scaled[0][:, :1], count, seed)
    return Blocks(
        found.weights,
        tuple(means * s + m for means, (m, s) in zip(found.means, units, strict=True)),
        tuple(c * s * s[:, None] for c, (_, s) in zip(found.covariances, units, strict=True)),
    )


def _multiplied(components: Blocks, frames: Sequence[Frame]) -> Mixture:
    """The components where the frames stand.

    A component's Gaussian is one of the time and, given the time, one of the position in each
    frame; the latter are multiplied, which leaves their mean linear in the time.
    """
    size = len(frames[0].origin)
    precision = np.zeros((len(components.weights), size, size))
    pull = np.zeros((len(components.weights), size))
    slope = np.zeros_like(pull)
    for frame, means, covariances in zip(
        frames, components.means, components.covariances, strict=True
    ):
        rate = covariances[:, 0, 1:] / covariances[:, :1, 0]
        inner = covariances[:, 1:, 1:] - rate[:, :, None] * covariances[:, :1, 1:]
        own = frame.axes @ np.linalg.inv(inner) @ frame.axes.T
        precision += own
        pull += np.einsum("kij,kj->ki", own, means[:, 1:] @ frame.axes.T + frame.origin)
        slope += np.einsum("kij,kj->ki", own, rate @ frame.axes.T)
    inner = np.asarray(np.linalg.inv(precision))
    rate = np.einsum("kij,kj->ki", inner, slope)
    times, variances = components.means[0][:, 0], components.covariances[0][:, 0, 0]
    covariance = np.empty((len(inner), size + 1, size + 1))
    covariance[:, 0, 0] = variances
    covariance[:, 0, 1:] = covariance[:, 1:, 0] = variances[:, None] * rate
    outer = rate[:, :, None] * rate[:, None, :] * variances[:, None, None]
    covariance[:, 1:, 1:] = 0.5 * (inner + inner.transpose(0, 2, 1)) + outer
    positions = np.einsum("kij,kj->ki", inner, pull)
    return Mixture(components.weights, np.column_stack([times, positions]), covariance)


def _checked(frames: Sequence[Sequence[Frame]], count: int, size: int) -> list[tuple[Frame, ...]]:
    if not isinstance(frames, Sequence) or len(frames) != count:
        raise InvalidInput(f"frames: expected a sequence for each of {count} demonstrations")
    checked = [tuple(each) for each in frames]
    for each in checked:
        wrong = [frame for frame in each if not isinstance(frame, Frame)]
        if wrong or any(len(frame.origin) != size for frame in each):
            raise InvalidInput(f"frames: expected Frame of {size} dimensions")
    if len({len(each) for each in checked}) != 1 or not checked[0]:
        raise InvalidInput("frames: expected as many for every demonstration, at least one")
    return checked
