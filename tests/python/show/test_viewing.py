"""The command and the function that open a view."""

import html
import re
import sys
import threading
import time

import pytest
from cli.command_line import run
from refusals import refused
from urdfs import one_joint

import leadthrough as lt
from leadthrough.errors import InvalidInput, MissingDependency
from leadthrough.show import inline, open_view, view


@pytest.fixture
def recording(joints, tmp_path):
    path = tmp_path / "motion.csv"
    lt.io.write_motion(joints, path)
    return path


def test_command_writes_a_page(recording, shown, tmp_path):
    lt.DMP().fit(shown).save(tmp_path / "skill.npz")
    out = tmp_path / "out.html"
    shows = ("--demonstrations", recording, "--skill", tmp_path / "skill.npz", "--html", out)
    said = run("view", recording, "--robot", "panda", *shows, "--obstacle", "sphere:0.1@1,0,0.5")
    assert str(out) in said.output.replace("\n", "")
    assert "obstacles" not in said.output
    assert out.stat().st_size > 50_000


@pytest.mark.parametrize(
    "wrong",
    [["--robot", "hal"], ["--obstacle", "box:1,1@0,0,0"], ["nothing.csv"], ["--port", "-1"]],
)
def test_wrong_arguments_are_an_error_of_one_line(wrong):
    arguments = ["view", *wrong] if wrong[0] == "--port" else ["view", *wrong, "--html", "x.html"]
    result = run(*arguments, code=2)
    assert len(result.output.strip().splitlines()) == 1


def test_live_view_without_viser_names_the_extra(panda, monkeypatch):
    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(MissingDependency, match=r"viser is not installed.*leadthrough\[view\]"):
        view(panda)


def test_pages_of_an_arm_a_skill_and_a_motion_are_written_without_viser(
    panda, shown, monkeypatch, tmp_path
):
    monkeypatch.setitem(sys.modules, "viser", None)
    for number, content in enumerate(({}, {"skill": lt.DMP().fit(shown)})):
        view(panda, **content, html=tmp_path / f"{number}.html")
    view(panda, shown[0].motion, html=tmp_path / "tip.html")
    assert len(list(tmp_path.iterdir())) == 3


def test_notebook_shows_the_page_that_view_writes(panda, tmp_path):
    view(panda, html=tmp_path / "a.html")
    shown = inline(panda, height=300)
    assert shown.document == (tmp_path / "a.html").read_text()
    (inside,) = re.findall('srcdoc="([^"]*)"', shown._repr_html_())
    assert html.unescape(inside) == shown.document
    assert "300px" in shown._repr_html_()
    assert len(repr(shown)) < 200


def test_scene_of_a_notebook_has_a_height(panda):
    refused("height: expected", inline, panda, height=0)


def test_skill_that_the_arm_cannot_follow_is_refused(panda, shown, tmp_path):
    with pytest.raises(InvalidInput, match="no motion that the arm can follow"):
        view(panda, skill=lt.DMP().fit(shown), goal=(3, 0, 0), html=tmp_path / "a.html")
    assert not list(tmp_path.iterdir())


def test_live_view_is_served_until_it_is_closed(panda, capfd):
    opened = open_view(panda)
    try:
        assert opened.url.startswith("http://127.0.0.1:")
        assert opened.answer is None
    finally:
        opened.close()
    opened.wait()
    assert capfd.readouterr().out == ""


def test_live_view_opens_with_a_goal_out_of_reach_tells_it_and_goes_on(panda, shown):
    skill = lt.DMP().fit(shown)
    opened = open_view(panda, skill=skill, goal=(1.4, 0.3, 0.3))
    try:
        assert until(lambda: opened.answer is not None)
        assert "beyond the arm's reach" in opened.answer.trouble
        opened.request(lambda: opened._planner.move_goal((0.5, 0.3, 0.25)))
        assert until(lambda: opened.answer.verdict)
        assert opened.answer.joints is not None
    finally:
        opened.close()


def until(condition):
    end = time.monotonic() + 30.0
    while time.monotonic() < end and not condition():
        threading.Event().wait(0.05)
    return condition()


def test_page_tells_which_mesh_cannot_be_shown(tmp_path):
    mesh = '<visual><geometry><mesh filename="none.stl"/></geometry></visual>'
    view(lt.Arm.from_urdf(one_joint(link=mesh)), html=tmp_path / "a.html")
    assert (
        "link b: mesh: none.stl is not found; it is left out" in (tmp_path / "a.html").read_text()
    )


@pytest.mark.parametrize("shows", [inline, open_view, view])
def test_an_arm_must_be_given(shows):
    refused(r"arm: expected an Arm, got 'ur3'.*lt\.Arm\.load", shows, "ur3")
