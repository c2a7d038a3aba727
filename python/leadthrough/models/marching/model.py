"""Fast Marching Learning: demonstrations become a speed map, a wave in it gives the path.

Source: Prados et al. 2023, Appl. Sci. 13:2028, Algorithm 1.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from leadthrough import check, events
from leadthrough.errors import InvalidInput
from leadthrough.models import archive
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.marching.experience import Experience, experience_of
from leadthrough.models.marching.hindrance import OBSTACLE_MAPS
from leadthrough.models.marching.orientation import refuse_opposed
from leadthrough.models.marching.skill import FastMarchingSkill
from leadthrough.models.marching.time_law import TIMINGS
from leadthrough.models.unfitted import Unfitted
from leadthrough.motion import MotionT

METHODS = ("auto", "map", "start", "mean_path")


@dataclass(frozen=True)
class FastMarching(Unfitted):
    """Fast Marching Learning of point-to-point motions in two or three dimensions.

    Lengths are in the demonstrations' unit.

    Attributes:
        area_of_influence: radius of the tubes around paths, > 0; None: 0.02 of the demonstrations'
            mean length for "map", 0.01 of it otherwise.
        saturation: speed outside the tubes, in (0, 1]. With "map" and "start" small values follow
            the demonstrations closely and large ones cut corners; "mean_path" follows the middle of
            its tube, and needs it for detours around obstacles only.
        resolution: edge of a cell, > 0; None: a fifth of the radius.
        method: "map", all demonstrations in one map (Algorithm 1); "start", those that start near;
            "mean_path", a tube around the path that they predict; "auto", "mean_path" where start
            and goal lie near a demonstration's ends, otherwise "map" with those demonstrations that
            lead there; one random walk alone shows no way, a smooth one cannot be told from a
            motion that was meant. All keep the usual way where start or goal is moved a little,
            or `Route.leaves_usual_way` says that they leave it.
        timing: "demonstrations", their mean progress along the path; "speed_map", speed
            proportional to the map's; "constant". Motions start and end at rest in all of them.
        workspace: (lower, upper) corners (d,) each, which no path leaves and the map fills; None:
            as much room as is needed.
        obstacle_map: "product", the speed grows from 0 at an obstacle to its own value half an area
            of influence away ("mean_path": a whole one, as its detours have room); "minimum",
            eq. 7 of the paper, slows the wave down only below the saturation, so that paths come
            nearer to obstacles.

    Raises:
        InvalidInput: if a setting is outside its range.
    """

    area_of_influence: float | None = None
    saturation: float = 0.02
    resolution: float | None = None
    method: str = "auto"
    timing: str = "demonstrations"
    workspace: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    obstacle_map: Literal["product", "minimum"] = "product"

    def __post_init__(self) -> None:
        check.number(self.saturation, "saturation", above=0.0, at_most=1.0)
        for name in ("area_of_influence", "resolution"):
            if getattr(self, name) is not None:
                check.number(getattr(self, name), name, above=0.0)
        check.choice(self.method, "method", METHODS)
        check.choice(self.timing, "timing", TIMINGS)
        check.choice(self.obstacle_map, "obstacle_map", OBSTACLE_MAPS)
        if self.workspace is not None:
            corners = check.array(self.workspace, "workspace", shape=(2, "d"))
            if not (corners[0] < corners[1]).all():
                raise InvalidInput(
                    f"workspace: expected corners (lower, upper) with lower < upper, got {corners}"
                )
            plain = tuple(tuple(float(x) for x in corner) for corner in corners)
            object.__setattr__(self, "workspace", plain)

    def fit(self, demonstrations: Demonstrations[MotionT]) -> FastMarchingSkill[MotionT]:
        """A skill from demonstrations.

        Args:
            demonstrations: all of points in two or three dimensions, or all of poses. Without any,
                the skill goes the shortest way.

        Raises:
            InvalidInput: for other motions.
            FitError: for a demonstration of a single sample, or whose position does not move, and
                for demonstrations of one path whose orientations along it have no mean.
        """
        shown = experience_of(demonstrations)
        if len(shown) > 1:
            refuse_opposed(shown)
        return FastMarchingSkill(self, shown)


def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> FastMarchingSkill:
    """The skill that `FastMarchingSkill.to_archive` took apart."""
    counts = [int(settings.pop(name)) for name in ("shown", "learned")]
    total = sum(counts)
    happened = settings.pop("events", [()] * total)
    names = settings.pop("joint_names", [None] * total)
    everything = tuple(
        Experience.from_arrays(
            arrays, i, happening=events.from_plain(happened[i]), joint_names=names[i]
        )
        for i in range(total)
    )
    model = FastMarching(**settings)  # JSON keeps no tuples; the model makes them again
    return FastMarchingSkill(model, everything[: counts[0]], everything[counts[0] :])
