"""Ten odd arms of other packages: from the URDF and two recordings to a checked motion."""

import importlib.metadata
import re

import pytest
from robots import every_arm

# Two, four and five joints, a lift, a base with arms at both sides; no masses, no shapes, limits of
# 0, no bounds.
ODDEST = (
    "TurtleBot arm",
    "Borinot's arm",
    "Double pendulum without bounds",
    "Edu finger",
    "SO-100",
    "Simple humanoid, left arm",
    "TIAGo without hand",
    "AL5D",
    "KUKA KR 16",
    "Puma 560",
)
ARMS = {each.name: each for each in every_arm.listed()}


@pytest.mark.parametrize("name", ODDEST)
def test_an_odd_arm_is_led_to_a_checked_motion(name, tmp_path):
    entry = ARMS[name]
    try:
        importlib.metadata.distribution(entry.package)
    except importlib.metadata.PackageNotFoundError:
        pytest.skip(f"{entry.package} is not installed")
    found = every_arm.outcome(entry, tmp_path, simulated=False)
    assert not found.failed, found.reason


def test_the_page_has_a_row_for_each_arm_of_the_list():
    row = r"^\| (.+?) \| `(.+?)`, `(.+?)` to `(.+?)` \|"
    rows = re.findall(row, every_arm.PAGE.read_text(), re.MULTILINE)
    assert rows == [(each.name, each.urdf, each.base, each.tip) for each in ARMS.values()]
    assert len(rows) >= 30
