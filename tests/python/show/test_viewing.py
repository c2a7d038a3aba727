"""The command and the function that open a view."""

import base64
import html
import json
import re
import subprocess
import sys
import threading
import time
import warnings
import zlib

import numpy as np
import pytest
from cli.command_line import run
from matplotlib.figure import Figure
from refusals import refused
from urdfs import CUBE, one_joint

import leadthrough as lt
from leadthrough.drawing import palette
from leadthrough.errors import InvalidInput, MissingDependency
from leadthrough.sanity import ImplausibleInputWarning
from leadthrough.show import inline, open_view, page, view
from leadthrough.show.arm_scene import arm_scene


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


def test_live_view_without_websockets_names_the_extra(panda, monkeypatch):
    monkeypatch.setitem(sys.modules, "websockets", None)
    with pytest.raises(
        MissingDependency, match=r"websockets is not installed.*leadthrough\[view\]"
    ):
        view(panda)


def test_pages_of_an_arm_a_skill_and_a_motion_are_written_without_websockets(
    panda, shown, monkeypatch, tmp_path
):
    monkeypatch.setitem(sys.modules, "websockets", None)
    for number, content in enumerate(({}, {"skill": lt.DMP().fit(shown)})):
        view(panda, **content, html=tmp_path / f"{number}.html")
    view(panda, shown[0].motion, html=tmp_path / "tip.html")
    assert len(list(tmp_path.iterdir())) == 3


def test_page_is_written_by_a_new_process_without_websockets(tmp_path):
    script = """
import sys
sys.modules["websockets"] = None
import leadthrough as lt
lt.show.view(lt.Arm.load("panda"), html=sys.argv[1])
"""
    subprocess.run([sys.executable, "-c", script, tmp_path / "arm.html"], check=True)
    assert (tmp_path / "arm.html").stat().st_size > 50_000


def test_notebook_shows_the_page_that_view_writes(panda, tmp_path):
    view(panda, html=tmp_path / "a.html")
    shown = inline(panda, height=300)
    assert shown.document == (tmp_path / "a.html").read_text()
    (inside,) = re.findall('srcdoc="([^"]*)"', shown._repr_html_())
    assert html.unescape(inside) == shown.document
    assert "300px" in shown._repr_html_()
    assert len(repr(shown)) < 200


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
        opened.session.request(lambda planner: planner.goal.move((0.5, 0.3, 0.25)))
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


def test_an_arm_must_be_given_and_a_scene_have_a_height(panda):
    refused("height: expected", inline, panda, height=0)
    for shows in [inline, open_view, view]:
        refused(r"arm: expected an Arm, got 'ur3'.*lt\.Arm\.load", shows, "ur3")


def unpacked(text):
    content = zlib.decompress(base64.b64decode(text))
    length = int.from_bytes(content[:4], "little")
    head = json.loads(content[4 : 4 + length])
    body = content[4 + length :]
    arrays = [
        np.frombuffer(body, entry["kind"], entry["count"], entry["offset"])
        for entry in head["arrays"]
    ]
    return head, arrays


@pytest.fixture
def made(panda, joints):
    return arm_scene(panda, joints, goal=(0.5, 0, 0.5))


def test_page_holds_the_scene(made, tmp_path):
    page.write_page(tmp_path / "a.html", "A & B", page.scene(made), whole=True)
    text = (tmp_path / "a.html").read_text()
    assert "<title>A &amp; B</title>" in text
    (data,) = re.findall(r'<script type="text/plain">(.*?)</script>', text)
    head, arrays = unpacked(data)
    poses = arrays[head["poses"]].reshape(30, len(made.links), 7)
    assert np.allclose(poses[..., :3], made.positions, atol=1e-5)
    assert np.allclose(poses[..., 3:], made.orientations, atol=1e-5)
    assert [item["name"] for item in head["items"]] == [item.name for item in made.items]
    for item in head["items"]:
        assert arrays[item["faces"]].max() < arrays[item["vertices"]].size / 3
        assert arrays[item["normals"]].size == arrays[item["vertices"]].size


def test_links_of_the_same_mesh_file_share_its_arrays_on_the_page(tmp_path):
    """As the two arms of YuMi, whose page had all of them twice."""
    (tmp_path / "part.obj").write_text(CUBE + "f 1 2 3\nf 2 4 3\n")
    mesh = '<geometry><mesh filename="part.obj"/></geometry>'
    joint = '<joint name="k" type="fixed"><parent link="b"/><child link="c"/></joint>'
    document = one_joint(link=f"<visual>{mesh}</visual>").replace(
        "<joint", f'<link name="c"><visual>{mesh}</visual></link>{joint}<joint', 1
    )
    arm = lt.Arm.from_urdf(document, tip="c", mesh_folders=[tmp_path])
    motion = lt.JointTrajectory([0.0, 1.0], [[0.0], [1.0]])
    head, _ = unpacked(page.packed(arm_scene(arm, motion)))
    one, other = head["items"][:2]
    assert (one["name"], other["name"]) == ("b", "c")
    for name in ("vertices", "normals", "faces"):
        assert one[name] == other[name]


def test_page_asks_for_nothing_from_elsewhere(made, tmp_path):
    page.write_page(tmp_path / "a.html", "A", [page.scene(made), page.figure(Figure())])
    text = re.sub(r"<!DOCTYPE[^>]*>|xmlns(:\w+)?=\"[^\"]*\"", "", (tmp_path / "a.html").read_text())
    assert not re.findall(r'(?:src|href)="(?!#)|@import|url\((?!#)|fetch\(', text)


def test_text_of_a_page_is_not_taken_for_markup():
    assert page.text("a < b") == "<p>a &lt; b</p>"
    assert "<td>&lt;i&gt;</td>" in page.table(["x"], [["<i>"]])


def test_figure_is_seen_on_light_and_dark_pages():
    figure = Figure()
    figure.subplots().plot([0, 1], color=palette.BLACK)
    drawn = page.figure(figure, "a line")
    assert palette.BLACK not in drawn and "currentColor" in drawn and "fill: #ffffff" not in drawn
    assert 'role="img" aria-label="a line"' in drawn


def test_contents_lead_to_headings():
    (link,) = re.findall('href="#(.*?)"', page.contents(["At a glance"]))
    assert f'id="{link}"' in page.heading("At a glance")


def test_view_writes_a_file_and_opens_nothing(panda, tmp_path, monkeypatch):
    monkeypatch.setattr("webbrowser.open", lambda _: pytest.fail("a page was opened"))
    view(panda, html=tmp_path / "still.html")
    assert (tmp_path / "still.html").stat().st_size > 50_000


def test_page_that_cannot_be_written_leaves_nothing(panda, tmp_path):
    refused("no such folder", view, panda, html=tmp_path / "none" / "a.html")
    assert not list(tmp_path.iterdir())


def test_another_arm_than_the_one_shown_is_warned_of(panda):
    u = np.linspace(0.0, 1.0, 50)
    way = np.outer(lt.trajectories.minimum_jerk_time_scaling(u), np.full(7, 0.3))
    rows = np.array([0, 0, 0, -1.5, 0, 1.5, 0]) + way
    turn = lt.JointTrajectory(2.0 * u, rows, joint_names=panda.joint_names)
    skill = lt.DMP().fit([panda.poses(turn)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        inline(panda, skill=skill)
    with pytest.warns(ImplausibleInputWarning, match="robot: .* tip is up to 0.1 m from"):
        inline(panda.with_tool((0.0, 0.0, 0.1)), skill=skill)
