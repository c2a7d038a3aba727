"""A motion of a study under gravity and a controller: the simulated arm beside the planned one."""

from __future__ import annotations

from collections.abc import Sequence

from leadthrough.arm import Arm
from leadthrough.errors import MissingDependency
from leadthrough.motion import JointTrajectory
from leadthrough.shapes import Shape
from leadthrough.show import simulation_parts
from leadthrough.simulation import simulate
from leadthrough_studies.study import Report, Row

PAGE = "simulated"


def with_physics(
    report: Report, arm: Arm, joints: JointTrajectory, *, obstacles: Sequence[Shape] = ()
) -> Report:
    """A report with the page simulated.html, and its verdict in the summary.

    Without the extra `simulation` there is no page, and the summary tells what to install.

    Args:
        report: of a study.
        arm: the arm that moves.
        joints: its motion.
        obstacles: shapes in its base frame.
    """
    try:
        found = simulate(arm, joints, obstacles)
    except MissingDependency as error:
        report.summary[PAGE] = str(error)
        return report
    report.summary[PAGE] = str(found)
    report.pages[PAGE] = simulation_parts(found)
    return report


def row_of(joints: JointTrajectory) -> Row:
    """A motion as it is kept in a row of results: times in s, positions in rad, rounded."""
    return {
        "times": joints.times.round(6).tolist(),
        "positions": joints.positions.round(6).tolist(),
    }


def joints_of(row: Row, arm: Arm) -> JointTrajectory:
    """The motion of such a row."""
    return JointTrajectory(row["times"], row["positions"], joint_names=arm.joint_names)
