"""The singularity study: a Panda moves past two singularities, with and without damping.

After Yang, Liu and Pears, "Enhancing Learning from Demonstration with DLS-IK and ProMPs",
section IV A. The table shows the paper's numbers beside ours. The paper does not state its paths,
its lambda and its weighting of rotations, so the numbers agree in tendency, not digit for digit.
In equation 5 only lambda^2 + alpha counts, so the sweep varies each with the other at zero.

The percentages of condition numbers below a threshold are given twice. In plain SI units a Panda in
the middle of its workspace has a condition number of about 9, so the paper's thresholds 8 and 10
separate samples. The second percentages use 0.3 m per rad, the weighting on which the damping
depends.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.motion import JointTrajectory, PoseTrajectory
from leadthrough_studies.singularity import draws, joint_limits, penalty
from leadthrough_studies.singularity.paths import (
    APPROACHES,
    METHODS,
    ROTATION_WEIGHT,
    damped,
    motion,
    start,
)
from leadthrough_studies.singularity.report import report
from leadthrough_studies.study import Row, Study, Task

_ROBOT = "panda"
_THRESHOLDS = (8, 10)  # the paper's, of the condition number


@dataclass(frozen=True)
class SingularityConfig:
    """The configuration of the study.

    Attributes:
        approaches: numbers of the approaches, keys of APPROACHES.
        methods: keys of METHODS.
        dampings: values of lambda_max of the sweep, m per rad.
        alphas: values of alpha in equation 5 of the sweep, (m per rad)^2.
        units: weights of rotations in the condition number of drawn paths, m per rad.
        blocks: numbers of blocks of drawn paths for each unit and tip, and of drawn poses.
        draws: paths and poses in each block.
        seed: of the drawn paths and poses.
    """

    approaches: tuple[int, ...] = tuple(APPROACHES)
    methods: tuple[str, ...] = tuple(METHODS)
    dampings: tuple[float, ...] = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
    alphas: tuple[float, ...] = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1)
    units: tuple[float, ...] = (1.0, 0.3, 0.1)
    blocks: int = 10
    draws: int = 100
    seed: int = 0


def configure(quick: bool, seed: int) -> SingularityConfig:
    """The full configuration, or the approaches with a short sweep."""
    if quick:
        return SingularityConfig(
            dampings=(0.0, 0.1), alphas=(1e-4,), units=(1.0, 0.3), blocks=1, draws=30, seed=seed
        )
    return SingularityConfig(seed=seed)


def tasks(config: SingularityConfig) -> list[Task]:
    """A task for every approach and method, and for every point of the sweep."""
    settings = [
        *({"damping": damping, "alpha": 0.0} for damping in config.dampings),
        *({"damping": 0.0, "alpha": alpha} for alpha in config.alphas),
    ]
    return [
        *(
            Task(approach, {"number": number, "method": method})
            for number in config.approaches
            for method in config.methods
        ),
        *(
            Task(sweep, {"number": number, **setting, "nullspace_gain": gain})
            for number in config.approaches
            for setting in settings
            for gain in (0.0, 0.5)
        ),
        *_drawn(config),
    ]


def _drawn(config: SingularityConfig) -> list[Task]:
    """Tasks of random paths and poses, each block with a seed of its own."""
    seeds = [config.seed * 1000 + block for block in range(config.blocks)]
    count = config.draws
    return [
        *(
            Task(draws.rows_of_tables, {"seed": seed, "unit": unit, "tip": tip, "paths": count})
            for unit in config.units
            for tip in draws.TIPS
            for seed in seeds
        ),
        *(Task(draws.relation, {"seed": seed, "paths": 2 * count}) for seed in seeds),
        *(Task(joint_limits.ends, {"seed": seed, "poses": count}) for seed in seeds),
        *(Task(penalty.steps, {"seed": seed, "poses": count}) for seed in seeds),
    ]


def approach(*, number: int, method: str) -> list[Row]:
    """One row: an approach by a method, with its measures and its time series."""
    arm, way, q = _given(number)
    joints = METHODS[method](arm, way, q)
    row = {"study": "approach", "approach": number, "title": APPROACHES[number].title}
    course = _course(arm, joints)
    return [row | {"method": method} | _judged(arm, way, joints, course) | {"course": course}]


def sweep(*, number: int, damping: float, alpha: float, nullspace_gain: float) -> list[Row]:
    """One row: an approach by equations 3 to 7 with other parameters."""
    arm, way, q = _given(number)
    settings = {"damping": damping, "alpha": alpha, "nullspace_gain": nullspace_gain}
    joints = damped(arm, way, q, **settings)
    judged = _judged(arm, way, joints, _course(arm, joints))
    return [{"study": "sweep", "approach": number, **settings, **judged}]


def _given(number: int) -> tuple[Arm, PoseTrajectory, Float64Array]:
    arm = Arm.load(_ROBOT)
    way = motion(arm, APPROACHES[number])
    return arm, way, start(arm, APPROACHES[number], way)


def _course(arm: Arm, joints: JointTrajectory) -> dict[str, Any]:
    """Time series of the joints; velocities are differences of the positions."""
    velocities = np.gradient(joints.positions, joints.times, axis=0)
    accelerations = np.gradient(velocities, joints.times, axis=0)
    torques = arm.inverse_dynamics(joints.positions, velocities, accelerations)
    columns = {
        "time": joints.times,
        "position": joints.positions,
        "velocity": velocities,
        "torque": torques,
        "condition": arm.condition_number(joints.positions, rotation_weight=1.0),
        "condition_weighted": arm.condition_number(
            joints.positions, rotation_weight=ROTATION_WEIGHT
        ),
    }
    return {name: np.round(values, 6).tolist() for name, values in columns.items()}


def _judged(arm: Arm, way: PoseTrajectory, joints: JointTrajectory, course: dict[str, Any]) -> Row:
    velocity, torque = np.array(course["velocity"]), np.array(course["torque"])
    fit = arm.path_report(joints, way)
    peaks = velocity[np.abs(velocity).argmax(axis=0), np.arange(velocity.shape[1])]
    return {
        "duration_s": float(joints.times[-1]),
        "largest_error_m": float(fit.position_error.max()),
        "largest_error_rad": float(fit.orientation_error.max()),
        **{f"peak_velocity_{i + 1}": float(peak) for i, peak in enumerate(peaks)},
        "peak_share_of_velocity_limit": float((np.abs(peaks) / arm.limits.velocity).max()),
        "peak_share_of_effort_limit": float((np.abs(torque).max(axis=0) / arm.limits.effort).max()),
        **_shares(course["condition"], "below_{}_percent"),
        **_shares(course["condition_weighted"], "below_{}_weighted_percent"),
        "largest_condition": max(course["condition"]),
        **draws.loads(arm, joints),
    }


def _shares(condition: list[float], name: str) -> Row:
    values = np.array(condition)
    return {name.format(bound): 100.0 * float((values < bound).mean()) for bound in _THRESHOLDS}


STUDY = Study(configure, tasks, report)
