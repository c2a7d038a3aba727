"""Whether what is said of conditioning and of human demonstrations shows in simulation.

`conditioning`: a Panda follows paths past singularities (the singularity study) by damped least
squares, with several dampings, with and without the task in the null space. The joints are
simulated with soft springs and real drives, and compared with the largest condition number.
`naturalness`: one reach by simulated people and by damped least squares (the human study), as
recorded and as a ProMP learns it, all stretched to the same duration.
"""

from __future__ import annotations

import numpy as np

from leadthrough.arm import Arm
from leadthrough.models import ProMP
from leadthrough.motion import Demonstration, JointTrajectory
from leadthrough.simulation import JointImpedance, SimulationReport, simulate
from leadthrough_studies.damped_least_squares import DampedLeastSquares, follow_path
from leadthrough_studies.human.demonstrations import ROBOT, damped, human
from leadthrough_studies.singularity.paths import APPROACHES, ROTATION_WEIGHT, motion, start
from leadthrough_studies.study import Row

MEASURES = ("joint_error_mrad", "tip_error_mm", "torque_percent", "torque_rate", "energy_j")
_SOFT = JointImpedance(frequency=15.0)
_DURATION = 5.0  # s
_WEIGHTS = 20


def conditioning(*, number: int, damping: float, nullspace_gain: float) -> list[Row]:
    """One row: an approach by damped least squares, and what the simulated arm makes of it."""
    arm = Arm.load(ROBOT)
    way = motion(arm, APPROACHES[number])
    settings = DampedLeastSquares(damping=damping, alpha=0.0, nullspace_gain=nullspace_gain)
    begin = start(arm, APPROACHES[number], way)
    joints = follow_path(arm, way, q0=begin, settings=settings).joints
    condition = arm.condition_number(joints.positions, rotation_weight=ROTATION_WEIGHT)
    return [
        {"study": "conditioning", "approach": number, "damping": damping}
        | {"nullspace_gain": nullspace_gain, "largest_condition": float(condition.max())}
        | {"mean_log_condition": float(np.log10(condition).mean())}
        | _measured(simulate(arm, joints, controller=_SOFT))
    ]


def naturalness(*, index: int, seed: int) -> list[Row]:
    """Four rows: a person and damped least squares, as recorded and as learned."""
    arm = Arm.load(ROBOT)
    rng = np.random.default_rng([seed, index])
    by_hand, computed = human(1, rng)[0], damped(arm, 2, rng)[1]
    return [
        {"study": "naturalness", "index": index, "source": source, "learned": int(learned)}
        | _measured(
            simulate(
                arm,
                _stretched(shown, learned),
                controller=_SOFT,
            )
        )
        for source, shown in (("human", by_hand), ("DLS-IK", computed))
        for learned in (False, True)
    ]


def _stretched(shown: Demonstration, learned: bool) -> JointTrajectory:
    """The motion, or what a ProMP makes of it, lasting five seconds."""
    made = ProMP(weights=_WEIGHTS).fit([shown]).generate() if learned else shown.motion
    assert isinstance(made, JointTrajectory)
    times = (made.times - made.times[0]) * (_DURATION / made.duration)
    return JointTrajectory(times, made.positions)


def _measured(report: SimulationReport) -> Row:
    """How the simulated arm moved, with the motion's own clock: not the ways onto it and off."""
    rates = np.diff(report.torques, axis=0) / np.diff(report.planned.times)[:, None]
    return {
        "joint_error_mrad": 1e3 * float(np.abs(report.errors).max()),
        "tip_error_mm": 1e3 * float(report.tip_errors.max()),
        "torque_percent": 100.0 * float(report.torque_fractions.max()),
        "torque_rate": float(np.sqrt((rates**2).sum(axis=1).mean())),  # N m/s
        "energy_j": float(report.energy.sum()),
    }
