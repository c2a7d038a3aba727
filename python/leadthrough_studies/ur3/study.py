"""The workspace study: a UR3 beside a table, five experiments of Prados et al. 2023, section 4.2.

`setups` states what is assumed where the paper leaves something open. The setting is the paper's:
cells of 1 cm, area of influence of 5 cells, saturation 0.25; paths with kappa below 0.6 are
learned. `plan_motion` takes the whole arm along every path, 5 mm clear of the table and the box,
continuously between samples, and clear of itself; the rows report how far the tip leaves its path
for that. Ten seeds of the simulated person show what of this is chance, with the product of both
maps around obstacles and with the paper's eq. 7. `statements` measures the paper's general ones;
`maps` those on FM and FM^2, and draws figures 2 to 5 and 12 to 15.

The paper prints values of kappa below its saturation of 0.25. The mean of a map with values in
[0.25, 1], eq. 6, cannot be that low. So the rows state three values: of the map of the raw
experience, which decides; of that map before it is rescaled to [saturation, 1]; and of the map with
obstacles.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from leadthrough.check import Float64Array
from leadthrough.models import FastMarchingSkill
from leadthrough.motion import Demonstration, Trajectory
from leadthrough.preprocess.resample import arc_length, by_arc_length
from leadthrough.shapes import Shape
from leadthrough_studies import metrics, physics
from leadthrough_studies.demonstrator import Teaching
from leadthrough_studies.metrics import speed_along
from leadthrough_studies.study import Row, Study, Task, cpu_time
from leadthrough_studies.ur3 import maps, statements
from leadthrough_studies.ur3.on_the_arm import on_the_arm
from leadthrough_studies.ur3.report import report
from leadthrough_studies.ur3.setting import Setting
from leadthrough_studies.ur3.setups import SETUPS, demonstrations, table

PACES = {
    "slow": Teaching(duration=12.0, spread=0.005, bow=0.03, tremor=0.0015),
    "medium": Teaching(duration=4.0, spread=0.01, bow=0.06, tremor=0.006, tremor_band=(1.5, 5.0)),
    "fast": Teaching(duration=1.2, spread=0.02, bow=0.05, tremor=0.0005),
}
# Number of evenly spaced points of a path for the mean kappa and for the figures.
_POINTS = 200

_NOT_LEARNED: Row = {"kappa_after": None, "length_after_m": None}


@dataclass(frozen=True)
class Ur3Config:
    """The configuration of the study.

    Attributes:
        setups: numbers of experiments, keys of SETUPS.
        paces: paces of the person, keys of PACES.
        setting: parameters of the experiments.
        maps: the obstacle maps with which each experiment is repeated.
        saturations: saturations of the sweep.
        areas_of_influence: areas of influence of the sweep, m.
        threshold: value of kappa below which a path is learned.
        seed: seed of the simulated person.
        seeds: how many persons, from that seed on, each experiment is repeated with.
        mazes: how many random walls each of them is given.
        resolutions: sizes of cells, m, of which the cost is measured.
    """

    setups: tuple[int, ...] = tuple(SETUPS)
    paces: tuple[str, ...] = tuple(PACES)
    setting: Setting = field(default_factory=Setting)
    maps: tuple[str, ...] = ("product", "minimum")
    saturations: tuple[float, ...] = (0.05, 0.1, 0.25, 0.5, 0.75, 1.0)
    areas_of_influence: tuple[float, ...] = (0.02, 0.05, 0.1)
    threshold: float = 0.6
    seed: int = 0
    seeds: int = 10
    mazes: int = 200
    resolutions: tuple[float, ...] = (0.03, 0.02, 0.015, 0.01)


def configure(quick: bool, seed: int) -> Ur3Config:
    """The full configuration, or two experiments without the sweep."""
    if quick:
        return Ur3Config(
            (1, 3), ("medium",), saturations=(), seed=seed, seeds=2, mazes=20, resolutions=(0.03,)
        )
    return Ur3Config(seed=seed)


def tasks(config: Ur3Config) -> list[Task]:
    """A task for every experiment, point of the sweep, person, pace and statement of the paper."""
    common = {"threshold": config.threshold, "seed": config.seed}
    setting = dict(vars(config.setting))

    def mapped(name: str) -> dict[str, Any]:
        return setting | {"obstacle_map": name}

    return [
        *(Task(experiment, {"setup": n, "setting": setting, **common}) for n in config.setups),
        *_sweeps(config, setting, common),
        *(
            Task(repeat, {"setup": n, "setting": mapped(name), **common, "seed": seed})
            for n in config.setups
            for name in config.maps
            for seed in _persons(config)
        ),
        *(
            Task(teach, {"pace": pace, "setting": setting, "seed": config.seed})
            for pace in config.paces
        ),
        *_statements(config, setting),
    ]


def _persons(config: Ur3Config) -> range:
    return range(config.seed, config.seed + config.seeds)


def _sweeps(config: Ur3Config, setting: dict[str, Any], common: dict[str, Any]) -> list[Task]:
    """The first person's whole sweep, and its corners in the first experiment with all others."""
    whole = [(each, area) for each in config.saturations for area in config.areas_of_influence]
    corners = [
        (each, area)
        for each, area in whole
        if each in (config.saturations[0], config.saturations[-1])
        and area in (config.areas_of_influence[0], config.areas_of_influence[-1])
    ]
    wanted = [(n, config.seed, *point) for n in config.setups for point in whole]
    wanted += [(1, seed, *point) for seed in _persons(config)[1:] for point in corners]
    return [
        Task(
            sweep,
            common
            | {"setup": n, "seed": seed}
            | {"setting": setting | {"saturation": saturation, "area_of_influence": area}},
        )
        for n, seed, saturation, area in wanted
    ]


def _statements(config: Ur3Config, setting: dict[str, Any]) -> list[Task]:
    pace = dict(vars(PACES["fast"]))
    return [
        *(
            Task(statements.of_person, {"setup": n, "setting": setting, "seed": seed})
            for n in config.setups
            for seed in _persons(config)
        ),
        *(
            Task(statements.of_mazes, {"seed": seed, "count": config.mazes})
            for seed in _persons(config)
        ),
        *(Task(maps.of_map, {"seed": seed}) for seed in _persons(config)),
        *(
            Task(statements.of_tubes, {"pace": pace, "setting": setting, "seed": seed})
            for seed in _persons(config)
        ),
        *(
            Task(
                statements.of_cells,
                {"setting": setting | {"resolution": each}, "seed": config.seed},
            )
            for each in config.resolutions
        ),
    ]


def experiment(*, setup: int, setting: dict[str, Any], threshold: float, seed: int) -> list[Row]:
    """One row: the path of an experiment, its measures, and the motion of the arm along it."""
    place = SETUPS[setup]
    shown = demonstrations(setup, Teaching(), seed)
    row, made, skill = _plan(setup, setting, threshold, shown)
    row |= _after_learning(skill, made, setup) if row["auto_learned"] else _NOT_LEARNED
    met, joints = on_the_arm(Setting(**setting).model(), shown, setup)
    row |= met | _times(setup, setting, shown)
    labels = {"study": "setups", "title": place.title, "kappa_paper": place.kappa}
    drawn = {"path": _even(made).round(3).tolist(), "joints": joints and physics.row_of(joints)}
    return [{**labels, **row, **drawn}]


def repeat(*, setup: int, setting: dict[str, Any], threshold: float, seed: int) -> list[Row]:
    """One row: an experiment as another person shows it, and the whole arm along its path."""
    shown = demonstrations(setup, Teaching(), seed)
    row, _, _ = _plan(setup, setting, threshold, shown)
    met, _ = on_the_arm(Setting(**setting).model(), shown, setup)
    row |= met
    labels = {"obstacle_map": setting["obstacle_map"], "kappa_paper": SETUPS[setup].kappa}
    return [{"study": "seeds", "seed": seed, **labels, **row}]


def sweep(*, setup: int, setting: dict[str, Any], threshold: float, seed: int) -> list[Row]:
    """One row: an experiment at one saturation and one area of influence."""
    shown = demonstrations(setup, Teaching(), seed)
    row, made, _ = _plan(setup, setting, threshold, shown)
    known = cKDTree(np.concatenate([_motion(each).positions for each in shown]))
    off = float(known.query(_even(made))[0].mean())
    return [{"study": "sweep", "seed": seed, **setting, **row, "off_demonstrations_m": off}]


def teach(*, pace: str, setting: dict[str, Any], seed: int) -> list[Row]:
    """One row: roughness of experiment 1's demonstrations at a pace, and of the path made."""
    shown = demonstrations(1, PACES[pace], seed)
    row, made, _ = _plan(1, setting, 0.0, shown)
    motions = [_motion(demonstration) for demonstration in shown]
    return [
        {
            "study": "teaching",
            "pace": pace,
            "samples_shown": sum(len(motion.times) for motion in motions),
            **_roughness("shown", motions),
            **_roughness("made", [made]),
            **row,
        }
    ]


def _plan(
    setup: int, setting: dict[str, Any], threshold: float, shown: list[Demonstration[Trajectory]]
) -> tuple[Row, Trajectory, FastMarchingSkill[Trajectory]]:
    place, obstacles = SETUPS[setup], SETUPS[setup].obstacles()
    skill = Setting(**setting).model().fit(shown)
    made = skill.generate(start=place.start, goal=place.goal, obstacles=obstacles)
    path = _even(made)
    kappa, slowest = skill.kappa(path), setting["saturation"]
    with_obstacles = skill.map_with(obstacles)
    before, after = (
        speed_along(path, skill.grid, speed, slowest)
        for speed in (skill.velocity_map, with_obstacles)
    )
    row = {
        "setup": setup,
        "kappa": kappa,
        "kappa_before_rescaling": (kappa - slowest) / (1.0 - slowest) if slowest < 1.0 else None,
        "kappa_with_obstacles": kappa - float((before - after).mean()),
        "auto_learned": int(kappa < threshold),
        "length_m": float(arc_length(made.positions)[-1]),
        "goal_error_m": float(np.linalg.norm(made.positions[-1] - place.goal)),
        "table_distance_m": _clearance(made, obstacles[0]),
        "box_distance_m": _clearance(made, obstacles[1]) if place.box else None,
        "cells": int(skill.velocity_map.size),
    }
    return row, made, skill


def _after_learning(skill: FastMarchingSkill[Trajectory], made: Trajectory, setup: int) -> Row:
    place = SETUPS[setup]
    learned = skill.with_experience(made.positions)
    again = learned.generate(start=place.start, goal=place.goal, obstacles=place.obstacles())
    return {
        "kappa_after": learned.kappa(_even(again)),
        "length_after_m": float(arc_length(again.positions)[-1]),
    }


def _times(setup: int, setting: dict[str, Any], shown: list[Demonstration[Trajectory]]) -> Row:
    place, model = SETUPS[setup], Setting(**setting).model()
    skill = model.fit(shown)

    def plan(obstacles: list[Shape]) -> Trajectory:
        made: Trajectory = skill.generate(start=place.start, goal=place.goal, obstacles=obstacles)
        return made

    return {
        "fit_cpu_s": cpu_time(lambda: model.fit(shown).velocity_map),
        "plan_cpu_s": cpu_time(lambda: plan([table()])),
        "replan_cpu_s": cpu_time(lambda: plan(place.obstacles())),
    }


def _motion(demonstration: Demonstration) -> Trajectory:
    assert isinstance(demonstration.motion, Trajectory)
    return demonstration.motion


def _clearance(motion: Trajectory, shape: Shape) -> float:
    return float(shape.distance(motion.positions).min())


def _roughness(name: str, motions: list[Trajectory]) -> Row:
    turning = [metrics.turning(motion.positions, step=0.01) for motion in motions]
    jerk = [metrics.dimensionless_jerk(motion) for motion in motions]
    return {
        f"turning_{name}_rad": float(np.mean(turning)),
        f"jerk_{name}": float(np.mean(jerk)),
    }


def _even(motion: Trajectory) -> Float64Array:
    return by_arc_length(motion.positions, _POINTS)


STUDY = Study(configure, tasks, report)
