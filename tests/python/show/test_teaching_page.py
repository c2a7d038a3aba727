"""`leadthrough teach`: the page in headless Chromium, its server, and the files that it leaves."""

import asyncio
import http.client
import json
import re
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from urllib.parse import urlsplit

import numpy as np
import pytest
from cli.command_line import run
from refusals import refused

import leadthrough as lt
from leadthrough.show import teach

pytest.importorskip("websockets", reason="websockets is not installed")
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

POST = lt.Box((0.1, 0.1, 0.4), (0.5, 0.35, 0.2))
SCENE = "leadthrough.scenes[0]"


@pytest.fixture
def taught(panda, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    page = teach(panda, [POST])
    yield page
    page.close()


def inside(coroutine):
    """The result of a coroutine; the thread of the tests may have an event loop of a browser."""
    with ThreadPoolExecutor(1) as thread:
        return thread.submit(asyncio.run, coroutine).result()


def get(page, path, **headers):
    address = urlsplit(page.url)
    connection = http.client.HTTPConnection(address.hostname, address.port, timeout=20)
    connection.request("GET", path, headers=headers)
    response = connection.getresponse()
    content = response.read()
    connection.close()
    return response.status, content, response.headers


def test_the_page_is_given_to_its_own_address_alone(taught):
    own = urlsplit(taught.url).path
    status, content, headers = get(taught, own)
    assert status == 200
    assert headers["Content-Type"] == "text/html; charset=utf-8"
    assert headers["Referrer-Policy"] == "no-referrer"
    assert len(content) < 300_000
    assert get(taught, f"{own}other")[0] == 404
    for path in ("/", "/live", "/wrong/", own[:-2] + "/"):
        assert get(taught, path)[0] == 403
    assert get(taught, own, Host="elsewhere.example")[0] == 403
    assert get(taught, own, Origin="http://elsewhere.example")[0] == 403


def test_other_pages_cannot_open_the_socket(taught):
    async def opened(**options):
        async with connect(taught.url.replace("http", "ws") + "live", proxy=None, **options) as one:
            return [json.loads(await one.recv())["kind"] for _ in range(3)]

    assert inside(opened()) == ["scene", "poses", "state"]
    with pytest.raises(InvalidStatus, match="403"):
        inside(opened(origin="http://elsewhere.example"))


def test_fifty_browsers_that_vanish_while_recording_lose_nothing(taught):
    async def crowd():
        url = taught.url.replace("http", "ws") + "live"
        every = [await connect(url, proxy=None) for _ in range(50)]
        await every[0].send('{"do": "record"}')
        for one in every:
            await one.send("nonsense")
            await one.send("x" * 5000)
        tip = taught.session.led.tip[0] + [0.0, -0.1, 0.0]
        await every[1].send(json.dumps({"do": "lead", "position": tip.tolist()}))
        await asyncio.sleep(1.0)
        for one in every:
            one.transport.abort()
        await asyncio.sleep(0.3)

    inside(crowd())
    end = time.monotonic() + 60.0  # s, on a busy machine
    while not (found := list(taught.session.recordings.folder.glob("[!.]*.csv"))):
        assert time.monotonic() < end, "nothing was kept"
        time.sleep(0.02)
    (path,) = found
    assert lt.read_motion(path).duration > 0.2


def test_a_port_that_is_taken_is_refused(taught, panda):
    refused("port", teach, panda, port=urlsplit(taught.url).port)


def ring(tab, kind):
    box = tab.locator(f".handle.{kind}").first.bounding_box()
    return box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]


def drag(tab, kind, *moves):
    """Drags a ring through moves of so many pixels."""
    x, y = ring(tab, kind)
    tab.mouse.move(x, y)
    tab.mouse.down()
    for dx, dy in moves:
        tab.mouse.move(x + dx, y + dy, steps=8)
        x, y = x + dx, y + dy
        tab.wait_for_timeout(350)
    tab.mouse.up()


def state(tab):
    return tab.evaluate(f"{SCENE}.state")


def press(tab, name):
    tab.get_by_role("button", name=name, exact=True).click()


def settled(tab, condition):
    tab.wait_for_function(f"(({{state, data}}) => {condition})({SCENE})")


def opened(browser, page, width, height):
    tab = browser.new_context(viewport={"width": width, "height": height}).new_page()
    tab.set_default_timeout(60_000)
    tab.problems = []
    tab.on("pageerror", lambda error: tab.problems.append(str(error)))
    tab.goto(page.url)
    tab.wait_for_function(f"leadthrough.scenes.length && {SCENE}.frames > 0 && {SCENE}.state.text")
    return tab


def record(tab, *moves):
    press(tab, "Record")
    settled(tab, "state.recording")
    drag(tab, "tip", *moves)
    press(tab, "Stop")
    settled(tab, "!state.recording")


@pytest.mark.parametrize(("width", "height"), [(1200, 800), (390, 844)])
def test_taught_learned_moved_corrected_saved_and_planned(browser, taught, panda, width, height):
    tab = opened(browser, taught, width, height)
    start = taught.session.led.tip[0]
    for k in range(2):
        record(tab, (-90, -30 - 5 * k), (-60, 70))
        settled(tab, f"state.demonstrations.length === {k + 1}")
        settled(tab, "data.times.length > 10 && Math.abs(data.times.at(-1) - "
                f"state.demonstrations[{k}].seconds) < 0.02")  # fmt: skip
    first, second = (
        each.motion for each in lt.read_demonstrations(taught.session.recordings.folder)
    )
    tips = [panda.forward_kinematics(each.positions)[0] for each in (first, second)]
    np.testing.assert_allclose(tips[1][0], start, atol=5e-3)  # it was grabbed where it was shown
    assert all(np.linalg.norm(each[-1] - start) > 0.1 for each in tips)

    press(tab, "Learn")
    settled(tab, "state.goal && /Clear/.test(state.text)")
    goal = np.array(state(tab)["goal"])
    np.testing.assert_allclose(goal, np.mean([each[-1] for each in tips], axis=0), atol=0.03)
    drag(tab, "goal", (30, -30))
    settled(tab, "/--goal=/.test(state.command) && /Clear/.test(state.text)")
    assert np.linalg.norm(np.array(state(tab)["goal"]) - goal) > 0.02

    begin = np.array(state(tab)["start"])
    drag(tab, "start", (-25, -25))
    settled(tab, "/--start=/.test(state.command) && /Clear/.test(state.text)")
    assert np.linalg.norm(np.array(state(tab)["start"]) - begin) > 0.02
    tab.evaluate(f"{SCENE}.play(false); {SCENE}.seek(0.5 * {SCENE}.duration)")
    tab.wait_for_timeout(100)
    drag(tab, "point", (0, -30))
    settled(tab, "state.corrections === 1 && /Clear/.test(state.text)")
    press(tab, "Save")
    settled(tab, "/The skill is in/.test(state.text)")
    assert "of its speed" in tab.locator(".reading").inner_text()
    program, *words = state(tab)["command"].split()
    run(*words, "--robot", "panda")
    run("retime", "motion.json", "--robot", "panda", "-o", "timed.json")
    run("check", "timed.json", "--robot", "panda")
    planned = lt.read_motion("motion.json")
    for row, name in ((0, "start"), (-1, "goal")):
        at = panda.forward_kinematics(planned.positions[row])[0]
        np.testing.assert_allclose(at, state(tab)[name], atol=1e-3)
    run("learn", "recorded", "--robot", "panda", "--model", "dmp", "-o", "again.npz")
    press(tab, "Save as LeRobot")
    settled(tab, "/The data set is in/.test(state.text)")
    _, *words = re.search(r"leadthrough learn .*", state(tab)["text"])[0].split()
    run(*words, "--robot", "panda", "--model", "dmp")
    assert program == "leadthrough"
    assert tab.problems == []
    tab.context.close()


def test_a_recording_is_named_trimmed_and_brought_back_on_the_page(browser, taught):
    tab = opened(browser, taught, 1200, 800)
    record(tab, (0, -60), (-40, 40))
    settled(tab, "state.shown[0] === 0 && data.times.length > 10")
    folder = taught.session.recordings.folder
    before = (folder / "demonstration-1.csv").read_bytes()
    field = tab.get_by_role("textbox", name="name of demonstration-1")
    field.fill("a/b")
    field.press("Enter")
    settled(tab, "/^name: /.test(state.text)")
    assert field.input_value() == "demonstration-1"
    field.fill("up and over")
    field.press("Enter")
    settled(tab, "state.demonstrations[0].name === 'up and over'")
    assert tab.evaluate("document.activeElement.value") == "up and over"
    tab.evaluate(f"{SCENE}.play(false); {SCENE}.seek(0.6 * {SCENE}.duration)")
    cut = tab.evaluate(f"{SCENE}.time")
    press(tab, "end at the time shown: up and over")
    settled(tab, f"Math.abs({SCENE}.duration - {cut}) < 1e-3 && {SCENE}.time === {SCENE}.duration")
    (path,) = folder.glob("*.csv")
    assert path.stem == "up and over"
    assert lt.read_motion(path).duration == pytest.approx(cut, abs=1e-3)
    assert tab.evaluate("document.documentElement.scrollWidth") <= 1200
    press(tab, "delete up and over")
    settled(tab, "!state.demonstrations.length")
    assert list(folder.iterdir()) == []
    press(tab, "Undo last change of the list")
    settled(tab, "state.demonstrations.length === 1 && state.shown[0] === 0")
    assert lt.read_motion(path).duration == pytest.approx(cut, abs=1e-3)
    assert path.read_bytes() != before
    assert tab.problems == []
    tab.context.close()


def drawn(tab):
    """All that a page shows of a motion, at half its duration."""
    tab.evaluate(f"{SCENE}.play(false); {SCENE}.seek(0.5 * {SCENE}.duration)")
    tab.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    layers = tab.locator(".layers label").all_inner_texts()
    return {
        "layers": sorted(layers),
        "links": tab.evaluate(f"{SCENE}.links.map((link) => [...link].map((x) => +x.toFixed(4)))"),
        "readouts": tab.evaluate(f"{SCENE}.data.readouts"),
        "reading": tab.locator(".reading").inner_text(),
        "clock": tab.locator(".clock").inner_text(),
        "lengths": tab.locator(".pairs text").all_text_contents(),
    }


def test_the_scene_that_was_saved_is_the_same_from_disk(browser, taught):
    tab = opened(browser, taught, 1200, 800)
    record(tab, (0, -60), (-40, 40))
    settled(tab, "state.demonstrations.length === 1")
    press(tab, "Learn")
    settled(tab, "state.goal && /lear by/.test(state.text) && data.readouts")
    press(tab, "Save")
    settled(tab, "/this scene in/.test(state.text)")
    live = drawn(tab)
    press(tab, "Save as LeRobot")
    settled(tab, "/The data set is in/.test(state.text)")
    (again,) = lt.read_demonstrations("recorded-lerobot")
    given = taught.session.demonstrations[0].motion
    assert again.motion.duration == pytest.approx(given.duration, abs=0.3)
    tab.goto(Path("skill.html").absolute().as_uri())
    tab.wait_for_function(f"leadthrough.scenes.length && {SCENE}.frames > 0")
    assert drawn(tab) == live
    clear = re.findall(r"-?\d+ mm (?!off)", live["reading"])
    assert live["lengths"] == [text.strip() for text in clear]
    assert re.search(r"m/s, 0\.\d mm off its path", live["reading"])
    assert tab.evaluate("document.documentElement.scrollWidth") <= 1200
    assert tab.problems == []
    tab.context.close()


def test_a_finger_on_a_phone_leads_the_arm_and_nothing_is_wider(browser, taught):
    tab = opened(browser, taught, 390, 844)
    assert tab.evaluate("document.documentElement.scrollWidth") <= 390
    before = taught.session.led.tip[0]
    record(tab, (60, -40))
    assert np.linalg.norm(taught.session.led.tip[0] - before) > 0.03
    tab.locator(".handle.tip").focus()
    settled(tab, "data.times.length > 10")
    for _ in range(3):
        tab.keyboard.press("ArrowUp")
        tab.wait_for_timeout(200)
    assert taught.session.led.tip[0][2] > before[2] + 0.01
    rules = pytest.importorskip("axe_playwright_python", reason="axe is not installed")
    tab.add_script_tag(path=Path(rules.__file__).parent / "axe.min.js")
    assert [each["id"] for each in tab.evaluate("axe.run()")["violations"]] == []
    assert tab.problems == []
    tab.context.close()
