"""The simulation study: motions of the other studies under gravity, friction and controllers.

Each motion is timed as fast as its arm's limits of velocity, acceleration, jerk and nine tenths of
the torques allow, with a payload, and simulated with four settings: computed torque on an ideal
arm, and computed torque, a position servo and joint impedance on an arm with real drives. The
errors are compared with those that the controllers' gains allow by linear theory. Then each motion
is given the faults of `faults`, which the simulation should find. `stability` measures what is said
of conditioning and of human demonstrations. Needs the extra `simulation`; handwriting needs `lasa`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from leadthrough.simulation import (
    ComputedTorque,
    Disturbances,
    JointImpedance,
    PositionServo,
    SimulationReport,
    simulate,
)
from leadthrough_studies.simulation.faults import faulty
from leadthrough_studies.simulation.motions import given
from leadthrough_studies.simulation.report import report
from leadthrough_studies.simulation.stability import conditioning, naturalness
from leadthrough_studies.study import Row, Study, Task, cpu_time

_REAL = Disturbances()
# Controllers and disturbances.
SETTINGS: dict[str, tuple[Any, Disturbances]] = {
    "computed torque, ideal arm": (ComputedTorque(), Disturbances.ideal()),
    "computed torque": (ComputedTorque(), _REAL),
    "position servo": (PositionServo(), _REAL),
    "joint impedance": (JointImpedance(), _REAL),
}


@dataclass(frozen=True)
class SimulationConfig:
    """The configuration of the study.

    Attributes:
        motions: how many motions of each source, a key of motions.SOURCES.
        dampings: of the paths past singularities, m per rad.
        people: how many people demonstrate the reach.
        seed: of reaches, people and their tremor.
    """

    motions: dict[str, int] = field(
        default_factory=lambda: {
            "reaches of a Panda": 45,
            "reaches of a UR3": 45,
            "handwriting": 30,
            "agriculture": 64,
            "human": 16,
        }
    )
    dampings: tuple[float, ...] = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
    people: int = 12
    seed: int = 0


def configure(quick: bool, seed: int) -> SimulationConfig:
    """The full configuration of 200 motions, or some reaches and people."""
    if quick:
        few = {"reaches of a Panda": 3, "reaches of a UR3": 3, "human": 2}
        return SimulationConfig(few, dampings=(0.0, 0.1), people=3, seed=seed)
    return SimulationConfig(seed=seed)


def tasks(config: SimulationConfig) -> list[Task]:
    """A task for every motion, every way past a singularity and every person."""
    return [
        *(
            Task(run_motion, {"source": source, "index": index, "seed": config.seed})
            for source, count in config.motions.items()
            for index in range(count)
        ),
        *(
            Task(conditioning, {"number": number, "damping": damping, "nullspace_gain": gain})
            for number in (1, 2)
            for damping in config.dampings
            for gain in (0.0, 0.5)
        ),
        *(Task(naturalness, {"index": i, "seed": config.seed}) for i in range(config.people)),
    ]


def run_motion(*, source: str, index: int, seed: int) -> list[Row]:
    """A row for every setting and every fault of a motion; one alone where there is no motion."""
    labels = {"source": source, "index": index}
    made = given(source, index, seed)
    if isinstance(made, str):
        return [{"study": "refused", **labels, "reason": made}]
    rows: list[Row] = []
    for setting, (controller, disturbances) in SETTINGS.items():
        shown = simulate(made.arm, made.joints, controller=controller, disturbances=disturbances)
        rows.append({"study": "sound", **labels, "setting": setting} | _judged(shown))
    if index == 0:
        seconds = cpu_time(lambda: simulate(made.arm, made.joints))
        rows[0]["part_of_real_time"] = seconds / rows[0]["duration_s"]
    for fault, result in faulty(made):
        row = {"study": "fault", **labels, "fault": fault, "is_one": int(result is not None)}
        if result is not None:
            row |= {"found": int(not result.ok), "kinds": sorted(_kinds(result))}
        rows.append(row)
    return rows


def _judged(shown: SimulationReport) -> Row:
    expected = float(np.abs(shown.expected).max())
    error = float(np.abs(shown.errors).max())
    return {
        "fit_to_run": int(shown.ok),
        "findings": [str(each) for each in shown.findings],
        "duration_s": float(shown.planned.duration),
        "torque_percent": 100.0 * float(shown.torque_fractions.max()),
        "joint_error_mrad": 1e3 * error,
        "expected_mrad": 1e3 * expected,
        "of_allowed": float((np.abs(shown.errors).max(axis=0) / shown.allowed).max()),
        "tip_error_mm": 1e3 * float(shown.tip_errors.max()),
        "energy_j": float(shown.energy.sum()),
    }


def _kinds(shown: SimulationReport) -> set[str]:
    return {each.kind for each in shown.findings}


STUDY = Study(configure, tasks, report)
