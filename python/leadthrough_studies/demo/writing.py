"""A UR3 writes what people have written, around a box."""

from __future__ import annotations

import numpy as np

from leadthrough.arm import Arm
from leadthrough.motion import Demonstration
from leadthrough.shapes import Box
from leadthrough_studies.demo.performed import Performed
from leadthrough_studies.handwriting.demo import Handwriting, HandwritingConfig, pen


def performed(result: Handwriting, arm: Arm, config: HandwritingConfig) -> Performed:
    """The scene of a motion.

    Args:
        result: the motion.
        arm: without the pen.
        config: of the pen and the table.
    """
    return Performed(
        name="Handwriting",
        told=f"A UR3 with a pen writes {result.name} of the LASA set on a table.",
        model="FastMarching",
        learned_from="6 drawings by people",
        asked="the start of a seventh drawing, a box in the way",
        arm=arm.with_attached(pen(config)),
        demonstrations=tuple(Demonstration(motion) for motion in result.shown),
        joints=result.joints,
        limits=result.limits,
        clearance=result.clearance,
        path=np.pad(result.detour.positions, ((0, 0), (0, 1))),
        obstacles=(_above_the_table(result.box),),
    )


def _above_the_table(box: Box) -> Box:
    """The upper half of the box: the scene's floor is the table."""
    height = 0.5 * box.size[2]
    x, y, z = box.position
    return Box((*box.size[:2], height), (x, y, z + 0.5 * height))
