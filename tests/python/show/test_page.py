"""The HTML file: complete, on its own, and with the scene's numbers in it."""

import base64
import json
import re
import zlib

import numpy as np
import pytest
from matplotlib.figure import Figure
from refusals import refused

from leadthrough.drawing import palette
from leadthrough.show import page, view
from leadthrough.show.arm_scene import arm_scene


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
