"""Fast Marching Learning: demonstrations become a speed map, a wave in it gives the path.

Source: Prados et al. 2023, Appl. Sci. 13:2028, Algorithm 1, eqs. 6 and 7.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Generic, cast

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check, events
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.atomic import StrPath
from leadthrough.models import archive
from leadthrough.models.demonstrated import Demonstrations
from leadthrough.models.marching import orientation, route
from leadthrough.models.marching.live_map import LiveMap
from leadthrough.models.marching.policy import Policy
from leadthrough.models.marching.preview import Preview
from leadthrough.models.marching.route import Query, Route, Scales
from leadthrough.models.marching.shown import Shown, keep
from leadthrough.models.marching.time_law import TIMINGS, timed, usual_duration
from leadthrough.models.parameters import Parameter
from leadthrough.models.place import Place
from leadthrough.motion import Motion, MotionT, MotionT_co, PoseTrajectory, Trajectory
from leadthrough.planning.grid import Grid
from leadthrough.planning.speed_map import experience_map
from leadthrough.preprocess.resample import arc_length, by_arc_length
from leadthrough.shapes import Shape, check_shapes

METHODS = ("auto", "map", "start", "mean_path")

# Shares of the demonstrations' mean length, so that the unit of the data does not matter. The map
# of all demonstrations wants tubes that overlap, a tube around one path a thin one.
_MAP_RADIUS = 0.02
_TUBE_RADIUS = 0.01
# In three dimensions thin tubes need more cells than they are worth.
_GROWTH = 3.0
# A mean path is trusted where a demonstration's ends are nearer to start and goal than this share
# of the distance between these, or, for motions that return, of its own length. Farther off the
# demonstrations say little about the way, and bending them to it gives detours.
_NEAR_OF_DISTANCE = 0.5
_NEAR_OF_LENGTH = 0.1
# What a slider of the tubes' radius goes to, in multiples of the present one.
_RADII_WORTH_TRYING = (0.4, 4.0)
# Points at which kappa looks the map up, at the most; two a cell otherwise.
_MOST_KAPPA_STEPS = 100_000


@dataclass(frozen=True)
class FastMarching:
    """Fast Marching Learning of point-to-point motions in two or three dimensions.

    area_of_influence: radius of the tubes around paths in the demonstrations' unit, > 0; by
    default 0.02 of their mean length for "map", 0.01 otherwise. saturation: speed outside the
    tubes, in (0, 1]; with "map" and "start" small values follow the demonstrations closely and
    large ones cut corners; "mean_path" allows no short cuts. resolution: edge of a cell in the
    same unit, > 0; by default a fifth of the radius. workspace: (lower, upper) corners (d,) each,
    which no path leaves and the map fills; by default there is room around the demonstrations.
    method: "map", all demonstrations in one map, Algorithm 1; "start", those that start near;
    "mean_path", a tube around the path that they predict; "auto", the last where start and goal
    lie near a demonstration's ends, otherwise the first.
    timing: "demonstrations", their mean progress along the path; "speed_map", speed proportional
    to the map's; "constant". All start and end at rest.
    """

    area_of_influence: float | None = None
    saturation: float = 0.02
    resolution: float | None = None
    method: str = "auto"
    timing: str = "demonstrations"
    workspace: tuple[tuple[float, ...], tuple[float, ...]] | None = None

    def __post_init__(self) -> None:
        check.number(self.saturation, "saturation", above=0.0, at_most=1.0)
        for name in ("area_of_influence", "resolution"):
            if getattr(self, name) is not None:
                check.number(getattr(self, name), name, above=0.0)
        check.choice(self.method, "method", METHODS)
        check.choice(self.timing, "timing", TIMINGS)
        if self.workspace is not None:
            corners = check.array(self.workspace, "workspace", shape=(2, "d"))
            if not (corners[0] < corners[1]).all():
                raise InvalidInput(f"workspace: expected lower < upper corners, got {corners}")
            plain = tuple(tuple(float(x) for x in corner) for corner in corners)
            object.__setattr__(self, "workspace", plain)

    def fit(self, demonstrations: Demonstrations[MotionT]) -> FastMarchingSkill[MotionT]:
        """A skill from demonstrations: all a Trajectory in two or three dimensions, or all poses.

        Without any, the skill goes the shortest way. Raises InvalidInput for other motions,
        FitError for one that does not move.
        """
        return FastMarchingSkill(self, keep(demonstrations))


@dataclass(frozen=True, eq=False)
class FastMarchingSkill(Generic[MotionT_co]):
    """What was learned; made by `FastMarching.fit`.

    model: its parameters. shown: the demonstrations. learned: paths that were added since.
    """

    model: FastMarching
    shown: tuple[Shown, ...]
    learned: tuple[Shown, ...] = ()

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

    def kappa(self, path: ArrayLike) -> float:
        """Mean of the velocity map along a path (n, d), eq. 6: 1 deep in the experience.

        Taken evenly over the path's length, so that pauses do not count. Never below the
        saturation, which holds outside the map. Raises InvalidInput.
        """
        given = check.array(path, "path", shape=("n", self._dimensions()))
        if len(given) == 0:
            raise InvalidInput("path: expected at least one point, got none")
        steps = 2.0 * float(arc_length(given)[-1]) / float(self.grid.spacing.min())
        points = by_arc_length(given, int(min(np.ceil(steps), _MOST_KAPPA_STEPS)) + 2)
        inside = self.grid.contains(points)
        speeds = np.full(len(points), self.model.saturation)
        speeds[inside] = self.velocity_map[tuple(self.grid.cells_of(points[inside]).T)]
        return float(speeds.mean())

    def with_experience(
        self, path: ArrayLike, *, duration: float | None = None
    ) -> FastMarchingSkill[MotionT_co]:
        """A new skill that has also learned a path (n, d), n >= 2.

        duration: s, > 0; by default the demonstrations', adapted to its length. Its timing is the
        demonstrations'. Raises InvalidInput.
        """
        points = check.frozen(path, "path", shape=("n", self._dimensions()))
        if len(points) < 2 or not np.ptp(points, axis=0).any():
            raise InvalidInput("path: expected at least two different points")
        if duration is not None:
            check.number(duration, "duration", above=0.0)
        weights = np.ones(len(self._all))
        progress = np.mean([each.progress for each in self._all], axis=0)
        length = float(arc_length(points)[-1])
        turned = None
        if self._has_orientations:
            shares = arc_length(points) / length
            turned = orientation.along(self._all, weights, start=None, goal=None, shares=shares)
        own = duration or usual_duration(self._all, weights, length)
        happened = events.agreed([each.events for each in self._all])
        added = Shown(points, own, progress, turned, happened)
        return replace(self, learned=(*self.learned, added))

    def auto_learn(
        self, motion: Trajectory | PoseTrajectory, *, threshold: float = 0.6
    ) -> FastMarchingSkill[MotionT_co]:
        """The skill with the motion's path added if its kappa is below the threshold.

        Otherwise the skill itself: the motion shows nothing new. Raises InvalidInput.
        """
        check.number(threshold, "threshold")
        if not isinstance(motion, Trajectory | PoseTrajectory):
            got = type(motion).__name__
            raise InvalidInput(f"motion: expected a Trajectory or a PoseTrajectory, got {got}")
        if self.kappa(motion.positions) >= threshold:
            return self
        return self.with_experience(motion.positions, duration=motion.duration)

    def generate(
        self,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
        obstacles: Sequence[Shape] = (),
    ) -> MotionT_co:
        """A motion of the type that was shown, around obstacles.

        A Trajectory, or a PoseTrajectory where poses were shown.
        start, goal: (d,), by default the centroids of the demonstrations' ends; for poses also
        (position (3,), orientation (4,)), by default as demonstrated. duration: s, > 0, by default
        theirs, adapted to the path's length. dt: s, upper bound of the sampling step. obstacles:
        shapes in the demonstrations' frame; a drawing of two dimensions lies in the plane z = 0.
        The motion starts and ends at rest. Raises InvalidInput, NoPath.
        """
        first, last = self.ends_of(start, goal)
        found = self.plan(start=first, goal=last, obstacles=obstacles)
        return self.in_time(found, start=start, goal=goal, duration=duration, dt=dt)

    def ends_of(self, start: Place | None, goal: Place | None) -> Float64Array:
        """Positions (2, d) of the start and goal of a query, by default as `generate` takes them.

        Raises InvalidInput.
        """
        first = self._end(self._pose(start, "start")[0], "start", 0)
        last = self._end(self._pose(goal, "goal")[0], "goal", -1)
        if len(first) != len(last):
            raise InvalidInput(f"goal: expected shape {first.shape}, got {last.shape}")
        return np.stack([first, last])

    def in_time(
        self,
        found: Route,
        *,
        start: Place | None = None,
        goal: Place | None = None,
        duration: float | None = None,
        dt: float = 0.01,
    ) -> MotionT_co:
        """The motion along a route, as by `generate`; start and goal count by their orientations.

        Raises InvalidInput.
        """
        check.number(dt, "dt", above=0.0)
        wanted = None if duration is None else check.number(duration, "duration", above=0.0)
        turns = [self._pose(value, name)[1] for value, name in ((start, "start"), (goal, "goal"))]
        motion, shares = timed(found, timing=self.model.timing, duration=wanted, dt=dt)
        made: Trajectory | PoseTrajectory = motion
        if self._has_orientations:
            turned = orientation.along(
                found.used, found.weights, start=turns[0], goal=turns[1], shares=shares
            )
            made = PoseTrajectory(motion.times, motion.positions, turned, motion.events)
        return cast(MotionT_co, made)  # poses where poses were shown

    def plan(
        self,
        *,
        start: ArrayLike | None = None,
        goal: ArrayLike | None = None,
        obstacles: Sequence[Shape] = (),
    ) -> Route:
        """The path of `generate`, without a time law, and how it was found.

        Raises InvalidInput, NoPath.
        """
        shapes = check_shapes(obstacles)
        first, last = self.ends_of(start, goal)
        query = Query(first, last, shapes)
        method = self.model.method
        if not self._all or method == "map" or (method == "auto" and not self._is_near(query)):
            return route.through_map(self._all, query, self._scales(_MAP_RADIUS, query))
        find = route.from_start if method == "start" else route.along_mean
        return find(self._all, query, self._scales(_TUBE_RADIUS, query))

    def live_map(self, workspace: ArrayLike, *, cells: int = 1_000_000) -> LiveMap:
        """Routes to goals and around obstacles that keep moving, in tens of milliseconds each.

        workspace: (lower, upper) corners (d,) each, around the demonstrations and all that moves.
        cells: into about how many it is divided. The routes are those of the method "map";
        `in_time` makes motions of them. Raises InvalidInput.
        """
        corners = check.array(workspace, "workspace", shape=(2, self._dimensions()))
        count = check.integer(cells, "cells", at_least=1000)
        lengths = np.maximum(corners[1] - corners[0], 0.0)
        edge = float((lengths.prod() / count) ** (1.0 / len(lengths)))
        space = (tuple(corners[0]), tuple(corners[1]))
        model = replace(self.model, method="map", workspace=space, resolution=edge)
        return LiveMap(self._all, replace(self, model=model)._map_scales)

    def preview(self) -> Preview[MotionT_co]:
        """Answers in tens of milliseconds, coarser where it has to be, while things are dragged."""
        return Preview(self)

    def policy(self, position: ArrayLike) -> Float64Array:
        """The velocity (d,) that leads from a position (d,) to the demonstrations' goal.

        In the unit of the data per second, without planning again: after a push the tool joins the
        demonstrated way anew. Raises InvalidInput; NoPath far outside the demonstrations.
        """
        return self._policy(position)

    def policy_to(
        self, goal: ArrayLike | None = None, *, obstacles: Sequence[Shape] = ()
    ) -> Policy:
        """A policy for a goal (d,) and among obstacles; what it needs is computed here, once.

        It goes by the map of all demonstrations, at their mean speed, slower near the goal. Where
        they cross themselves it takes the short cut: a place does not tell how far the task is.
        Raises InvalidInput, NoPath for a goal in an obstacle.
        """
        self._dimensions()
        end = self._end(goal, "goal", -1)
        scales = self._map_scales
        grid, arrival = route.field_to(self._all, end, check_shapes(obstacles), scales)
        pace = float(np.mean([each.length / each.duration for each in self._all]))
        return Policy(grid, arrival, end, pace, scales.radius)

    @cached_property
    def _policy(self) -> Policy:
        return self.policy_to()

    def parameters(
        self,
        demonstrations: Demonstrations[Motion] = (),  # noqa: ARG002 (no fit is needed)
    ) -> Sequence[Parameter[MotionT_co]]:
        """Its saturation and, where there is a map, the radius of its tubes."""
        saturation = self.model.saturation
        found = [Parameter("saturation", saturation, 0.005, 0.5, 0.005, self._with("saturation"))]
        if self._all:
            radius = self.area_of_influence
            least, most = (share * radius for share in _RADII_WORTH_TRYING)
            step, apply = (most - least) / 100.0, self._with("area_of_influence")
            found.append(Parameter("area of influence, m", radius, least, most, step, apply))
        return found

    def _with(self, setting: str) -> Callable[[float], FastMarchingSkill[MotionT_co]]:
        """Takes a value of a setting of the model and returns the skill with it."""

        def changed(value: float) -> FastMarchingSkill[MotionT_co]:
            settings: dict[str, Any] = {setting: value}
            return replace(self, model=replace(self.model, **settings))

        return changed

    def save(self, path: StrPath) -> None:
        """Writes the skill to a .npz file that `load_skill` reads. Raises InvalidInput."""
        archive.write(path, self.kind, *self.to_archive())

    def to_archive(self) -> tuple[dict[str, Any], archive.Arrays]:
        """Settings and arrays that `from_archive` puts together again."""
        settings = {
            **asdict(self.model),
            "shown": len(self.shown),
            "learned": len(self.learned),
            "events": [events.to_plain(each.events) for each in self._all],
        }
        arrays = {
            f"{name}_{i}": value
            for i, each in enumerate(self._all)
            for name, value in each.arrays().items()
        }
        return settings, arrays

    @classmethod
    def from_archive(cls, settings: dict[str, Any], arrays: archive.Arrays) -> FastMarchingSkill:
        """The skill that `save` took apart. Raises KeyError, TypeError, ValueError."""
        counts = [int(settings.pop(name)) for name in ("shown", "learned")]
        total = sum(counts)
        happened = settings.pop("events", [()] * total)
        everything = [
            replace(Shown.from_arrays(arrays, i), events=events.from_plain(happened[i]))
            for i in range(total)
        ]
        model = FastMarching(**settings)  # JSON keeps no tuples; the model makes them again
        return cls(model, tuple(everything[: counts[0]]), tuple(everything[counts[0] :]))

    @property
    def _all(self) -> tuple[Shown, ...]:
        return self.shown + self.learned

    @cached_property
    def _map(self) -> tuple[Grid, Float64Array]:
        self._dimensions()
        grid, scales = route.grid_over(self.experience, (), self._map_scales)
        speed = experience_map(
            grid,
            self.experience,
            area_of_influence=scales.radius,
            saturation=scales.saturation,
        )
        speed.setflags(write=False)
        return grid, speed

    @property
    def _map_scales(self) -> Scales:
        self._dimensions()
        return self._scales(_MAP_RADIUS, None)

    def _scales(self, share: float, query: Query | None) -> Scales:
        lengths = [each.length for each in self.shown]
        if not lengths and query is not None:
            lengths = [float(np.linalg.norm(query.goal - query.start)) or 1.0]
        given = self.model.area_of_influence
        length = float(np.mean(lengths))
        return Scales(
            radius=given or share * length,
            clearance=given or _MAP_RADIUS * length,
            saturation=self.model.saturation,
            resolution=self.model.resolution,
            growth=1.0 if given else _GROWTH,
            workspace=self.model.workspace,
        )

    def _dimensions(self) -> int:
        if not self._all:
            raise InvalidInput("skill: was fitted to no demonstration and has no map")
        return int(self._all[0].path.shape[1])

    def _end(self, value: ArrayLike | None, name: str, index: int) -> Float64Array:
        if self._all:
            if value is None:
                return np.asarray(np.mean([each.path[index] for each in self.shown], axis=0))
            return check.array(value, name, shape=(self._dimensions(),))
        if value is None:
            raise InvalidInput(f"{name}: expected a point, as there is no demonstration")
        point = check.array(value, name, shape=("d",))
        if len(point) not in (2, 3):
            raise InvalidInput(f"{name}: expected 2 or 3 coordinates, got {len(point)}")
        return point

    @property
    def _has_orientations(self) -> bool:
        return bool(self._all) and self._all[0].orientations is not None

    def _pose(self, value: Any, name: str) -> tuple[Any, Float64Array | None]:
        """A query's position, and its orientation if it has one."""
        if not self._has_orientations or not isinstance(value, tuple | list) or len(value) != 2:
            return value, None
        return value[0], check.quaternions(value[1], name, shape=(4,))

    def _is_near(self, query: Query) -> bool:
        distance = float(np.linalg.norm(query.goal - query.start))
        for each in self._all:
            path = each.facing(query.start, query.goal).path
            gaps = np.linalg.norm(path[[0, -1]] - query.ends, axis=1)
            if gaps.max() <= max(_NEAR_OF_DISTANCE * distance, _NEAR_OF_LENGTH * each.length):
                return True
        return False
