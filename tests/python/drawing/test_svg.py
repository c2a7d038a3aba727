"""Small drawings: valid, within their frame, and seen on light and on dark pages."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.figure import Figure

import leadthrough as lt
from leadthrough.drawing import panels, svg
from leadthrough.errors import InvalidInput

SVG = "{http://www.w3.org/2000/svg}"
T = np.linspace(0.0, 2.0, 5000)


def drawn(*each):
    return ElementTree.fromstring(svg.drawing(each))


def numbers(picture):
    for line in picture.iter(f"{SVG}polyline"):
        for pair in line.get("points").split():
            yield tuple(map(float, pair.split(",")))


def texts(picture):
    return [each.text for each in picture.iter(f"{SVG}text")]


def motions():
    wave = np.column_stack([np.sin(T), np.cos(3 * T), T])
    turned = lt.rotations.exp(np.outer(T, [0.3, 1.0, 0.2]))
    names = [f"robot_joint_{i}_drive" for i in (1, 2, 10)]
    closed = [lt.Event(0.5, "close <gripper>")]
    return [
        lt.Trajectory(T, wave[:, :1]),
        lt.Trajectory(T, wave[:, :2], closed),
        lt.Trajectory(T, wave),
        lt.Trajectory(T, np.hstack([wave, wave])),
        lt.PoseTrajectory(T, wave, turned, closed),
        lt.JointTrajectory(T, wave, joint_names=names),
        lt.JointTrajectory(T[:1], wave[:1]),
        lt.Trajectory(T[:2], np.zeros((2, 2))),
    ]


@pytest.mark.parametrize("motion", motions(), ids=range(len(motions())))
def test_motion_is_drawn_within_its_frame_in_the_pages_own_colour(motion):
    page = ElementTree.fromstring(motion._repr_html_())
    (picture,) = page.iter(f"{SVG}svg")
    assert picture.get("fill") == "currentColor"
    assert not re.search("nan|inf", ElementTree.tostring(picture, encoding="unicode").lower())
    for x, y in numbers(picture):
        assert 0.0 <= x <= 300.0
        assert 0.0 <= y <= 200.0
    assert len(ElementTree.tostring(page)) < 40_000
    assert isinstance(motion.plot(), Figure)
    assert len(repr(motion).splitlines()) <= 5


def test_names_leave_out_what_all_have_in_common():
    assert panels.short_names(["robot_joint_1_drive", "robot_joint_10_drive"]) == ["1", "10"]
    assert panels.short_names(["shoulder", "elbow"]) == ["shoulder", "elbow"]
    assert panels.short_names(["a", "a"]) == ["a", "a"]
    assert panels.short_names(["joint11", "joint12"]) == ["11", "12"]


def test_texts_of_users_are_escaped():
    picture = ElementTree.fromstring(motions()[1]._repr_html_())
    assert "close <gripper>" in texts(picture)


def test_band_is_two_deviations_wide():
    columns, deviations = np.zeros((50, 1)), np.full((50, 1), 0.25)
    panel = panels.over(T[:50], columns, ["x"], title="t", deviations=deviations)
    (band,) = panel.bands
    assert np.ptp(np.concatenate([band.lower, band.upper])) == 1.0
    (shape,) = drawn(panel).iter(f"{SVG}polygon")
    assert shape.get("fill") == panel.colour(0)


def test_bars_beyond_the_limit_have_another_colour():
    panel = panels.bars([("a", 0.0, 0.9), ("b", 0.0, 1.2)], title="t", x_label="x", limit=1.0)
    assert panel.colour(0) != panel.colour(1)
    assert {"a", "b"} <= set(texts(drawn(panel)))


def test_ticks_are_round_numbers_within_the_range():
    for low, high in ((0.0, 1.0), (-3e-7, 2e-7), (0.0, 4321.0), (-7.2, -7.1)):
        ticks = svg._round_numbers(low, high)
        assert 2 <= len(ticks) <= 9
        assert low <= ticks[0] <= ticks[-1] <= high


def test_what_has_nothing_to_draw_shows_its_text():
    _, report = lt.preprocess.clean(lt.Trajectory(T, np.sin(T)[:, None]))
    assert "5000 samples read" in report._repr_html_()
    assert "<svg" not in report._repr_html_()
    with pytest.raises(InvalidInput, match="nothing to draw"):
        report.plot()


def test_arms_and_reports_are_drawn_too():
    arm = lt.Arm.load("ur3")
    q = np.array([0.0, -1.2, 1.4, -1.7, -1.5, 0.3])
    joints = lt.JointTrajectory([0.0, 0.5, 1.0], [q, q + 0.1, q + 0.2], joint_names=arm.joint_names)
    poses = arm.poses(joints)
    reports = (lt.check_limits(joints, arm.limits), arm.path_report(joints, poses))
    for each in (arm, *reports, arm.check(joints, [lt.Sphere(0.1, (0.0, 0.0, 2.0))])):
        assert "<svg" in each._repr_html_()
        assert isinstance(each.plot(), Figure)
