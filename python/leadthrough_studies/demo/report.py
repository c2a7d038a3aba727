"""The files of the demo: a page of its scenes, figures, joint trajectories, a simulation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from leadthrough import io
from leadthrough.arm import JointLimits
from leadthrough.errors import MissingDependency
from leadthrough.io import joint_trajectory
from leadthrough.motion import JointTrajectory
from leadthrough.show import page, simulation_page
from leadthrough.show.plot import limits_figure
from leadthrough.simulation import simulate
from leadthrough.timing import Peak
from leadthrough_studies.demo.performed import Performed
from leadthrough_studies.handwriting import report as handwriting
from leadthrough_studies.handwriting.demo import Handwriting
from leadthrough_studies.results import save_figure

TITLE = "A few demonstrations in, motions for three arms out"
_INTRODUCTION = (
    "Each arm has learned a motion from a few demonstrations and is asked for one that was not "
    "shown. Its joints were computed with the whole arm clear of everything, timed within the "
    "limits of position, velocity, acceleration and jerk, and checked again.",
    "Drag a scene to turn it, with the right button to move it; the wheel or two fingers zoom. "
    "With the keyboard: the arrow keys, plus, minus and the space bar.",
)
_AT_A_GLANCE = "At a glance"
_MEASURES = {
    "duration": "How long the motion takes, s.",
    "to obstacles": "The nearest that any part of the arm, or what it holds, comes to an obstacle, "
    "between samples too, mm. The pen is kept 1 mm above the table that it writes on.",
    "to itself": "The nearest that parts of the arm come to each other, mm.",
    "velocity, acceleration, jerk": "The largest fraction of the limit that any joint uses. 100 % "
    "is the limit; at least one of them is near it where the motion is as fast as it may be.",
}
_ERRORS = "How well the handwriting is met"
_ERRORS_TOLD = (
    "Six of seven drawings of each motion were learned; from the start of the seventh, the motion "
    "was reproduced and compared with it, in mm of the drawings. Smaller is better."
)


def write_joints(joints: JointTrajectory, limits: JointLimits, folder: Path) -> None:
    """Write a figure of the joints, and their trajectory as CSV and as a ROS 2 message in JSON.

    Args:
        joints: the motion.
        limits: of the same joints.
        folder: made if missing.
    """
    folder.mkdir(parents=True, exist_ok=True)
    save_figure(limits_figure(joints, limits), folder / "joints.png")
    io.write_motion(joints, folder / "trajectory.csv")
    joint_trajectory.write_json(joints, folder / "trajectory.json")


def write_page(scenes: Sequence[Performed], written: Sequence[Handwriting], folder: Path) -> None:
    """Write report.html: the scenes, what was measured, and the errors of the handwriting.

    Args:
        scenes: of the demo.
        written: the motions of the handwriting, if it is among the scenes.
        folder: made if missing.
    """
    folder.mkdir(parents=True, exist_ok=True)
    last = [_ERRORS] if written else []
    parts = [page.text(text) for text in _INTRODUCTION]
    parts.append(page.contents([*(each.name for each in scenes), _AT_A_GLANCE, *last]))
    for each in scenes:
        parts += [page.heading(each.name), page.text(each.told), page.scene(each.drawn())]
        parts.append(page.text(f"{each.model}, from {each.learned_from}. Asked for: {each.asked}."))
    parts += [page.heading(_AT_A_GLANCE), page.table(*glance(scenes)), page.terms(_MEASURES)]
    parts += _handwriting_parts(written) if written else []
    page.write_page(folder / "report.html", TITLE, parts)


def glance(scenes: Sequence[Performed]) -> tuple[list[str], list[list[str]]]:
    """Names of columns, and a row for each measure of the scenes.

    Args:
        scenes: of the demo.
    """
    told = [_measured(each) for each in scenes]
    rows = [[name, *(each[name] for each in told)] for name in told[0]]
    return ["measure", *(each.name for each in scenes)], rows


def errors(written: Sequence[Handwriting]) -> tuple[list[str], list[tuple[str, ...]]]:
    """Names of columns, and a row of errors for each motion and for their mean.

    Args:
        written: the motions of the handwriting.
    """
    return ["motion", *handwriting.MEASURES], handwriting.error_rows(written)


def write_simulation(shown: Performed, folder: Path) -> str:
    """Write simulated.html: a scene's motion run by the simulated arm, beside the planned one.

    Args:
        shown: the scene.
        folder: made if missing.

    Returns:
        The file and the verdict, or what to install.
    """
    try:
        found = simulate(shown.arm, shown.joints)
    except MissingDependency as error:
        return str(error)
    file = folder / "simulated.html"
    simulation_page(found, file, title=f"{shown.name}, simulated")
    return f"{file}, {found}"


def _measured(shown: Performed) -> dict[str, str]:
    limits, clearance = shown.limits, shown.clearance
    return {
        "arm": shown.arm.robot.name,
        "model": shown.model,
        "duration": f"{shown.joints.duration:.1f} s",
        "to obstacles": f"{1e3 * clearance.obstacles.minimum_distance:.1f} mm",
        "to itself": f"{1e3 * clearance.itself.minimum_distance:.1f} mm",
        "velocity": _percent(limits.velocity),
        "acceleration": _percent(limits.acceleration),
        "jerk": _percent(limits.jerk),
        "limits": "kept" if limits.ok else "exceeded",
        "whole arm": "clear" if clearance.ok else "hits",
    }


def _percent(peak: Peak | None) -> str:
    return "no limit" if peak is None else f"{peak.ratio:.0%}"


def _handwriting_parts(written: Sequence[Handwriting]) -> list[str]:
    return [
        page.heading(_ERRORS),
        page.text(_ERRORS_TOLD),
        page.legend(handwriting.LEGEND, dashed=handwriting.DASHED),
        page.gallery(handwriting.maps(written), width=9.5),
        page.table(*errors(written)),
        page.terms(handwriting.MEASURES),
    ]
