"""Skills that version 0.1.0 saved still load, and generate the same motions."""

from pathlib import Path

import numpy as np
import pytest

import leadthrough as lt

FOLDER = Path(__file__).parent / "saved_before"
# Positions at steps of 0.1 s, by the version that saved; those of Fast Marching are of a later one,
# which follows the middle of the tube instead of marching through it, up to 5 mm from before.
MOTIONS = np.load(FOLDER / "motions.npz")


@pytest.mark.parametrize("name", MOTIONS.files)
def test_a_skill_saved_by_an_earlier_version_generates_the_same_motion(name):
    skill = lt.load_skill(FOLDER / f"{name}.npz")
    np.testing.assert_allclose(skill.generate(dt=0.1).positions, MOTIONS[name], atol=1e-12)


def test_a_library_saved_by_an_earlier_version_still_has_its_skill():
    library = lt.SkillLibrary.load(FOLDER / "library.npz")
    motion = library.nearest("t", "s", [0.0]).generate(dt=0.1)
    np.testing.assert_allclose(motion.positions, MOTIONS["dmp"], atol=1e-12)
