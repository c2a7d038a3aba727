"""Task-parameterised Gaussian mixtures: motions seen from frames that move with the task.

Every component has the same weight and the same times in all frames. In a new situation, its
Gaussians are carried into the frames where they are now, and multiplied.

Source: Calinon 2016, "A tutorial on task-parameterized movement learning and retrieval", sections
2 to 4; here the time counts once and not once per frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import Float64Array
from leadthrough.models import archive
from leadthrough.models.chart import Chart, chart_of
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.frame import Frame
from leadthrough.models.gaussians.em import Blocks
from leadthrough.models.gaussians.mixture import Mixture
from leadthrough.models.mean_turning import middle_orientations
from leadthrough.models.mixtures.phases import phase_blocks
from leadthrough.models.mixtures.samples import SAMPLES, sampled, timed_columns
from leadthrough.models.mixtures.shrinkage import shrunk
from leadthrough.models.mixtures.task_frames import checked_frames
from leadthrough.models.mixtures.task_gmr_skill import TaskGMRSkill
from leadthrough.models.unfitted import Unfitted
from leadthrough.motion import MotionT

# A deviation of 5 % of a column's: frames are not weighed by finer agreement than that, which few
# demonstrations show by chance.
_LEAST_VARIANCE = 3e-3


@dataclass(frozen=True)
class TaskGMR(Unfitted):
    """A task-parameterised Gaussian mixture regression of points, joints or poses over time.

    Attributes:
        components: number of components, 1 to 200.
        seed: seed of the random number generator that draws the starts of EM, >= 0.
        starts: number of starts of EM that are followed to the end, >= 1; the most likely result
            is taken. 1 is several times faster.

    Raises:
        InvalidInput: if a setting is out of range.
    """

    components: int = 8
    seed: int = 0
    starts: int = 5

    def __post_init__(self) -> None:
        check.integer(self.components, "components", at_least=1, at_most=SAMPLES)
        check.integer(self.seed, "seed", at_least=0)
        check.integer(self.starts, "starts", at_least=1)

    @one_blas_thread
    def fit(
        self,
        demonstrations: Demonstrations[MotionT],
        *,
        frames: Sequence[Sequence[Frame]] | None = None,
    ) -> TaskGMRSkill[MotionT]:
        """A skill from demonstrations, each resampled at 200 evenly spaced times.

        Args:
            demonstrations: one or more demonstrations, or motions: all of points, all of the same
                joints or all of poses.
            frames: the frames of each demonstration, in the same order in all. By default two, at
                its start and at its goal; for poses with the tool's axes there.

        Raises:
            InvalidInput: if the demonstrations differ in type or the frames do not fit them.
            FitError: if there is no demonstration, one does not move, or the orientations of poses
                fall into two groups.
        """
        shown = sampled(demonstrations, middle=middle_orientations)
        seen_from = (
            [(Frame.of_sample(motion, 0), Frame.of_sample(motion, -1)) for motion in shown.motions]
            if frames is None
            else checked_frames(frames, len(shown.motions), shown.chart)
        )
        charts, seen = [], []
        for own in zip(*seen_from, strict=True):
            local = [frame.local(motion) for frame, motion in zip(own, shown.motions, strict=True)]
            charts.append(chart_of(local, shown.phases, middle=middle_orientations))
            rows = timed_columns(local, shown.phases, charts[-1], shown.duration)
            seen.append(np.concatenate(rows))
        poses = shown.chart.kind == "poses"
        components = _fitted(
            seen,
            self.components,
            demonstrations=len(shown.motions),
            poses=poses,
            seed=self.seed,
            starts=self.starts,
        )
        at_ends = frames is None
        return TaskGMRSkill(
            self, shown.chart, tuple(charts), components, shown.duration, shown.ends, at_ends
        )


# Any: settings are whatever JSON holds.
def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> TaskGMRSkill:
    """The skill from the settings and arrays that `TaskGMRSkill.to_archive` returned."""
    mixtures = [
        Mixture(arrays["weights"], arrays[f"means_{i}"], arrays[f"covariances_{i}"])
        for i in range(int(settings["frames"]))
    ]
    components = Blocks(
        mixtures[0].weights,
        tuple(each.means for each in mixtures),
        tuple(each.covariances for each in mixtures),
    )
    chart = Chart.from_archive(settings, arrays)
    charts = tuple(
        Chart.from_archive(
            replace(chart, posture=None).settings(),
            {"reference": arrays[f"reference_{i}"]} if chart.reference is not None else {},
        )
        for i in range(len(mixtures))
    )
    # A file of version 0.1 has no model; its mixtures tell the number of components.
    model = TaskGMR(**settings.get("model", {"components": len(components.weights)}))
    duration = check.number(settings["duration"], "duration", above=0.0)
    ends = check.frozen(arrays["ends"], "ends", shape=(2, chart.width))
    at_ends = bool(settings["at_ends"])
    return TaskGMRSkill(model, chart, charts, components, duration, ends, at_ends)


def _fitted(
    seen: Sequence[Float64Array],
    count: int,
    *,
    demonstrations: int,
    poses: bool,
    seed: int,
    starts: int,
) -> Blocks:
    """Components of the times and columns (n, 1 + d) seen from each frame."""
    found, _ = phase_blocks(
        seen, count, poses=poses, seed=seed, starts=starts, least=_LEAST_VARIANCE
    )
    rounder = tuple(shrunk(each, demonstrations, poses=poses) for each in found.covariances)
    return replace(found, covariances=rounder)
