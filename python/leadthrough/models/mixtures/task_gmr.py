"""Task-parameterised Gaussian mixtures: motions seen from frames that move with the task.

Components that are the same in every frame; where the frames of a new situation stand, their
Gaussians are multiplied. Source: Calinon 2016, "A tutorial on task-parameterized movement learning
and retrieval", sections 2 to 4; here the time counts once and not once a frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar, Generic, cast

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.io.atomic import StrPath
from leadthrough.models import archive
from leadthrough.models.chart import Chart, chart_of
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.mixtures.em import Blocks, fit_blocks
from leadthrough.models.mixtures.fitting import standard
from leadthrough.models.mixtures.gmr import GMR
from leadthrough.models.mixtures.gmr_skill import MOST_COMPONENTS, GMRSkill
from leadthrough.models.mixtures.mixture import Mixture
from leadthrough.models.mixtures.samples import SAMPLES, sampled, timed_columns
from leadthrough.models.mixtures.task_frames import Frame, Placed, checked, common_chart, placed
from leadthrough.models.parameters import Parameter, whole_number
from leadthrough.models.place import Place
from leadthrough.motion import Motion, MotionT, MotionT_co, PoseTrajectory
from leadthrough.shapes import Shape


@dataclass(frozen=True)
class TaskGMR:
    """A task-parameterised mixture of points, joints or poses.

    components: >= 1. seed: of the starts of EM.
    """

    components: int = 8
    seed: int = 0

    def __post_init__(self) -> None:
        check.integer(self.components, "components", at_least=1, at_most=SAMPLES)
        check.integer(self.seed, "seed", at_least=0)

    def fit(
        self,
        demonstrations: Demonstrations[MotionT],
        *,
        frames: Sequence[Sequence[Frame]] | None = None,
    ) -> TaskGMRSkill[MotionT]:
        """A skill from demonstrations, all of points, of the same joints, or of poses.

        frames: those of each demonstration, in the same order in all; by default two, at its start
        and at its goal, for poses with the tool's axes there. Raises InvalidInput; FitError for a
        demonstration that does not move.
        """
        shown = sampled(demonstrations)
        seen_from = (
            [(_at(motion, 0), _at(motion, -1)) for motion in shown.motions]
            if frames is None
            else checked(frames, len(shown.motions), shown.chart)
        )
        charts, seen = [], []
        for own in zip(*seen_from, strict=True):
            local = [frame.local(motion) for frame, motion in zip(own, shown.motions, strict=True)]
            charts.append(chart_of(local, shown.phases))
            rows = timed_columns(local, shown.phases, charts[-1], shown.duration)
            seen.append(np.concatenate(rows))
        components = _fitted(seen, self.components, self.seed)
        at_ends = frames is None
        return TaskGMRSkill(
            self, shown.chart, tuple(charts), components, shown.duration, shown.ends, at_ends
        )


@dataclass(frozen=True, eq=False)
class TaskGMRSkill(Generic[MotionT_co]):
    """What was learned; made by `TaskGMR.fit`.

    Attributes:
        model: the settings that it was fitted with.
        chart: what the d columns are in the base frame.
        charts: what they are in each frame.
        components: over the time, s, and the columns of the charts.
        duration: s.
        ends: (2, d) mean start and goal of the demonstrations, in the columns of `chart`.
        at_ends: whether its two frames stand at start and goal.
    """

    model: TaskGMR
    chart: Chart[MotionT_co]
    charts: tuple[Chart, ...]
    components: Blocks
    duration: float
    ends: Float64Array
    at_ends: bool

    kind: ClassVar[str] = "task_gmr"

    @property
    def supports(self) -> frozenset[str]:
        """Parts of a query that it honours; with frames of its own, see `at`."""
        return frozenset({"start", "goal", "duration"} if self.at_ends else {"duration"})

    def at(self, frames: Sequence[Frame]) -> GMRSkill[MotionT_co]:
        """The skill in a situation, with frames as it was fitted with. Raises InvalidInput."""
        (given,) = checked([frames], 1, self.chart)
        if len(given) != len(self.components.means):
            raise InvalidInput(
                f"frames: expected {len(self.components.means)} of them, got {len(given)}"
            )
        chart: Chart[MotionT_co] = common_chart(self.chart, self.charts, given)
        seen = [
            placed(frame, own, chart, means, self.duration)
            for frame, own, means in zip(given, self.charts, self.components.means, strict=True)
        ]
        mixture = _multiplied(self.components, seen)
        ends, _ = mixture.regress([[0.0], [self.duration]], inputs=[0])
        model = GMR(self.model.components, self.model.seed)
        return GMRSkill(model, chart, mixture, self.duration, ends, 1)

    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> MotionT_co:
        """The mean motion from a start to a goal, by default the mean ones.

        start, goal: (d,), for poses (position (3,), orientation (4,)) or the position alone.
        duration, dt: s, > 0. Raises InvalidInput; UnsupportedQuery for obstacles, and for a skill
        with frames other than those at start and goal.
        """
        if not self.at_ends:
            raise UnsupportedQuery("start: this skill has frames of its own; ask skill.at(frames)")
        ends = self.ends.copy()
        for row, (value, name) in enumerate(((start, "start"), (goal, "goal"))):
            if value is not None:
                given = self.chart.target(value, name, float(row))
                ends[row, : len(given)] = given
        shown = self.chart.motion(np.array([0.0, 1.0]), np.array([0.0, 1.0]), ends)
        wanted = {name: _query(shown, row) for row, name in enumerate(("start", "goal"))}
        return self.at([_at(shown, 0), _at(shown, -1)]).generate(
            **wanted, duration=duration, dt=dt, obstacles=obstacles
        )

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[MotionT_co]]:
        """Its number of components, where there are demonstrations to fit again.

        None for a skill with frames of its own: the demonstrations do not tell where these stood.
        """
        if len(demonstrations) == 0 or not self.at_ends:
            return []

        def fitted(components: int) -> TaskGMRSkill[MotionT_co]:
            made = replace(self.model, components=components).fit(demonstrations)
            return cast(TaskGMRSkill[MotionT_co], made)

        count = self.model.components
        return [whole_number("components", count, least=1, most=MOST_COMPONENTS, apply=fitted)]

    def save(self, path: StrPath) -> None:
        """Writes the skill to a .npz file that `load_skill` reads. Raises InvalidInput."""
        archive.write(path, self.kind, *self.to_archive())

    def to_archive(self) -> tuple[dict[str, Any], archive.Arrays]:
        """Settings and arrays that `from_archive` puts together again."""
        settings = {
            "model": asdict(self.model),
            "duration": self.duration,
            "at_ends": self.at_ends,
            "frames": len(self.components.means),
            **self.chart.settings(),
        }
        arrays: dict[str, Any] = {
            "weights": self.components.weights,
            "ends": self.ends,
            **self.chart.arrays(),
        }
        for i, means in enumerate(self.components.means):
            arrays[f"means_{i}"] = means
            arrays[f"covariances_{i}"] = self.components.covariances[i]
            if self.charts[i].reference is not None:
                arrays[f"reference_{i}"] = self.charts[i].reference
        return settings, arrays

    @staticmethod
    def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> TaskGMRSkill:
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
        charts = tuple(
            Chart.from_archive(
                chart.settings(),
                {"reference": arrays[f"reference_{i}"]} if chart.reference is not None else {},
            )
            for i in range(len(mixtures))
        )
        ends = check.frozen(arrays["ends"], "ends", shape=(2, chart.width))
        # A file of version 0.1 has no model; its mixtures tell the number of components.
        model = TaskGMR(**settings.get("model", {"components": len(components.weights)}))
        return TaskGMRSkill(
            model, chart, charts, components, duration, ends, bool(settings["at_ends"])
        )


def _at(motion: Motion, row: int) -> Frame:
    """The frame at a sample of a motion."""
    if isinstance(motion, PoseTrajectory):
        return Frame.of_pose(motion.positions[row], motion.orientations[row])
    return Frame(motion.positions[row])


def _query(motion: Motion, row: int) -> Place:
    """A sample of a motion as a skill is asked for it."""
    position: Float64Array = motion.positions[row]
    return (position, motion.orientations[row]) if isinstance(motion, PoseTrajectory) else position


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


def _multiplied(components: Blocks, seen: Sequence[Placed]) -> Mixture:
    """The components where the frames stand.

    A component's Gaussian is one of the time and, given the time, one of the columns in each
    frame; the latter are multiplied, which leaves their mean linear in the time.
    """
    size = seen[0].means.shape[1]
    precision = np.zeros((len(components.weights), size, size))
    pull = np.zeros((len(components.weights), size))
    slope = np.zeros_like(pull)
    for each, covariances in zip(seen, components.covariances, strict=True):
        rate = covariances[:, 0, 1:] / covariances[:, :1, 0]
        inner = covariances[:, 1:, 1:] - rate[:, :, None] * covariances[:, :1, 1:]
        own = np.asarray(np.linalg.inv(each.maps @ inner @ each.maps.transpose(0, 2, 1)))
        precision += own
        pull += _times(own, each.means)
        slope += _times(own, _times(each.maps, rate) + each.drift)
    inner = np.asarray(np.linalg.inv(precision))
    rate = _times(inner, slope)
    times, variances = components.means[0][:, 0], components.covariances[0][:, 0, 0]
    covariance = np.empty((len(times), size + 1, size + 1))
    covariance[:, 0, 0] = variances
    covariance[:, 0, 1:] = covariance[:, 1:, 0] = variances[:, None] * rate
    outer = rate[:, :, None] * rate[:, None, :] * variances[:, None, None]
    covariance[:, 1:, 1:] = 0.5 * (inner + inner.transpose(0, 2, 1)) + outer
    return Mixture(components.weights, np.column_stack([times, _times(inner, pull)]), covariance)


def _times(matrices: Float64Array, vectors: Any) -> Float64Array:
    """Products (k, d) of matrices (k, d, d) with vectors (k, d)."""
    return np.asarray(np.einsum("kij,kj->ki", matrices, vectors))
