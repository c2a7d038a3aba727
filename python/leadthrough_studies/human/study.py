"""Human demonstrations and those of damped least squares, learned as ProMPs, on a Panda.

After Yang, Liu and Pears, "Enhancing Learning from Demonstration with DLS-IK and ProMPs", section
IV B, figures 6 to 8: position and velocity of joints 1, 3 and 5. The paper's recordings are not
public, so a simulated person demonstrates the reach (see `demonstrations`); real recordings, if
there are any, are measured as well. The paper does not say how many demonstrations were learned,
nor with which basis functions. So the study learns one demonstration, all of them, and all of them
aligned in time, and sweeps the number and the width of the basis functions. `measures` defines the
measures.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from leadthrough.arm import Arm
from leadthrough.models import ProMP
from leadthrough.motion import Demonstration
from leadthrough.preprocess import align_by_time_warping
from leadthrough_studies.human import recordings, repeated
from leadthrough_studies.human.demonstrations import ROBOT, damped, human, laws
from leadthrough_studies.human.measures import course, fidelity
from leadthrough_studies.human.report import report
from leadthrough_studies.study import Row, Study, Task


@dataclass(frozen=True)
class HumanConfig:
    """The configuration of the study.

    Attributes:
        demonstrations: number of demonstrations of each source.
        joints: numbers (from 1) of the joints measured.
        weights: number of basis functions of the compared ProMPs.
        width: width of their basis functions.
        swept_weights: numbers of basis functions of the sweep.
        swept_widths: widths of the sweep.
        seeds: number of seeds of the repeated comparison and of the parts of the loss.
        recordings: folder with panda_execution/*.csv and panda_symbol/*.mat; empty for none.
        seed: seed of the simulated person and of the targets of damped least squares.
    """

    demonstrations: int = 6
    joints: tuple[int, ...] = (1, 3, 5)
    weights: int = 20
    width: float = 1.0
    swept_weights: tuple[int, ...] = (6, 8, 12, 20, 30, 45)
    swept_widths: tuple[float, ...] = (0.35, 0.45, 0.6, 1.0)
    seeds: int = 20
    recordings: str = ""
    seed: int = 0


def configure(quick: bool, seed: int) -> HumanConfig:
    """The full configuration with the recordings in LEADTHROUGH_DATA, or a short one without."""
    if quick:
        return HumanConfig(swept_weights=(8, 20), swept_widths=(0.45, 1.0), seeds=10, seed=seed)
    return HumanConfig(recordings=os.environ.get("LEADTHROUGH_DATA", ""), seed=seed)


def tasks(config: HumanConfig) -> list[Task]:
    """Tasks for every source and way of learning, the sweep, the time laws and the recordings."""
    common = {
        "count": config.demonstrations,
        "joints": list(config.joints),
        "seed": config.seed,
    }
    own = {"weights": config.weights, "width": config.width}
    return [
        *(
            Task(learn, {"source": source, "way": way, **own, **common})
            for source in SOURCES
            for way in WAYS
        ),
        *(
            Task(sweep, {"source": source, "weights": weights, "width": width, **common})
            for source in SOURCES
            for weights in config.swept_weights
            for width in config.swept_widths
        ),
        *(
            Task(time_laws, {"weights": weights, "joints": list(config.joints)})
            for weights in (min(config.swept_weights), config.weights)
        ),
        *(
            Task(work, {**common, "seed": config.seed + i, "weights": config.weights})
            for work in (repeated.of_seed, repeated.losses)
            for i in range(config.seeds)
        ),
        *recordings.tasks(config.recordings, list(config.joints), config.weights),
    ]


def learn(
    *, source: str, way: str, weights: int, width: float, count: int, joints: list[int], seed: int
) -> list[Row]:
    """A row for every joint: the measures of one source and one way of learning."""
    given, compared = WAYS[way](SOURCES[source](count, seed))
    skill = ProMP(weights=weights, width=width).fit(given)
    motions = [each.motion for each in compared]
    return [
        {"study": "learning", "source": source, "learned_from": way, "column": f"joint {joint}"}
        | {"weights": weights, "width": width, **fidelity(skill, motions, joint - 1)}
        | {"course": course(skill, motions[0], joint - 1)}
        for joint in joints
    ]


def sweep(
    *, source: str, weights: int, width: float, count: int, joints: list[int], seed: int
) -> list[Row]:
    """A row for every joint: means over a source's demonstrations, each learned separately."""
    found: dict[int, list[Row]] = {joint: [] for joint in joints}
    for shown in SOURCES[source](count, seed):
        skill = ProMP(weights=weights, width=width).fit([shown])
        for joint in joints:
            found[joint].append(fidelity(skill, [shown.motion], joint - 1))
    return [
        {"study": "sweep", "source": source, "weights": weights, "width": width}
        | {"column": f"joint {joint}"}
        | {name: float(np.mean([row[name] for row in rows])) for name in rows[0]}
        for joint, rows in found.items()
    ]


def time_laws(*, weights: int, joints: list[int]) -> list[Row]:
    """A row for every time law and joint: distances from a bell, before and after learning."""
    rows = []
    for law, shown in laws(Arm.load(ROBOT), np.random.default_rng(0)).items():
        skill = ProMP(weights=weights).fit([shown])
        rows += [
            {"study": "time laws", "law": law, "weights": weights, "column": f"joint {joint}"}
            | fidelity(skill, [shown.motion], joint - 1)
            | {"course": course(skill, shown.motion, joint - 1)}
            for joint in joints
        ]
    return rows


def _human(count: int, seed: int) -> list[Demonstration]:
    return human(count, np.random.default_rng(seed))


def _damped(count: int, seed: int) -> list[Demonstration]:
    return damped(Arm.load(ROBOT), count, np.random.default_rng(seed))


Shown = list[Demonstration]
SOURCES: dict[str, Callable[[int, int], Shown]] = {"human": _human, "DLS-IK": _damped}


def _one(shown: Shown) -> tuple[Shown, Shown]:
    return shown[:1], shown[:1]


def _all(shown: Shown) -> tuple[Shown, Shown]:
    return shown, shown


def _aligned(shown: Shown) -> tuple[Shown, Shown]:
    """All, aligned with the shortest, which the mean is compared with."""
    chosen = int(np.argmin([each.motion.duration for each in shown]))
    return align_by_time_warping(shown, reference=chosen), [shown[chosen]]


# The demonstrations to learn from, and those that the mean is compared with.
WAYS: dict[str, Callable[[Shown], tuple[Shown, Shown]]] = {
    "one": _one,
    "all": _all,
    "all, aligned": _aligned,
}

STUDY = Study(configure, tasks, report)
