"""The scenes of the demo by name."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from leadthrough.arm import Arm
from leadthrough_studies.demo import harvesting, pouring
from leadthrough_studies.demo.performed import Performed
from leadthrough_studies.demo.report import write_joints
from leadthrough_studies.demo.writing import performed
from leadthrough_studies.handwriting.demo import MOTIONS, Handwriting, HandwritingConfig, run
from leadthrough_studies.handwriting.report import write_learning, write_summary

__all__ = ["HANDWRITING", "MOTIONS", "NAMES", "handwriting", "other"]

HANDWRITING = "handwriting"
_OTHERS: Mapping[str, Callable[[], Performed]] = {
    "pouring": pouring.run,
    "harvesting": harvesting.run,
}
NAMES = (HANDWRITING, *_OTHERS)


def handwriting(names: Iterable[str], folder: Path) -> tuple[Performed, list[Handwriting]]:
    """The scene of the first motion, and all motions, with their figures and errors in files.

    Args:
        names: of motions of the LASA set.
        folder: gets errors.csv, overview.png and a folder of each motion's name; made if missing.
    """
    config = HandwritingConfig()
    arm = Arm.load(config.robot)
    results = []
    for name in names:
        result = run(name, arm, config)
        write_joints(result.joints, arm.limits, folder / name)
        write_learning(result, folder / name)
        results.append(result)
    write_summary(results, folder)
    return performed(results[0], arm, config), results


def other(name: str, folder: Path) -> Performed:
    """The scene "pouring" or "harvesting", with the motion of the joints in files.

    Args:
        name: of the scene.
        folder: gets a folder of the scene's name.
    """
    shown = _OTHERS[name]()
    write_joints(shown.joints, shown.arm.limits, folder / name)
    return shown
