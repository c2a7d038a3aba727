"""Figures: one look, the user's settings kept, and valid SVG for light and for dark pages."""

import re
from dataclasses import dataclass
from xml.etree import ElementTree

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure
from refusals import refused

import leadthrough as lt
from leadthrough.drawing import palette, panels
from leadthrough.drawing.figure import figure_of
from leadthrough.show import plot
from leadthrough_studies import study

SVG = "{http://www.w3.org/2000/svg}"
T = np.linspace(0.0, 2.0, 5000)


@pytest.fixture
def joints(panda):
    times = np.linspace(0.0, 1.0, 30)
    q = np.outer(times, 0.3 * np.ones(7)) + np.array([0, 0, 0, -1.5, 0, 1.5, 0])
    return lt.JointTrajectory(times, q, joint_names=panda.joint_names)


@dataclass(frozen=True)
class Nothing:
    """The configuration of a study that does nothing."""


def has_the_style(figure):
    (axes, *_) = figure.axes
    return not axes.spines["top"].get_visible() and mpl.colors.same_color(
        axes.xaxis.label.get_color(), palette.BLACK
    )


def test_figure_has_the_style_and_leaves_the_users_own(joints, panda):
    before = dict(mpl.rcParams)
    assert has_the_style(plot.limits_figure(joints, panda.limits))
    assert dict(mpl.rcParams) == before


def test_figures_of_a_study_have_the_style(tmp_path):
    def report(config, rows):
        figure = Figure()
        figure.subplots()
        return study.Report(table=[], figures={"one": figure})

    small = study.Study(configure=None, tasks=lambda _: [], report=report)
    outcome = study.run(small, Nothing(), out=tmp_path)
    assert has_the_style(outcome.report.figures["one"])


def test_colours_of_the_cycle_differ():
    colours = np.array([palette.rgb(colour) for colour in palette.CYCLE])
    gaps = np.linalg.norm(colours[:, None] - colours[None], axis=2) + np.eye(len(colours))
    assert gaps.min() > 0.2


def test_the_style_for_figures_of_ones_own_has_the_colours_of_the_palette():
    with mpl.style.context("leadthrough.drawing.figures"):
        cycle = mpl.rcParams["axes.prop_cycle"].by_key()["color"]
        assert tuple(cycle) == palette.CYCLE
        assert mpl.rcParams["text.color"] == palette.BLACK


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
def test_motion_is_drawn_in_the_pages_own_colour_and_in_few_bytes(motion):
    page = ElementTree.fromstring(motion._repr_html_())
    (picture,) = page.iter(f"{SVG}svg")
    text = ElementTree.tostring(picture, encoding="unicode")
    assert "currentColor" in text and palette.BLACK not in text
    assert not re.search(r"\b(nan|inf)\b", text.lower())
    assert len(text) < 60_000
    assert isinstance(motion.plot(), Figure)
    assert len(repr(motion).splitlines()) <= 5


def test_lines_lie_within_their_axes():
    for motion in motions():
        for axes in motion.plot().axes:
            for line in axes.lines:
                inside = axes.transData.transform(line.get_xydata())
                assert axes.bbox.padded(1e-6).count_contains(inside) == len(inside)


def test_texts_of_users_are_escaped():
    page = ElementTree.fromstring(motions()[1]._repr_html_())
    assert "close <gripper>" in [text.text for text in page.iter(f"{SVG}text")]


def test_names_leave_out_the_parts_that_all_have_in_common():
    assert panels.short_names(["robot_joint_1_drive", "robot_joint_10_drive"]) == ["1", "10"]
    assert panels.short_names(["shoulder", "elbow"]) == ["shoulder", "elbow"]
    assert panels.short_names(["a", "a"]) == ["a", "a"]
    assert panels.short_names(["joint11", "joint12"]) == ["11", "12"]


def test_band_is_two_deviations_wide_in_the_colour_of_its_line():
    columns, deviations = np.zeros((50, 1)), np.full((50, 1), 0.25)
    panel = panels.over(T[:50], columns, ["x"], title="t", deviations=deviations)
    (axes,) = figure_of([panel]).axes
    (band,) = axes.collections
    assert np.ptp(band.get_paths()[0].vertices[:, 1]) == 1.0
    assert mpl.colors.same_color(band.get_facecolor()[0, :3], axes.lines[0].get_color())


def test_bars_beyond_the_limit_have_another_colour():
    panel = panels.bars([("a", 0.0, 0.9), ("b", 0.0, 1.2)], title="t", x_label="x", limit=1.0)
    (axes,) = figure_of([panel]).axes
    within, beyond, *_ = axes.lines
    assert within.get_color() != beyond.get_color()
    assert [label.get_text() for label in axes.get_yticklabels()] == ["a", "b"]


def test_a_constant_column_is_drawn_flat():
    noise = 0.3 + 1e-13 * np.sin(50.0 * T)
    (axes,) = figure_of([panels.over(T, noise[:, None], ["x"], title="t")]).axes
    assert np.ptp(axes.get_ylim()) > 0.1


def test_report_without_anything_to_draw_shows_its_text():
    _, report = lt.preprocess.clean(lt.Trajectory(T, np.sin(T)[:, None]))
    assert "5000 samples read" in report._repr_html_()
    assert "<svg" not in report._repr_html_()
    refused("nothing to draw", report.plot)


def test_arms_and_reports_are_drawn_too():
    arm = lt.Arm.load("ur3")
    q = np.array([0.0, -1.2, 1.4, -1.7, -1.5, 0.3])
    joints = lt.JointTrajectory([0.0, 0.5, 1.0], [q, q + 0.1, q + 0.2], joint_names=arm.joint_names)
    poses = arm.poses(joints)
    reports = (lt.check_limits(joints, arm.limits), arm.path_report(joints, poses))
    for each in (arm, *reports, arm.check(joints, [lt.Sphere(0.1, (0.0, 0.0, 2.0))])):
        assert "<svg" in each._repr_html_()
        assert isinstance(each.plot(), Figure)
