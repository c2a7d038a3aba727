"""A fitted task-parameterised mixture: brought into a situation, generated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Generic

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.models.archive import Archived, Arrays
from leadthrough.models.chart import Chart
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.frame import Frame
from leadthrough.models.gaussians.em import Blocks
from leadthrough.models.judged import judged
from leadthrough.models.mixtures.ends import wanted_ends
from leadthrough.models.mixtures.gmr import GMR
from leadthrough.models.mixtures.gmr_skill import MOST_COMPONENTS, GMRSkill
from leadthrough.models.mixtures.moved import bounded
from leadthrough.models.mixtures.task_frames import checked_frames, common_chart, placed
from leadthrough.models.mixtures.task_product import multiplied
from leadthrough.models.parameters import Parameter, fitted_again
from leadthrough.models.place import Place
from leadthrough.motion import Motion, MotionT_co, PoseTrajectory
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.models.mixtures.task_gmr import TaskGMR


@dataclass(frozen=True, eq=False)
class TaskGMRSkill(Archived, Generic[MotionT_co]):
    """Components seen from the frames of a task; made by `TaskGMR.fit`.

    Attributes:
        model: the settings that it was fitted with.
        chart: what the d columns are in the base frame.
        charts: what they are in each frame.
        components: components of the time, s, and the columns in each frame.
        duration: duration of the motion, s.
        ends: mean start and goal (2, d) of the demonstrations, in the columns of `chart`.
        at_ends: whether the frames are two, at the start and at the goal.
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
        """Parts of a query that it honours; with frames of its own, use `at` instead."""
        return frozenset({"start", "goal", "duration"} if self.at_ends else {"duration"})

    def at(self, frames: Sequence[Frame]) -> GMRSkill[MotionT_co]:
        """The skill in a situation.

        Args:
            frames: the frames of the situation, in the order of those that it was fitted with.

        Raises:
            InvalidInput: if their number or dimensions differ from those that it was fitted with.
        """
        (given,) = checked_frames([frames], 1, self.chart)
        if len(given) != len(self.components.means):
            raise InvalidInput(
                f"frames: expected {len(self.components.means)} frames, got {len(given)}"
            )
        chart = common_chart(self.chart, self.charts, given)
        seen = [
            placed(frame, own, chart, means, self.duration)
            for frame, own, means in zip(given, self.charts, self.components.means, strict=True)
        ]
        mixture = multiplied(self.components, seen, poses=chart.kind == "poses")
        ends, _ = mixture.regress([[0.0], [self.duration]], inputs=[0])
        model = GMR(self.model.components, self.model.seed, self.model.starts)
        return GMRSkill(model, chart, mixture, self.duration, ends, 1)

    @judged
    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> MotionT_co:
        """The mean motion from a start to a goal.

        The frames carry it as far as the demonstrations support that, and no phase farther than
        1.45 times the way of the ends; a turned end counts as the way of the motion's farthest
        point about it.

        Args:
            start: where the frame at the start is now: columns (d,); for poses (position (3,),
                orientation (4,) as w, x, y, z), or the position alone to keep the mean
                orientation. By default the demonstrations' mean.
            goal: where the frame at the goal is now, likewise.
            duration: duration, s, > 0; by default the skill's own.
            dt: largest time between samples, s, > 0.
            obstacles: must be empty.

        Returns:
            A motion of the type that was demonstrated.

        Raises:
            InvalidInput: if an argument is wrong.
            UnsupportedQuery: for obstacles, or if the skill was fitted with frames of its own.
        """
        if not self.at_ends:
            raise UnsupportedQuery(
                "frames: this skill was fitted with frames of its own and needs those of the "
                "situation, in Python skill.at(frames).generate()"
            )
        usual = self._between(self.ends, duration, dt, obstacles)
        if start is None and goal is None:
            return usual
        ends = wanted_ends(self.chart, self.ends, start, goal)
        return bounded(self._between(ends, duration, dt, obstacles), usual)

    def _between(
        self, ends: Float64Array, duration: float | None, dt: float, obstacles: Sequence[Shape]
    ) -> MotionT_co:
        """What the frames make of a start and a goal (2, d), in the columns of `chart`."""
        placed_at = self.chart.motion(np.array([0.0, 1.0]), np.array([0.0, 1.0]), ends)
        frames = [Frame.of_sample(placed_at, row) for row in (0, -1)]
        return self.at(frames).generate(
            start=_place(placed_at, 0),
            goal=_place(placed_at, -1),
            duration=duration,
            dt=dt,
            obstacles=obstacles,
        )

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[MotionT_co]]:
        """The number of components, if there are demonstrations to fit again.

        None for a skill with frames of its own: the demonstrations do not tell where these were.

        Args:
            demonstrations: the demonstrations that the skill was fitted to.
        """
        if not self.at_ends:
            return []
        return fitted_again(self, "components", demonstrations, least=1, most=MOST_COMPONENTS)

    # Any: settings are whatever JSON holds.
    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        """Settings and arrays that `task_gmr.from_archive` turns into the skill again."""
        settings = {
            "model": asdict(self.model),
            "duration": self.duration,
            "at_ends": self.at_ends,
            "frames": len(self.components.means),
            **self.chart.settings(),
        }
        arrays = {
            "weights": self.components.weights,
            "ends": self.ends,
            **self.chart.arrays(),
        }
        for i, means in enumerate(self.components.means):
            arrays[f"means_{i}"] = means
            arrays[f"covariances_{i}"] = self.components.covariances[i]
            reference = self.charts[i].reference
            if reference is not None:
                arrays[f"reference_{i}"] = reference
        return settings, arrays


def _place(motion: Motion, row: int) -> Place:
    """A sample of a motion, as a skill is asked for it."""
    position: Float64Array = motion.positions[row]
    return (position, motion.orientations[row]) if isinstance(motion, PoseTrajectory) else position
