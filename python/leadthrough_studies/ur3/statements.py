"""General statements of Prados et al. 2023 on Fast Marching Learning, measured.

- `of_person`: the same bits again (3.6.1), the path asked for backwards (3.6.2), the straight line
  without experience (3.6.3), smoothness, random starts, the arrival times as a policy (3.7) and
  their minima (3.6.5), and a box that the planner is not told of (3.5).
- `of_mazes`: a path is found if and only if one exists.
- `of_tubes`: demonstrations dilated by flat discs and by balls (3.4, figures 12 and 13).
- `of_cells`: the cost of a march over the number of cells (3.6.6).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.ndimage import binary_dilation, label, minimum_filter

from leadthrough.check import Float64Array
from leadthrough.models import FastMarchingSkill
from leadthrough.motion import Trajectory
from leadthrough.planning import Grid, arrival_times, fm2_speed, plan
from leadthrough.preprocess import frechet_distance
from leadthrough.preprocess.resample import arc_length, by_arc_length
from leadthrough_studies import intervals, metrics
from leadthrough_studies.demonstrator import Teaching
from leadthrough_studies.study import Row, cpu_time, selected
from leadthrough_studies.ur3.setting import Setting
from leadthrough_studies.ur3.setups import SETUPS, WORKSPACE, Setup, demonstrations, table

_COMPARED = 200  # points of a path
_STARTS = 10
_ROOM = 0.02  # m, of a random start from obstacles
_PERIOD, _PERIODS = 0.5, 240  # s, steps of the policy
_ARRIVED = 1e-3  # m
_MAZE, _WALLS = (30, 30), 0.35  # cells, and the fraction of them that are walls
_PIECE = 0.01  # m, between which a path turns


def of_person(*, setup: int, setting: dict[str, Any], seed: int) -> list[Row]:
    """A row of one experiment as a person shows it."""
    place, shown = SETUPS[setup], demonstrations(setup, Teaching(), seed)
    model = Setting(**setting).model()
    skill = model.fit(shown)
    path, again = (_path(each, place.start, place) for each in (skill, model.fit(shown)))
    back = skill.plan(start=place.goal, goal=place.start, obstacles=place.obstacles()).path
    row = {
        "same_bits": int(path.tobytes() == again.tobytes()),
        "reversed_Frechet_m": frechet_distance(_even(path), _even(back)[::-1]),
        "turning_shown_rad": float(np.mean([_turning(each.motion) for each in shown])),
        "turning_made_rad": metrics.turning(path, step=_PIECE),
        "detour_without_experience": _detour(model.fit([]), place),
        "box_distance_untold_m": _untold(skill, place),
    }
    row |= _from_anywhere(skill, place, np.random.default_rng([seed, setup]))
    return [{"study": "statements", "setup": setup, "seed": seed, **row}]


def _path(skill: FastMarchingSkill, start: Any, place: Setup) -> Float64Array:
    return skill.plan(start=start, goal=place.goal, obstacles=place.obstacles()).path


def _even(path: Float64Array) -> Float64Array:
    return by_arc_length(path, _COMPARED)


def _turning(motion: Any) -> float:
    assert isinstance(motion, Trajectory)
    return metrics.turning(motion.positions, step=_PIECE)


def _detour(skill: FastMarchingSkill, place: Setup) -> float:
    """Length of the path without experience and obstacles, over the straight line's, less one."""
    straight = float(np.linalg.norm(np.subtract(place.goal, place.start)))
    path = skill.plan(start=place.start, goal=place.goal).path
    return float(arc_length(path)[-1]) / straight - 1.0


def _untold(skill: FastMarchingSkill, place: Setup) -> float | None:
    """Distance from the box of a path that is planned with the table only, m."""
    if place.box is None:
        return None
    path = skill.plan(start=place.start, goal=place.goal, obstacles=[table()]).path
    return float(place.boxes()[0].distance(_even(path)).min())


def _from_anywhere(skill: FastMarchingSkill, place: Setup, rng: np.random.Generator) -> Row:
    """How many of some random starts are led to the goal, by paths and by the policy."""
    last = WORKSPACE - skill.grid.spacing.max()
    drawn = rng.uniform(0.0, last, (50 * _STARTS, 3))
    free = np.min([each.distance(drawn) for each in place.obstacles()], axis=0) > _ROOM
    starts = drawn[free][:_STARTS]
    paths = [_path(skill, start, place) for start in starts]
    policy = skill.policy_to(place.goal, obstacles=place.obstacles())
    now = starts
    for _ in range(_PERIODS):
        now = policy.step(now, _PERIOD)
    left = np.linalg.norm(now - place.goal, axis=1)
    return {
        "starts": len(starts),
        "paths_at_the_goal": sum(bool(np.allclose(path[-1], place.goal)) for path in paths),
        "paths_through_obstacles": sum(_touches(path, place) for path in paths),
        "policy_at_the_goal": int((left < _ARRIVED).sum()),
        "other_minima": _other_minima(np.asarray(policy.arrival)),
    }


def _touches(path: Float64Array, place: Setup) -> bool:
    return bool(min(each.distance(path).min() for each in place.obstacles()) <= 0.0)


def _other_minima(times: Float64Array) -> int:
    """Reached cells with no earlier face neighbour, besides the goal's."""
    faces = np.zeros((3,) * times.ndim, dtype=bool)
    for axis in range(times.ndim):
        faces[tuple(slice(None) if i == axis else 1 for i in range(times.ndim))] = True
    faces[(1,) * times.ndim] = False
    earliest = minimum_filter(times, footprint=faces, mode="constant", cval=np.inf)
    return int((np.isfinite(times) & (earliest >= times)).sum()) - 1


def of_mazes(*, seed: int, count: int) -> list[Row]:
    """A row: random walls, whether cells connect start and goal, and whether a path is found."""
    rng, grid = np.random.default_rng(seed), Grid(np.zeros(2), 1.0, _MAZE)
    connected = found = agreeing = 0
    for _ in range(count):
        walls = rng.uniform(size=_MAZE) < _WALLS
        walls[0, 0] = walls[-1, -1] = False
        regions, _ = label(~walls)
        exists = regions[0, 0] == regions[-1, -1]
        answer = plan(fm2_speed(grid, walls, saturation=0.1), grid, (0, 0), np.subtract(_MAZE, 1))
        connected, found = connected + exists, found + answer.found
        agreeing += exists == answer.found
    counts = {"connected": connected, "found": found, "agreeing": agreeing}
    return [{"study": "mazes", "seed": seed, "mazes": count, **_plain(counts)}]


def _plain(counts: Row) -> Row:
    return {name: int(value) for name, value in counts.items()}


def of_tubes(*, pace: dict[str, Any], setting: dict[str, Any], seed: int) -> list[Row]:
    """A row: unconnected pieces of the demonstrations of experiment 4 dilated either way."""
    made = Setting(**setting)
    radius = round(made.area_of_influence / made.resolution)
    offsets = np.indices((2 * radius + 1,) * 3) - radius
    ball = (offsets**2).sum(axis=0) <= radius**2
    disc = ball & (offsets[2] == 0)
    cells = (round(WORKSPACE / made.resolution),) * 3
    shown = demonstrations(4, Teaching(**pace), seed)
    row = {"study": "tubes", "seed": seed, "demonstrations": len(shown)}
    for name, element in (("discs", disc), ("balls", ball)):
        row[name] = sum(_pieces(_cells(each.motion, made), cells, element) for each in shown)
    return [row]


def _cells(motion: Any, setting: Setting) -> Any:
    return np.round(motion.positions / setting.resolution).astype(int)


def _pieces(marked: Any, shape: tuple[int, ...], element: Any) -> int:
    """Connected pieces of the cells around marked ones."""
    low = marked.min(axis=0) - len(element)
    small = np.zeros(np.minimum(marked.max(axis=0) - low + len(element) + 1, shape), dtype=bool)
    small[tuple((marked - low).T)] = True
    return int(label(binary_dilation(small, element))[1])


def of_cells(*, setting: dict[str, Any], seed: int) -> list[Row]:
    """A row: processor time of a march through experiment 1's map."""
    skill = Setting(**setting).model().fit(demonstrations(1, Teaching(), seed))
    speed, goal = skill.velocity_map, skill.grid.cells_of(np.array([SETUPS[1].goal]))
    march_s = cpu_time(lambda: arrival_times(speed, goal))
    return [{"study": "cells", "cells": int(speed.size), "march_cpu_s": march_s}]


def tables(rows: list[Row]) -> dict[str, list[Row]]:
    """The tables of these rows by file stem; those without rows are left out."""
    found = {
        "statements": _statements(selected(rows, study="statements")),
        "mazes": _summed(selected(rows, study="mazes")),
        "tubes": _tubes(selected(rows, study="tubes")),
        "cells": [_without_study(row) for row in selected(rows, study="cells")],
    }
    return {name: lines for name, lines in found.items() if lines}


def _without_study(row: Row) -> Row:
    return {name: value for name, value in row.items() if name != "study"}


_COUNTED = (
    "same_bits",
    "starts",
    "paths_at_the_goal",
    "paths_through_obstacles",
    "policy_at_the_goal",
    "other_minima",
)
_MEASURED = ("reversed_Frechet_m", "turning_shown_rad", "turning_made_rad", "box_distance_untold_m")


def _statements(rows: list[Row]) -> list[Row]:
    """Sums and medians over persons by experiment, and over all."""
    numbers = sorted({row["setup"] for row in rows})
    lines = []
    for name, own in [*((n, selected(rows, setup=n)) for n in numbers), ("all", rows)]:
        if not own:
            continue
        line: Row = {"setup": name, "persons": len(own)}
        line |= {each: sum(row[each] for row in own) for each in _COUNTED}
        line["largest_detour"] = max(row["detour_without_experience"] for row in own)
        for each in _MEASURED:
            line |= over_persons(own, each)
        lines.append(line)
    return lines


def over_persons(rows: list[Row], column: str) -> Row:
    """Median of a column and its interval, where it is known for any."""
    values = [row[column] for row in rows if row[column] is not None]
    found = intervals.median(values) if values else dict.fromkeys(("median", "low", "high"))
    return {f"{column}_{name}": value for name, value in found.items()}


def _summed(rows: list[Row]) -> list[Row]:
    names = ("mazes", "connected", "found", "agreeing")
    return [{each: sum(row[each] for row in rows) for each in names}] if rows else []


def _tubes(rows: list[Row]) -> list[Row]:
    names = ("demonstrations", "discs", "balls")
    return [{each: sum(row[each] for row in rows) for each in names}] if rows else []
