"""A fitted Gaussian mixture regression: asked for motions, updated, turned into stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput, UnsupportedQuery
from leadthrough.io.atomic import StrPath
from leadthrough.models import archive
from leadthrough.models.chart import Chart
from leadthrough.models.mixtures.mixture import Mixture
from leadthrough.models.mixtures.update import learned
from leadthrough.models.sampling import even_times
from leadthrough.motion import Demonstration, normalised_times
from leadthrough.preprocess.resample import arc_length
from leadthrough.shapes import Shape


@dataclass(frozen=True, eq=False)
class GMRSkill:
    """What was learned; made by `GMR.fit`.

    mixture: over the time, s, and the d columns of `chart`: the coordinates of points, the joints,
    or for poses the position and a rotation vector from a reference orientation. duration: s.
    ends: (2, d) where the demonstrations start and end on the mean. shown: how many there were.
    """

    chart: Chart
    mixture: Mixture
    duration: float
    ends: Float64Array
    shown: int

    kind: ClassVar[str] = "gmr"
    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration"})

    def regress(self, times: Any) -> tuple[Float64Array, Float64Array]:
        """Mean (n, d) and covariance (n, d, d) of the columns at times (n,), s, of the motion.

        Beyond [0, duration] they are what the outer components say. Raises InvalidInput.
        """
        given = check.array(times, "times", shape=("n",))
        return self.mixture.regress(given[:, None], inputs=[0])

    def generate(
        self,
        *,
        start: Any = None,
        goal: Any = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> Any:
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

    def updated(self, demonstrations: Sequence[Demonstration]) -> GMRSkill:
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

    def save(self, path: StrPath) -> None:
        """Writes the skill to a .npz file that `load_skill` reads. Raises InvalidInput."""
        archive.write(path, self.kind, *self.to_archive())

    def to_archive(self) -> tuple[dict[str, Any], archive.Arrays]:
        """Settings and arrays that `from_archive` puts together again."""
        settings = {"duration": self.duration, "shown": self.shown, **self.chart.settings()}
        arrays = {
            "weights": self.mixture.weights,
            "means": self.mixture.means,
            "covariances": self.mixture.covariances,
            "ends": self.ends,
            **self.chart.arrays(),
        }
        return settings, arrays

    @classmethod
    def from_archive(cls, settings: dict[str, Any], arrays: archive.Arrays) -> GMRSkill:
        """The skill that `save` took apart. Raises KeyError, TypeError, ValueError."""
        chart = Chart.from_archive(settings, arrays)
        mixture = Mixture(arrays["weights"], arrays["means"], arrays["covariances"])
        if mixture.size != chart.width + 1:
            raise InvalidInput(f"means: expected {chart.width + 1} columns, got {mixture.size}")
        ends = check.frozen(arrays["ends"], "ends", shape=(2, chart.width))
        duration = check.number(settings["duration"], "duration", above=0.0)
        return cls(chart, mixture, duration, ends, int(settings["shown"]))

    def _ends(self, start: Any, goal: Any) -> Float64Array:
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
