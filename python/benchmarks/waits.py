"""What a person waits for: plans past boxes and from far away, pages, whole commands.

The default Fast Marching Learning on five noisy demonstrations of 0.6 m, fitted anew for each plan
so that nothing is known from the one before. Times are processor times, of all threads.
Answers are checked before their times count: each plan ends at the goal and keeps clear of its
obstacles. In random scenes the path in the band is compared with that of a march of all cells.
"""

from __future__ import annotations

import importlib.util
import json
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import asdict, dataclass
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any, Literal

import numpy as np

import leadthrough as lt
from leadthrough.check import Float64Array
from leadthrough.planning import Grid, arrival_times, descend
from leadthrough.planning.speed_map import (
    DetourField,
    ExperienceField,
    ObstacleField,
    SpeedField,
    TubeField,
    Walls,
    quickest,
)
from leadthrough.preprocess import dtw_distance, frechet_distance
from leadthrough.preprocess.resample import by_arc_length
from leadthrough.show.replanner import Replanner

LENGTH = 0.6  # m
SCENES = 200
MAX_APART = 0.5  # cells
DRAGS = 100
LOADS, FRAMES = 5, 600  # of a page from disk
# Each goes on from the files of those before.
COMMANDS = (
    "--help",
    "clean recorded/reach1.csv -o cleaned.csv",
    "info recorded",
    "learn recorded -o skill.npz",
    "plan skill.npz -o tip.csv",
    "plan skill.npz --robot ur3.urdf -o joints.csv",
    "retime joints.csv -o timed.csv",
    "check timed.csv",
    "guard timed.csv -o guarded.csv",
    "view timed.csv --html view.html",
    "--help",
)
# Of the demonstrations in the plane, so far from the origin that a start 600 m away is no slip of
# units, which would be refused.
PLACE = np.array([40.0, 0.3])
AROUND = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)


@dataclass(frozen=True)
class Row:
    """Times of one kind of wait.

    Attributes:
        name: of the call.
        count: how many times were taken.
        median: of them, ms.
        worst: of them, ms.
        most: that it may take, ms; None: no limit is set.
        limited: the figure that must keep the limit, the median or the worst.
        wrong: faults of the answers; empty if there are none.
    """

    name: str
    count: int
    median: float
    worst: float
    most: float | None = None
    limited: Literal["median", "worst"] = "worst"
    wrong: str = ""

    @property
    def holds(self) -> bool:
        """Whether the answers are right and keep the limit."""
        taken = self.median if self.limited == "median" else self.worst
        return not self.wrong and (self.most is None or taken <= self.most)


def run(out: Path, *, quick: bool) -> bool:
    """Prints the table and writes it to waits.json; returns whether all rows hold.

    Args:
        out: folder to write to.
        quick: look at a tenth of the scenes.
    """
    print("| wait | times | median, ms | worst, ms | at most, ms |")
    print("|---|---|---|---|---|")
    found = []
    every = (*rows(SCENES // 10 if quick else SCENES), *_drags(), *_computations(), *_commands())
    for row in every:
        found.append(row)
        print(_text(row), flush=True)
    out.mkdir(parents=True, exist_ok=True)
    (out / "waits.json").write_text(json.dumps([asdict(row) for row in found], indent=2))
    return all(row.holds for row in found)


def rows(scenes: int) -> Iterator[Row]:
    """The rows of the table, with so many random scenes."""
    shown = demonstrations(3)
    box = lt.Box((0.06, 0.06, 0.3), shown[0].motion.at(1.5))
    yield _plans("in space, without obstacles", shown, [{}], most=50.0)
    yield _plans("in space, past a box", shown, [{"obstacles": [box]}], most=100.0)
    afar = [{"start": 5.0 * each} for each in directions(3)]
    yield _plans("in space, from 5 m away", shown, afar, most=150.0)
    both = [{**each, "obstacles": [box]} for each in afar]
    yield _plans("in space, from 5 m away and past a box", shown, both, most=150.0)
    flat = [{"start": PLACE + 1000.0 * LENGTH * each} for each in directions(2)]
    yield _plans("in the plane, from 1,000 lengths away", demonstrations(2), flat, most=50.0)
    yield from _learning()
    yield from _random_scenes(scenes)


def demonstrations(dimensions: int) -> list[lt.Demonstration[Any]]:
    """Five noisy demonstrations of an arc."""
    rng = np.random.default_rng(5)
    times = np.linspace(0.0, 3.0, 200)
    s = lt.trajectories.minimum_jerk_time_scaling(times / 3.0)
    arc = np.column_stack([0.56 * s - 0.28, 0.1 * np.sin(np.pi * s), 0.1 * s])[:, :dimensions]
    if dimensions == 2:
        arc = arc + PLACE
    return [
        lt.Demonstration(lt.Trajectory(times, arc + rng.normal(0.0, 0.005, dimensions)))
        for _ in range(5)
    ]


def directions(dimensions: int) -> Float64Array:
    """Unit vectors (24, d) all around."""
    around = np.column_stack([np.cos(AROUND), np.sin(AROUND)])
    if dimensions == 2:
        return around
    height = np.sin(5.0 * AROUND)
    return np.column_stack([around * np.sqrt(1.0 - height**2)[:, None], height])


def _learning(repeats: int = 5) -> Iterator[Row]:
    """The choice of a family, its fit and a query, of eight strokes of 200 samples."""
    u, rng = np.linspace(0.0, 1.0, 200), np.random.default_rng(0)
    hump = np.column_stack([u, 0.3 * np.sin(np.pi * u)])
    offsets = rng.normal(0.0, 0.05, (8, 2)), rng.normal(0.0, 0.03, (8, 1))
    shown = [
        lt.Trajectory(2.0 * u, hump * (1.0 + wide) + (1.0 - u)[:, None] ** 2 * off)
        for off, wide in zip(*offsets, strict=True)
    ]
    skill = lt.AlignedMean().fit(shown)
    start = shown[0].positions[0]
    calls: tuple[tuple[str, Callable[[], Any], float], ...] = (
        ("lt.learn, eight demonstrations", lambda: lt.learn(list(map(copy, shown))), 1000.0),
        ("AlignedMean, the same: fit", lambda: lt.AlignedMean().fit(list(map(copy, shown))), 60.0),
        ("AlignedMean, the same: query", lambda: skill.generate(start=start), 5.0),
    )
    wrong = "" if np.allclose(skill.generate(start=start).positions[0], start) else "another start"
    for name, call, most in calls:
        call()
        taken = []
        for _ in range(repeats):
            begin = time.process_time()
            call()
            taken.append(1e3 * (time.process_time() - begin))
        yield Row(
            name, repeats, statistics.median(taken), max(taken), most, limited="median", wrong=wrong
        )


def _plans(
    name: str,
    shown: Sequence[lt.Demonstration[Any]],
    queries: Sequence[dict[str, Any]],
    *,
    most: float,
    repeats: int = 5,
) -> Row:
    """The row of plans for queries; of each query's repetitions the median counts."""
    times, wrong = [], ""
    for query in queries:
        again = []
        for _ in range(repeats):
            begin = time.process_time()
            motion = lt.FastMarching().fit(shown).generate(**query)
            again.append(1e3 * (time.process_time() - begin))
        times.append(statistics.median(again))
        wrong = wrong or _fault(motion.positions, shown, query)
    return Row(name, len(times), statistics.median(times), max(times), most, wrong=wrong)


def _fault(
    path: Float64Array, shown: Sequence[lt.Demonstration[Any]], query: dict[str, Any]
) -> str:
    """Faults of a planned path (n, d); empty if there are none."""
    usual = np.mean([each.motion.positions[[0, -1]] for each in shown], axis=0)
    ends = np.stack([query.get("start", usual[0]), usual[1]])
    if not np.allclose(path[[0, -1]], ends, atol=1e-9):
        return f"it leads from {path[0]} to {path[-1]}"
    clear = _clearance(path, query.get("obstacles", ()))
    return "" if clear > 0.0 else f"it touches an obstacle by {-clear:.3g} m"


def _clearance(path: Float64Array, obstacles: Sequence[lt.Shape]) -> float:
    """The least distance of a path (n, d) from obstacles, looked at every 0.2 mm near them."""
    if not obstacles:
        return np.inf
    points = np.zeros((len(path), 3))
    points[:, : path.shape[1]] = path
    near = points[np.abs(points).max(axis=1) < 1.0]
    steps = np.linalg.norm(np.diff(near, axis=0), axis=1).sum()
    even = by_arc_length(near, 2 + int(steps / 2e-4))
    return min(float(each.distance(even).min()) for each in obstacles)


def _random_scenes(count: int) -> Iterator[Row]:
    """Paths in the band, and the marches of all cells that they are compared with."""
    times: dict[Callable[..., Float64Array], list[float]] = {quickest: [], of_all_cells: []}
    apart, wrong = [], ""
    for seed in range(count):
        field, way, obstacles = scene(seed)
        paths = []
        for planned, taken in times.items():
            begin = time.process_time()
            paths.append(planned(field, way[0], way[-1]))
            taken.append(1e3 * (time.process_time() - begin))
        even = (by_arc_length(each, 2000) for each in paths)
        apart.append(frechet_distance(*even) / float(field.grid.spacing.max()))
        if apart[-1] > MAX_APART:
            wrong = wrong or f"scene {seed}: {apart[-1]:.2f} cells apart"
        if _clearance(paths[0], obstacles) <= 0.0:
            wrong = wrong or f"scene {seed}: through a wall"
    name = f"in {count} random scenes, at most {max(apart):.1g} cells from a march of all cells"
    for planned, label in ((quickest, name), (of_all_cells, "the same by a march of all cells")):
        taken = times[planned]
        yield Row(label, count, statistics.median(taken), max(taken), wrong=wrong)


def of_all_cells(field: SpeedField, start: Float64Array, goal: Float64Array) -> Float64Array:
    """The quickest path by a march of all cells, as long as no map is shared between queries."""
    grid = field.grid
    speed = field.at(np.arange(np.prod(grid.shape))).reshape(grid.shape)
    first, source = grid.cells_of(np.stack([start, goal]))
    arrival = arrival_times(speed, source, spacing=grid.spacing, order=2, stop=first)
    return descend(arrival, grid, start, goal)


def scene(seed: int) -> tuple[SpeedField, Float64Array, list[lt.Shape]]:
    """A random way (n, d) among three obstacles, and the speeds that both kinds of plan march in.

    Every other scene is of two dimensions; the pairs take turns with the tube of a mean path and
    the map of demonstrations with ways round what stands in it.
    """
    rng = np.random.default_rng(seed)
    dimensions = 2 + seed % 2
    u = np.linspace(0.0, 1.0, 200)[:, None]
    waves = rng.normal(0.0, 1.0, (3, dimensions)) * [[0.15], [0.08], [0.05]]
    way = u * rng.uniform(0.2, 0.5, dimensions)
    way = way + sum(wave * np.sin(np.pi * k * u) for k, wave in enumerate(waves, 1))
    obstacles = _obstacles(way, rng)
    grid = Grid.covering(way, margin=0.15, spacing=0.004 if dimensions == 2 else 0.009)
    walls = Walls(grid, obstacles)
    radius = float(rng.choice([0.02, 0.15]))
    if seed // 2 % 2:
        free = ExperienceField(grid, [way], area_of_influence=radius, saturation=0.02)
        field: SpeedField = DetourField(free, walls, band=0.01, reach=0.04)
    else:
        tube = TubeField(grid, [way], [1.0], area_of_influence=radius, saturation=0.02)
        field = ObstacleField(tube, walls, area_of_influence=0.015)
    return field, way, obstacles


def _obstacles(way: Float64Array, rng: np.random.Generator) -> list[lt.Shape]:
    """A box, a sphere and a cylinder on a way (n, d), clear of its ends."""
    places = np.zeros((3, 3))
    places[:, : way.shape[1]] = way[rng.integers(40, 160, 3)] + rng.normal(0.0, 0.02, way.shape[1])
    turn = rng.uniform(0.0, np.pi)
    shapes = [
        lt.Box(rng.uniform(0.02, 0.1, 3), places[0], (np.cos(turn), 0.0, 0.0, np.sin(turn))),
        lt.Sphere(rng.uniform(0.02, 0.05), places[1]),
        lt.Cylinder(rng.uniform(0.01, 0.04), 0.1, places[2]),
    ]
    ends = np.zeros((2, 3))
    ends[:, : way.shape[1]] = way[[0, -1]]
    return [each for each in shapes if float(each.distance(ends).min()) > 0.03]


def _drags() -> Iterator[Row]:
    """The time from the mouse to the scene on the live page; none without a browser."""
    needed = ("playwright", "websockets")
    if not shutil.which("chromium") or not all(map(importlib.util.find_spec, needed)):
        print("the live page was left out: it takes Chromium, Playwright and websockets to measure")
        return
    yield from _page()
    yield _first_previews()
    live_drag = importlib.import_module("live_drag")
    taken = live_drag.latencies(DRAGS)
    name = "on the live page, from the mouse to path and arm (wall time)"
    wrong = "" if len(taken) > DRAGS // 2 else f"{len(taken)} of {DRAGS} moves were answered"
    yield Row(
        name, len(taken), statistics.median(taken), max(taken), 80.0, limited="median", wrong=wrong
    )


def _first_previews() -> Row:
    """The first preview after the box has been dragged to where it is in the arm's way."""
    live_drag = importlib.import_module("live_drag")
    skill = lt.FastMarching().fit(live_drag.demonstrations())
    taken, wrong = [], ""
    for place in product((0.25, 0.35), (-0.15, 0.0, 0.15), np.linspace(0.4, 0.7, 4)):
        planner = Replanner(lt.Arm.load("panda"), skill, scene=[live_drag.BOX])
        planner.plan()
        planner.move_obstacle(0, place)
        begin = time.process_time()
        answer = planner.preview()
        taken.append(1e3 * (time.process_time() - begin))
        if answer.joints is not None:
            report = planner.arm.check(answer.joints, planner.obstacles)
            wrong = wrong or ("" if report.ok else str(report))
    name = "the first preview with a box in the arm's way, found or not"
    return Row(name, len(taken), statistics.median(taken), max(taken), 80.0, "median", wrong)


def _page() -> Iterator[Row]:
    """The first paint of a page from disk, and the time from frame to frame while it plays."""
    paints, frames = importlib.import_module("page_times").of_a_scene(LOADS, FRAMES)
    name = "first paint of a page with a scene, from disk (wall time)"
    yield Row(name, len(paints), statistics.median(paints), max(paints), 1500.0, limited="median")
    name = "frame to frame while it plays, 1200 x 800, drawn in software (wall time)"
    yield Row(name, len(frames), statistics.median(frames), max(frames), 17.0, limited="median")


def _computations() -> Iterator[Row]:
    """Processor times of single calls."""
    a, b = np.random.default_rng(0).normal(size=(2, 1000, 2))
    for distance in (dtw_distance, frechet_distance):
        name = f"`preprocess.{distance.__name__}` of two curves of 1,000 points"
        yield _timed(name, partial(distance, a, b), most=50.0)
    times = np.linspace(0.0, 3.0, 301)
    rest = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])
    motion = lt.JointTrajectory(times, rest + 0.3 * np.sin(times)[:, None] ** 3)
    simulated = partial(lt.simulate, lt.Arm.load("panda"), motion)
    yield _timed("`simulate`, 3 s of a Panda", simulated, most=300.0)


def _timed(name: str, call: Callable[[], object], *, most: float) -> Row:
    call()
    taken = []
    for _ in range(5):
        begin = time.process_time()
        call()
        taken.append(1e3 * (time.process_time() - begin))
    return Row(name, len(taken), statistics.median(taken), max(taken), most, "median")


def _commands() -> Iterator[Row]:
    """The processor time of whole commands, Python's start included, on an example."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "reach"
        _command(["example", "reach", str(folder)], folder.parent)
        for line in COMMANDS:
            words = line.split()
            taken = [_command(words, folder) for _ in range(3)]
            yield Row(
                f"`leadthrough {line}`", 3, statistics.median(taken), max(taken), 700.0, "median"
            )


def _command(words: list[str], folder: Path) -> float:
    """Processor time of a command run in a folder, ms."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    code = "import sys; from leadthrough.cli import main; main()"
    subprocess.run(
        [sys.executable, "-c", code, *words], cwd=folder, check=True, capture_output=True
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return 1e3 * (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def _text(row: Row) -> str:
    limit = "" if row.most is None else f"{row.most:.0f} ({row.limited})"
    text = f"| {row.name} | {row.count} | {row.median:.0f} | {row.worst:.0f} | {limit} |"
    return text if row.holds else f"{text} {row.wrong or 'TOO SLOW'}"
