"""A fitted Gaussian mixture regression: asked for motions, updated, turned into stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Generic, cast

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import UnsupportedQuery
from leadthrough.io.atomic import StrPath
from leadthrough.models import archive
from leadthrough.models.chart import Chart
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.mixtures.mixture import Mixture
from leadthrough.models.mixtures.update import learned
from leadthrough.models.parameters import Parameter, whole_number
from leadthrough.models.place import Place
from leadthrough.models.sampling import even_times
from leadthrough.motion import Motion, MotionT_co, normalised_times
from leadthrough.preprocess.resample import arc_length
from leadthrough.shapes import Shape

if TYPE_CHECKING:
    from leadthrough.models.mixtures.gmr import GMR

MOST_COMPONENTS = 20  # worth trying


@dataclass(frozen=True, eq=False)
class GMRSkill(Generic[MotionT_co]):
    """What was learned; made by `GMR.fit`.

    Attributes:
        model: the settings that it was fitted with, with the number of components that was found.
        chart: what the d columns are: the coordinates of points, the joints, or for poses the
            position and a rotation vector from a reference orientation.
        mixture: over the time, s, and the d columns.
        duration: s.
        ends: (2, d) mean start and goal of the demonstrations.
        shown: number of demonstrations.
    """

    model: GMR
    chart: Chart[MotionT_co]
    mixture: Mixture
    duration: float
    ends: Float64Array
    shown: int

    kind: ClassVar[str] = "gmr"
    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration"})

    def regress(self, times: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """Mean (n, d) and covariance (n, d, d) of the columns at times (n,), s, of the motion.

        Beyond [0, duration] they are what the outer components say. Raises InvalidInput.
        """
        given = check.array(times, "times", shape=("n",))
        return self.mixture.regress(given[:, None], inputs=[0])

    def distribution(self, times: ArrayLike) -> tuple[Float64Array, Float64Array]:
        """As `regress`, by the name that it has in every skill that knows a spread."""
        return self.regress(times)

    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> MotionT_co:
        """The mean motion, shifted to start and goal; of the type that was shown.

        start, goal: (d,), for poses (position (3,), orientation (4,)) or the position alone, by
        default the demonstrations' means; the offsets at both ends fade over the way.
        duration: s, > 0. dt: s, upper bound of the sampling step. Raises InvalidInput;
        UnsupportedQuery for obstacles.
        """
        if len(obstacles) > 0:
            raise UnsupportedQuery("obstacles: this model cannot avoid them; see FastMarching")
        check.number(dt, "dt", above=0.0)
        total = self.duration if duration is None else duration
        times = even_times(check.number(total, "duration", above=0.0), dt)
        phases = normalised_times(times)
        columns, _ = self.regress(phases * self.duration)
        way = arc_length(columns[:, : self.chart.size])
        shares = way / way[-1] if way[-1] > 0.0 else phases
        columns = shifted(columns, shares, self._ends(start, goal))
        return self.chart.motion(times, phases, columns)

    def updated(self, demonstrations: Demonstrations[Motion]) -> GMRSkill[MotionT_co]:
        """A skill that has learned further demonstrations, without the ones learned before.

        The components are adapted, not added to. Raises InvalidInput for motions of another type;
        FitError as `GMR.fit`.
        """
        mixture, ends, shown = learned(self, demonstrations)
        return replace(self, mixture=mixture, ends=ends, shown=shown)

    def component_orientations(self) -> Float64Array:
        """The components' mean orientations (k, 4), w, x, y, z; only of poses.

        Raises UnsupportedQuery for another type of motion.
        """
        if self.chart.kind != "poses":
            raise UnsupportedQuery(f"orientations: a skill of {self.chart.kind} has none")
        phases = np.clip(self.mixture.means[:, 0] / self.duration, 0.0, 1.0)
        order = np.argsort(phases, kind="stable")
        turned = self.chart.orientations(self.mixture.means[order, 4:], phases[order])
        result = np.empty_like(turned)
        result[order] = turned
        return result

    def parameters(
        self, demonstrations: Demonstrations[Motion] = ()
    ) -> Sequence[Parameter[MotionT_co]]:
        """Its number of components, where there are demonstrations to fit again."""
        if len(demonstrations) == 0:
            return []

        def fitted(components: int) -> GMRSkill[MotionT_co]:
            made = replace(self.model, components=components).fit(demonstrations)
            return cast(GMRSkill[MotionT_co], made)

        count = len(self.mixture.weights)
        return [whole_number("components", count, least=1, most=MOST_COMPONENTS, apply=fitted)]

    def save(self, path: StrPath) -> None:
        """Writes the skill to a .npz file that `load_skill` reads. Raises InvalidInput."""
        archive.write(path, self.kind, *self.to_archive())

    def to_archive(self) -> tuple[dict[str, Any], archive.Arrays]:
        """Settings and arrays that `from_archive` puts together again."""
        settings = {
            "model": asdict(self.model),
            "duration": self.duration,
            "shown": self.shown,
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

    def _ends(self, start: Place | None, goal: Place | None) -> Float64Array:
        wanted = self.ends.copy()
        for row, (value, name) in enumerate(((start, "start"), (goal, "goal"))):
            if value is not None:
                given = self.chart.target(value, name, float(row))
                wanted[row, : len(given)] = given
        return wanted


def shifted(columns: Float64Array, shares: Float64Array, ends: Float64Array) -> Float64Array:
    """Columns (n, d) moved to the ends (2, d); the offsets fade with shares (n,) of the way."""
    offsets = ends - columns[[0, -1]]
    return np.asarray(columns + np.outer(1.0 - shares, offsets[0]) + np.outer(shares, offsets[1]))
