"""Task-parameterised Gaussian mixtures: motions seen from frames that move with the task.

Every component has the same weight and the same times in all frames. In a new situation, its
Gaussians are carried into the frames where they are now, and multiplied.

Source: Calinon 2016, "A tutorial on task-parameterized movement learning and retrieval", sections
2 to 4; here the time counts once and not once per frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar

import numpy as np

from leadthrough import check
from leadthrough.blas_threads import one_blas_thread
from leadthrough.check import Float64Array, UnsupportedQuery
from leadthrough.models import archive
from leadthrough.models.archive import Arrays, FittedSkill
from leadthrough.models.coordinates import Coordinates, coordinates_of, middle_orientations
from leadthrough.models.framed import Frame, checked_frames
from leadthrough.models.gaussians.mixture import Blocks, Mixture
from leadthrough.models.mixtures import task_frames
from leadthrough.models.mixtures.gmr import GMR, GMRSkill, wanted_ends
from leadthrough.models.mixtures.phases import SAMPLES, phase_blocks, sampled, timed_columns
from leadthrough.models.mixtures.task_frames import common_coordinates, multiplied, placed, shrunk
from leadthrough.models.protocol import Demonstrations, Outliers, Parameter, Unfitted, motions_of
from leadthrough.models.queries import CheckedQuery
from leadthrough.motion import Motion, MotionT, MotionT_co, target_of

# A deviation of 5 % of a column's: frames are not weighed by finer agreement than that, which few
# demonstrations show by chance.
_MIN_VARIANCE = 3e-3


@dataclass(frozen=True)
class TaskGMR(Unfitted):
    """A task-parameterised Gaussian mixture regression of points, joints or poses over time.

    Attributes:
        components: number of components, 1 to 200.
        seed: seed of the random number generator that draws the starts of EM, >= 0.
        starts: number of starts of EM that are followed to the end, >= 1; the most likely result
            is taken. 1 is several times faster.
    """

    components: int = 8
    seed: int = 0
    starts: int = 5

    slider: ClassVar[tuple[str, int, int]] = ("components", 1, 20)

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
        outliers: Outliers = "refuse",
    ) -> TaskGMRSkill[MotionT]:
        """A skill from demonstrations, each resampled at 200 evenly spaced times.

        Args:
            demonstrations: one or more demonstrations, or motions: all of points, all of the same
                joints or all of poses.
            frames: the frames of each demonstration, in the same order in all. By default two, at
                its start and at its goal; for poses with the tool's axes there.
            outliers: without frames, treatment of a demonstration that contradicts all others, as
                for `learn`: "refuse", "drop", "keep". With frames none is compared.

        Raises:
            FitError: if there is no demonstration, one does not move or contradicts all others, or
                the orientations of poses fall into two groups.
        """
        kept: Outliers = outliers if frames is None else "keep"
        samples = sampled(motions_of(demonstrations, outliers=kept), middle=middle_orientations)
        motions, poses = samples.motions, samples.coordinates.kind == "poses"
        seen_from: Sequence[tuple[Frame, ...]]
        if frames is None:
            seen_from = [tuple(Frame.of_sample(each, row) for row in (0, -1)) for each in motions]
        else:
            size = samples.coordinates.size
            seen_from = checked_frames(frames, len(motions), size, poses=poses)
        frame_coordinates, seen = [], []
        for own in zip(*seen_from, strict=True):
            local = [frame.local(motion) for frame, motion in zip(own, motions, strict=True)]
            meaning = coordinates_of(local, samples.phases, middle=middle_orientations)
            frame_coordinates.append(meaning)
            rows = timed_columns(local, samples.phases, meaning, samples.duration)
            seen.append(np.concatenate(rows))
        search = {"seed": self.seed, "starts": self.starts}
        fitted, _ = phase_blocks(seen, self.components, poses=poses, **search, least=_MIN_VARIANCE)
        rounder = tuple(shrunk(each, len(motions), poses=poses) for each in fitted.covariances)
        return TaskGMRSkill(
            self,
            samples.coordinates,
            tuple(frame_coordinates),
            replace(fitted, covariances=rounder),
            samples.duration,
            samples.ends,
            at_ends=frames is None,
        )


# Any: settings are whatever JSON holds.
def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> TaskGMRSkill:
    mixtures = [
        Mixture(arrays["weights"], arrays[f"means_{i}"], arrays[f"covariances_{i}"])
        for i in range(int(settings["frames"]))
    ]
    components = Blocks(
        mixtures[0].weights,
        tuple(each.means for each in mixtures),
        tuple(each.covariances for each in mixtures),
    )
    coordinates = Coordinates.from_archive(settings, arrays)
    frame_coordinates = tuple(
        Coordinates.from_archive(
            replace(coordinates, posture=None).settings(),
            {"reference": arrays[f"reference_{i}"]} if coordinates.reference is not None else {},
        )
        for i in range(len(mixtures))
    )
    # A file of version 0.1 has no model; its mixtures tell the number of components.
    model = TaskGMR(**settings.get("model", {"components": len(components.weights)}))
    duration = check.number(settings["duration"], "duration", above=0.0)
    ends = check.frozen(arrays["ends"], "ends", shape=(2, coordinates.width))
    at_ends = bool(settings["at_ends"])
    return TaskGMRSkill(model, coordinates, frame_coordinates, components, duration, ends, at_ends)


@dataclass(frozen=True, eq=False)
class TaskGMRSkill(FittedSkill[MotionT_co]):
    """Components seen from the frames of a task; made by `TaskGMR.fit`.

    `generate` returns the mean motion between a start and a goal, the present poses of the two
    frames there. These carry it as far as the demonstrations support that, and no phase farther
    than 1.45 times the move of the ends; a rotated end counts as the move of the motion's farthest
    point about it. A skill with frames of its own needs those of the situation: `at`.

    Attributes:
        model: the settings that it was fitted with.
        coordinates: meaning of the d columns in the base frame.
        frame_coordinates: their meaning in each frame.
        components: components of the time, s, and the columns in each frame.
        duration: duration of the motion, s.
        ends: mean start and goal (2, d) of the demonstrations, in the columns of `coordinates`.
        at_ends: whether the frames are two, at the start and at the goal.
    """

    model: TaskGMR
    coordinates: Coordinates[MotionT_co]
    frame_coordinates: tuple[Coordinates, ...]
    components: Blocks
    duration: float
    ends: Float64Array
    at_ends: bool

    kind: ClassVar[str] = "task_gmr"

    @property
    def supports(self) -> frozenset[str]:
        """Supported parts of a query; for a skill with its own frames, use `at` instead."""
        return frozenset({"start", "goal", "duration"} if self.at_ends else {"duration"})

    def at(self, frames: Sequence[Frame]) -> GMRSkill[MotionT_co]:
        """The skill in a situation.

        Args:
            frames: the frames of the situation, in the order of those that it was fitted with.
        """
        poses = self.coordinates.kind == "poses"
        (given,) = checked_frames([frames], 1, self.coordinates.size, poses=poses)
        if len(given) != len(self.components.means):
            raise check.refused("frames", f"{len(self.components.means)} frames", len(given))
        coordinates = common_coordinates(self.coordinates, self.frame_coordinates, given)
        seen = [
            placed(frame, own, coordinates, means, self.duration)
            for frame, own, means in zip(
                given, self.frame_coordinates, self.components.means, strict=True
            )
        ]
        mixture = multiplied(self.components, seen, poses=poses)
        ends, _ = mixture.regress([[0.0], [self.duration]], inputs=[0])
        model = GMR(self.model.components, self.model.seed, self.model.starts)
        return GMRSkill(model, coordinates, mixture, self.duration, ends, 1)

    def _answer(self, query: CheckedQuery) -> MotionT_co:
        if not self.at_ends:
            raise UnsupportedQuery(
                "frames: this skill was fitted with frames of its own and needs those of the "
                "situation, in Python skill.at(frames).generate()"
            )
        nominal = self._between(self.ends, query)
        if query.start is None and query.goal is None:
            return nominal
        ends = wanted_ends(self.coordinates, self.ends, query)
        return task_frames.bounded(self._between(ends, query), nominal)

    def _between(self, ends: Float64Array, query: CheckedQuery) -> MotionT_co:
        """The motion between a start and a goal (2, d) in `coordinates`, by the frames."""
        placed_at = self.coordinates.motion(np.array([0.0, 1.0]), np.array([0.0, 1.0]), ends)
        frames = [Frame.of_sample(placed_at, row) for row in (0, -1)]
        return self.at(frames).generate(
            start=target_of(placed_at, 0),
            goal=target_of(placed_at, -1),
            duration=query.duration,
            dt=query.dt,
        )

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[MotionT_co]]:
        """The number of components, if there are demonstrations to fit again.

        None for a skill with frames of its own: the demonstrations do not tell where these were.

        Args:
            demonstrations: the demonstrations that the skill was fitted to.
        """
        return super().parameters(demonstrations) if self.at_ends else []

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        settings = {
            "model": asdict(self.model),
            "duration": self.duration,
            "at_ends": self.at_ends,
            "frames": len(self.components.means),
            **self.coordinates.settings(),
        }
        arrays = {
            "weights": self.components.weights,
            "ends": self.ends,
            **self.coordinates.arrays(),
        }
        for i, means in enumerate(self.components.means):
            arrays[f"means_{i}"] = means
            arrays[f"covariances_{i}"] = self.components.covariances[i]
            reference = self.frame_coordinates[i].reference
            if reference is not None:
                arrays[f"reference_{i}"] = reference
        return settings, arrays
