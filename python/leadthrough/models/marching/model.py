"""Fast Marching Learning: demonstrations become a speed map, a wave in it gives the path.

Source: Prados et al. 2023, Appl. Sci. 13:2028, Algorithm 1 and eqs. 6 and 7.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, partial
from os import PathLike
from typing import Any, ClassVar, Generic, Literal, cast

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.models import archive
from leadthrough.models.archive import Arrays, FittedSkill
from leadthrough.models.marching import experience
from leadthrough.models.marching.experience import Experience, experience_of, orientations_along
from leadthrough.models.marching.planner import planned
from leadthrough.models.marching.policy import Policy, policy_to
from leadthrough.models.marching.route import LiveMap, Query, Route, query_of, split
from leadthrough.models.marching.time_law import TIMINGS, timed
from leadthrough.models.protocol import Demonstrations, Outliers, Parameter, Unfitted
from leadthrough.models.queries import CheckedQuery
from leadthrough.motion import (
    Motion,
    MotionT,
    MotionT_co,
    PoseTrajectory,
    Target,
    Trajectory,
    plain_events,
)
from leadthrough.planning import Grid, maps
from leadthrough.shapes import Shape, check_shapes

METHODS = ("auto", "map", "start", "mean_path")
# Cells of a preview's map.
_PREVIEW_CELLS = 1_000_000
# Room around demonstrations, goal and obstacles, as a fraction of their extent, in which things may
# be dragged before a preview's map has to be made anew.
_ROOM_TO_DRAG = 0.5
_SATURATIONS, _SATURATION_STEP = (0.005, 0.5), 0.005
# The radii worth trying, in multiples of the present one, and the steps between them.
_RADII, _RADIUS_STEPS = (0.4, 4.0), 100


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
            lead there; a single random walk predicts no path, unless it is smooth. For slightly
            moved ends all keep to the nominal route, or set `Route.leaves_nominal_route`.
        timing: "demonstrations", their mean progress along the path; "speed_map", speed
            proportional to the map's; "constant". Motions start and end at rest in all of them.
        workspace: (lower, upper) corners (d,) each, which no path leaves and the map fills; None:
            as much room as is needed.
        obstacle_map: "product", the speed grows from 0 at an obstacle to its own value half an area
            of influence away ("mean_path": a whole one, as its detours have room); "minimum",
            eq. 7 of the paper, slows the wave down only below the saturation, so that paths come
            nearer to obstacles.
    """

    area_of_influence: float | None = None
    saturation: float = 0.02
    resolution: float | None = None
    method: str = "auto"
    timing: str = "demonstrations"
    workspace: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    obstacle_map: Literal["product", "minimum"] = "product"

    def __post_init__(self) -> None:
        if self.workspace is not None:
            corners = check.array(self.workspace, "workspace", shape=(2, "d"))
            if not (corners[0] < corners[1]).all():
                raise InvalidInput(
                    f"workspace: expected corners (lower, upper) with lower < upper, got {corners}"
                )
            plain = tuple(tuple(float(x) for x in corner) for corner in corners)
            object.__setattr__(self, "workspace", plain)
        check.number(self.saturation, "saturation", above=0.0, at_most=1.0)
        for name in ("area_of_influence", "resolution"):
            if getattr(self, name) is not None:
                check.number(getattr(self, name), name, above=0.0)
        check.choice(self.method, "method", METHODS)
        check.choice(self.timing, "timing", TIMINGS)
        check.choice(self.obstacle_map, "obstacle_map", maps.OBSTACLE_MAPS)

    def fit(
        self, demonstrations: Demonstrations[MotionT], *, outliers: Outliers = "refuse"
    ) -> FastMarchingSkill[MotionT]:
        """A skill from demonstrations.

        Args:
            demonstrations: all of points in two or three dimensions, or all of poses. Without any,
                the skill takes the shortest path.
            outliers: treatment of one that contradicts all others: "refuse", "drop" or "keep", as
                for `learn`.

        Raises:
            FitError: for a demonstration of a single sample, whose position does not move, or that
                contradicts all others, and for demonstrations of one path whose orientations along
                it have no mean.
        """
        demonstrated = experience_of(demonstrations, outliers=outliers)
        if len(demonstrated) > 1:
            experience.refuse_opposed(demonstrated)
        return FastMarchingSkill(self, demonstrated)


@dataclass(frozen=True, eq=False)
class FastMarchingSkill(FittedSkill[MotionT_co]):
    """A fitted Fast Marching model; made by `FastMarching.fit`.

    `generate` starts and ends at rest, by default at the centroids of the demonstrations' starts
    and goals and with their duration, adapted to the path's length. It raises NoPath if start or
    goal lies in an obstacle, or obstacles separate them.

    Attributes:
        model: the settings that it was fitted with.
        demonstrated: the demonstrations.
        learned: paths that were added since, by `with_experience` or `auto_learn`.
    """

    model: FastMarching
    demonstrated: tuple[Experience, ...]
    learned: tuple[Experience, ...] = ()

    kind: ClassVar[str] = "fast_marching"
    supports: ClassVar[frozenset[str]] = frozenset({"start", "goal", "duration", "obstacles"})

    @property
    def experience(self) -> tuple[Float64Array, ...]:
        """All paths, (n, d) each, first the demonstrated, then the auto-learned ones."""
        return tuple(each.path for each in self._all)

    @property
    def area_of_influence(self) -> float:
        """Radius of the tubes in the velocity map."""
        return self._map_scales.radius

    @property
    def grid(self) -> Grid:
        """The cells of the velocity map."""
        return self._map[0]

    @property
    def velocity_map(self) -> Float64Array:
        """Speeds in [saturation, 1] over `grid`, from the raw experience: Algorithm 1's F."""
        return self._map[1]

    def map_with(self, obstacles: Sequence[Shape]) -> Float64Array:
        """The velocity map with obstacles; to plan, "map" adds detours around those in a tube.

        Args:
            obstacles: shapes in the demonstrations' frame.
        """
        grid, speed = self._map
        return maps.with_obstacles(speed, grid, check_shapes(obstacles), self._map_scales)

    def kappa(self, path: ArrayLike) -> float:
        """Mean of the velocity map along a path: 1 deep in the experience.

        It is taken evenly over the path's length, so that pauses do not count, and never lies below
        the saturation, which holds outside the map.

        Args:
            path: (n, d), n >= 1.

        Source: Prados et al. 2023, eq. 6.
        """
        given = check.array(path, "path", shape=("n", self._dimensions()))
        if len(given) == 0:
            raise InvalidInput("path: expected at least one point, got none")
        return maps.mean_speed(given, self.grid, self.velocity_map, self.model.saturation)

    def with_experience(
        self, path: ArrayLike, *, duration: float | None = None
    ) -> FastMarchingSkill[MotionT_co]:
        """A new skill that has also learned a path; its timing is the demonstrations'.

        Args:
            path: (n, d), at least two different points.
            duration: s, > 0; by default the demonstrations', adapted to the path's length.
        """
        points = check.frozen(path, "path", shape=("n", self._dimensions()))
        if len(points) < 2 or not np.ptp(points, axis=0).any():
            raise InvalidInput(
                "path: expected at least two different points, got a path that does not move"
            )
        if duration is not None:
            check.number(duration, "duration", above=0.0)
        orientations = None
        if self._has_orientations:
            orientations = orientations_along(self._all, np.ones(len(self._all)), path=points)
        new = experience.experience_like(self._all, points, orientations, duration=duration)
        return replace(self, learned=(*self.learned, new))

    def auto_learn(
        self, motion: Trajectory | PoseTrajectory, *, threshold: float = 0.6
    ) -> FastMarchingSkill[MotionT_co]:
        """The skill with a motion's path added, if its kappa is below the threshold.

        Otherwise the skill itself: the motion shows nothing new.

        Args:
            motion: such as one that the skill has generated.
            threshold: of `kappa`.
        """
        check.number(threshold, "threshold")
        check.instance(
            motion, "motion", Trajectory | PoseTrajectory, "a Trajectory or a PoseTrajectory"
        )
        if self.kappa(motion.positions) >= threshold:
            return self
        return self.with_experience(motion.positions, duration=motion.duration)

    def _answer(self, query: CheckedQuery) -> MotionT_co:
        route = self.plan(start=query.start, goal=query.goal, obstacles=query.obstacles)
        return self.in_time(
            route, start=query.start, goal=query.goal, duration=query.duration, dt=query.dt
        )

    def in_time(
        self,
        route: Route,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        duration: float | None = None,
        dt: float = 0.01,
    ) -> MotionT_co:
        """The motion along a route, as by `generate`.

        Args:
            route: from `plan` or a live map.
            start: the query's; only its orientation counts here.
            goal: the query's; only its orientation counts here.
            duration: s, > 0; by default the demonstrations', adapted to the path's length.
            dt: s, > 0, upper bound of the sampling step.
        """
        check.number(dt, "dt", above=0.0)
        wanted = None if duration is None else check.number(duration, "duration", above=0.0)
        ends = {
            name: split(self.demonstrated, value, name)[1]
            for name, value in (("start", start), ("goal", goal))
        }
        motion, covered = timed(route, timing=self.model.timing, duration=wanted, dt=dt)
        made: Trajectory | PoseTrajectory = motion
        if self._has_orientations:
            orientations = orientations_along(
                route.used, route.weights, path=route.path, fractions=covered, **ends
            )
            made = PoseTrajectory(
                motion.times, motion.positions, orientations, motion.events, motion.joints
            )
        return cast(MotionT_co, made)  # poses if poses were demonstrated

    def plan(
        self,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        obstacles: Sequence[Shape] = (),
    ) -> Route:
        """The path of `generate`, without a time law, and how it was planned.

        Arguments and errors are those of `generate`.
        """
        query = self.query(start=start, goal=goal, obstacles=obstacles)
        if start is None and goal is None and not query.obstacles:
            return self._nominal_route
        nominal = (lambda: self._nominal_route) if self.demonstrated else None
        return planned(
            self.model.method, self._all, query, partial(self._scales, query=query), nominal=nominal
        )

    def query(
        self,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        obstacles: Sequence[Shape] = (),
    ) -> Query:
        """Positions and obstacles as `plan` takes them, with defaults filled in."""
        return query_of(self.demonstrated, start, goal, check_shapes(obstacles))

    def live_map(self, workspace: ArrayLike, *, cells: int = 1_000_000) -> LiveMap:
        """Routes to goals and around obstacles that keep moving, in tens of milliseconds each.

        The routes lead through the map of the method "map"; `in_time` makes motions of them.

        Args:
            workspace: (lower, upper) corners (d,) each, around the demonstrations and all that
                moves.
            cells: into about how many it is divided, at least 1000.
        """
        corners = check.array(workspace, "workspace", shape=(2, self._dimensions()))
        count = check.integer(cells, "cells", at_least=1000)
        sides = np.maximum(corners[1] - corners[0], 0.0)
        edge = float((sides.prod() / count) ** (1.0 / len(sides)))
        space = (tuple(corners[0]), tuple(corners[1]))
        model = replace(self.model, method="map", workspace=space, resolution=edge)
        return LiveMap(self._all, replace(self, model=model)._map_scales)

    def preview(self) -> Preview[MotionT_co]:
        """Quick answers while goal and obstacles are dragged: plans, but for the method "map"."""
        return Preview(self)

    def policy(self, position: ArrayLike) -> Float64Array:
        """The velocity that leads from a position to the demonstrations' goal, without planning.

        After a push the tool rejoins the demonstrated path.

        Args:
            position: (d,), or rows (n, d).

        Returns:
            Velocity (d,), or (n, d), in the unit of the data per second.

        Raises:
            NoPath: far outside the demonstrations.
        """
        return self._policy(position)

    def step(self, position: ArrayLike, dt: float) -> Float64Array:
        """The position that `policy` leads to within dt, however long dt is in a control loop.

        Args:
            position: (d,), or rows (n, d).
            dt: s, in (0, 100].

        Returns:
            Position (d,), or (n, d), in the unit of the data.

        Raises:
            NoPath: far outside the demonstrations.
        """
        return self._policy.step(position, dt)

    def policy_to(
        self, goal: ArrayLike | None = None, *, obstacles: Sequence[Shape] = ()
    ) -> Policy:
        """A policy for a goal, among obstacles; its field is computed here, once.

        It goes by the map of all demonstrations, at the speed that they teach at each position.
        Where they cross themselves it takes the short cut: a position does not tell the phase. A
        motion that returns to its start goes round and ends four cells before it. While obstacles
        move, `policy.around(obstacles)` repairs the field.

        Args:
            goal: (d,), by default the centroid of the demonstrations' goals.
            obstacles: as in `generate`.

        Raises:
            InvalidInput: if the goal is of another shape, or outside a workspace that was set.
            NoPath: for a goal in an obstacle.
        """
        self._dimensions()
        asked = self.query(goal=goal, obstacles=obstacles)
        return policy_to(self._all, asked.goal, asked.obstacles, self._map_scales)

    def parameters(
        self,
        demonstrations: Demonstrations[Motion] = (),  # noqa: ARG002 (no fit is needed)
    ) -> Sequence[Parameter[MotionT_co]]:
        """Its saturation and, if it has a map, the radius of its tubes.

        Args:
            demonstrations: not needed, as nothing is fitted again.
        """
        result = [self._parameter("saturation", "saturation", *_SATURATIONS, _SATURATION_STEP)]
        if self.experience:
            least, most = (factor * self.area_of_influence for factor in _RADII)
            step = (most - least) / _RADIUS_STEPS
            label = "area of influence, m"
            result.append(self._parameter("area_of_influence", label, least, most, step))
        return result

    def _parameter(
        self, setting: str, label: str, least: float, most: float, step: float
    ) -> Parameter[MotionT_co]:
        """A setting of the model that a person may drag."""

        def changed(value: float) -> FastMarchingSkill[MotionT_co]:
            settings: dict[str, Any] = {setting: value}
            return replace(self, model=replace(self.model, **settings))

        value = self.area_of_influence if setting == "area_of_influence" else self.model.saturation
        return Parameter(label, value, least, most, step, changed)

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        settings = {
            **asdict(self.model),
            "shown": len(self.demonstrated),
            "learned": len(self.learned),
            "events": [plain_events(each.events) for each in self._all],
        }
        if any(each.posture for each in self._all):
            settings["joint_names"] = [e.posture and list(e.posture.names) for e in self._all]
        arrays = {
            f"{name}_{i}": value
            for i, each in enumerate(self._all)
            for name, value in each.arrays().items()
        }
        return settings, arrays

    def export(self, path: str | PathLike[str]) -> None:
        """Writes `policy_to()` as its `export` does."""
        self._policy.export(path)

    @property
    def _all(self) -> tuple[Experience, ...]:
        return self.demonstrated + self.learned

    @cached_property
    def _nominal_route(self) -> Route:
        scales = partial(self._scales, query=None)
        return planned(self.model.method, self._all, self.query(), scales)

    @cached_property
    def _policy(self) -> Policy:
        return self.policy_to()

    @cached_property
    def _map(self) -> tuple[Grid, Float64Array]:
        self._dimensions()
        grid, speed, _ = maps.map_of([each.denoised for each in self._all], self._map_scales)
        return grid, check.freeze(speed)

    @property
    def _map_scales(self) -> maps.Scales:
        self._dimensions()
        return self._scales(maps.MAP_RADIUS, None)

    def _scales(self, fraction: float, query: Query | None) -> maps.Scales:
        lengths = [each.length for each in self.demonstrated]
        if not lengths and query is not None:
            lengths = [float(np.linalg.norm(query.goal - query.start)) or 1.0]
        given, length = self.model.area_of_influence, float(np.mean(lengths))
        return maps.Scales(
            radius=given or fraction * length,
            clearance=given or maps.MAP_RADIUS * length,
            saturation=self.model.saturation,
            resolution=self.model.resolution,
            growth=1.0 if given else maps.GROWTH,
            workspace=self.model.workspace,
            obstacle_map=self.model.obstacle_map,
        )

    def _dimensions(self) -> int:
        if not self._all:
            raise InvalidInput(
                "skill: has no demonstration and no map; fit it to at least one demonstration"
            )
        return int(self._all[0].path.shape[1])

    @property
    def _has_orientations(self) -> bool:
        return bool(self._all) and self._all[0].orientations is not None


class Preview(Generic[MotionT_co]):
    """Answers of a skill while its query is dragged; made by `FastMarchingSkill.preview`."""

    def __init__(self, skill: FastMarchingSkill[MotionT_co]) -> None:
        self._skill = skill
        self._map: LiveMap | None = None

    @property
    def live_map(self) -> LiveMap | None:
        """The preview's map; None before the first answer and with another method than "map"."""
        return self._map

    def generate(
        self,
        *,
        start: Target | None = None,
        goal: Target | None = None,
        duration: float | None = None,
        dt: float = 0.04,
        obstacles: Sequence[Shape] = (),
    ) -> MotionT_co:
        """A motion as by `FastMarchingSkill.generate`, which documents arguments and errors."""
        skill = self._skill
        if skill.model.method != "map":
            return skill.generate(
                start=start, goal=goal, duration=duration, dt=dt, obstacles=obstacles
            )
        ends = skill.query(start=start, goal=goal).ends
        if self._map is None or not self._map.grid.contains(ends).all():
            self._map = skill.live_map(self._workspace(ends, obstacles), cells=_PREVIEW_CELLS)
        route = self._map.route(ends[0], ends[1], obstacles)
        return skill.in_time(route, start=start, goal=goal, duration=duration, dt=dt)

    def _workspace(
        self, ends: Float64Array, obstacles: Sequence[Shape]
    ) -> tuple[Float64Array, Float64Array]:
        """Corners (d,) around demonstrations, ends (2, d) and the middles of obstacles."""
        middles = [shape.position[None, : ends.shape[1]] for shape in obstacles]
        points = np.concatenate([*self._skill.experience, *middles, ends])
        lower, upper = points.min(axis=0), points.max(axis=0)
        margin = _ROOM_TO_DRAG * float((upper - lower).max())
        return lower - margin, upper + margin


def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> FastMarchingSkill:
    counts = [int(settings.pop(name)) for name in ("shown", "learned")]
    total = sum(counts)
    happened = settings.pop("events", [()] * total)
    names = settings.pop("joint_names", [None] * total)
    everything = tuple(
        Experience.from_arrays(arrays, i, happening=happened[i], joint_names=names[i])
        for i in range(total)
    )
    model = FastMarching(**settings)  # JSON keeps no tuples; the model makes them again
    return FastMarchingSkill(model, everything[: counts[0]], everything[counts[0] :])
