"""All figures have one look, and matplotlib keeps the user's."""

from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.figure import Figure

import leadthrough as lt
from leadthrough.drawing import palette
from leadthrough.show import plot
from leadthrough_studies import study


@pytest.fixture(scope="module")
def panda():
    return lt.Arm.load("panda")


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


@pytest.mark.parametrize("draw", [plot.joint_figure, plot.limits_figure])
def test_figure_has_the_style_and_leaves_the_users_own(draw, joints, panda):
    before = dict(mpl.rcParams)
    assert has_the_style(draw(joints, panda.limits))
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
