"""A fitted Gaussian mixture regression: generated, regressed, updated."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Generic

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import UnsupportedQuery
from leadthrough.models.archive import Archived, Arrays
from leadthrough.models.asked_times import asked_times
from leadthrough.models.chart import Chart
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.even_times import even_times
from leadthrough.models.gaussians.mixture import Mixture
from leadthrough.models.judged import judged
from leadthrough.models.mixtures.ends import shifted, wanted_ends
from leadthrough.models.mixtures.update import learned
from leadthrough.models.parameters import Parameter, fitted_again
from leadthrough.models.place import Place
from leadthrough.motion import Motion, MotionT_co, normalised_times
from leadthrough.preprocess.resample import arc_length
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.models.mixtures.gmr import GMR

MOST_COMPONENTS = 20  # worth trying on a slider


@dataclass(frozen=True, eq=False)
class GMRSkill(Archived, Generic[MotionT_co]):
    """A mixture over time and the columns of a motion; made by `GMR.fit`.

    Attributes:
        model: the settings that it was fitted with; `components` is the number that was found.
        chart: what the d columns are: the coordinates of points, the joints, or for poses the
            position and a rotation vector from a reference orientation.
        mixture: mixture of 1 + d columns, the time first, s.
        duration: duration of the motion, s.
        ends: mean start and goal (2, d) of the demonstrations.
        demonstration_count: number of demonstrations that it has learned.
    """

    model: GMR
    chart: Chart[MotionT_co]
    mixture: Mixture
    duration: float
    ends: Float64Array
    demonstration_count: int

    kind: ClassVar[str] = "gmr"
    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration"})

    def regress(self, times: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Mean and covariance of the columns.

        Args:
            times: times (n,) of the motion, s. Outside [0, duration] the first and last components
                are extrapolated.

        Returns:
            Mean (n, d) and covariance (n, d, d).

        Raises:
            InvalidInput: if times is not a finite (n,) array.
        """
        given = check.array(times, "times", shape=("n",))
        return self.mixture.regress(given[:, None], inputs=[0])

    def distribution(self, times: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Mean (n, d) and covariance (n, d, d) of the columns: `regress`, as other skills name it.

        Args:
            times: times (n,) of the motion, s.

        Raises:
            InvalidInput: if times is not a finite (n,) array, there is none, or there are too many.
        """
        return self.regress(asked_times(times, "times"))

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
        """The mean motion, moved to a start and a goal where given.

        The offsets at both ends fade along the path.

        Args:
            start: columns (d,) at the start; for poses (position (3,), orientation (4,) as
                w, x, y, z) or the position alone. By default the demonstrations' mean.
            goal: the same at the end.
            duration: duration, s, > 0; by default the skill's own.
            dt: largest time between samples, s, > 0.
            obstacles: must be empty.

        Returns:
            A motion of the type that was demonstrated.

        Raises:
            InvalidInput: if an argument is wrong.
            UnsupportedQuery: for obstacles.
        """
        if len(obstacles) > 0:
            raise UnsupportedQuery(
                "obstacles: a GMR cannot avoid them; leave them out or use FastMarching"
            )
        check.number(dt, "dt", above=0.0)
        total = self.duration if duration is None else duration
        times = even_times(check.number(total, "duration", above=0.0), dt)
        phases = normalised_times(times)
        columns, _ = self.regress(phases * self.duration)
        length = arc_length(columns[:, : self.chart.size])
        covered = length / length[-1] if length[-1] > 0.0 else phases
        columns = shifted(columns, covered, wanted_ends(self.chart, self.ends, start, goal))
        return self.chart.motion(times, phases, columns)

    def updated(self, demonstrations: Demonstrations[Motion]) -> GMRSkill[MotionT_co]:
        """A skill that has learned further demonstrations; the earlier ones are not needed.

        The components are adapted; their number stays.

        Args:
            demonstrations: one or more demonstrations of the skill's type of motion.

        Raises:
            InvalidInput: if the demonstrations are of another type.
            FitError: if there is none, or one does not move.
        """
        mixture, ends, count = learned(self, demonstrations)
        return replace(self, mixture=mixture, ends=ends, demonstration_count=count)

    def component_orientations(self) -> Float64Array:
        """Mean orientations (k, 4) of the components of a skill of poses, w, x, y, z.

        Raises:
            UnsupportedQuery: if the skill is not of poses.
        """
        if self.chart.kind != "poses":
            raise UnsupportedQuery(
                "component_orientations: expected a skill of poses, this is one of "
                f"{self.chart.kind}"
            )
        phases = np.clip(self.mixture.means[:, 0] / self.duration, 0.0, 1.0)
        order = np.argsort(phases, kind="stable")
        turned = self.chart.orientations(self.mixture.means[order, 4:], phases[order])
        result = np.empty_like(turned)
        result[order] = turned
        return result

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[MotionT_co]]:
        """The number of components, if there are demonstrations to fit again.

        Args:
            demonstrations: the demonstrations that the skill was fitted to.
        """
        return fitted_again(self, "components", demonstrations, least=1, most=MOST_COMPONENTS)

    # Any: settings are whatever JSON holds.
    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        """Settings and arrays that `gmr.from_archive` turns into the skill again."""
        settings = {
            "model": asdict(self.model),
            "duration": self.duration,
            "shown": self.demonstration_count,  # the name in files
            **self.chart.settings(),
        }
        arrays = {
            "weights": self.mixture.weights,
            "means": self.mixture.means,
            "covariances": self.mixture.covariances,
            "ends": self.ends,
            **self.chart.arrays(),
        }
        return settings, arrays
