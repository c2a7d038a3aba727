"""Both pages in headless Chromium: they draw, move, and answer to the mouse."""

import io
import json
import re
import time
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image
from show.conftest import places_at

import leadthrough as lt
from leadthrough.show import open_view, page
from leadthrough.show.arm_scene import arm_scene, readouts

OFF = 0.002  # m that a wanted path lies above
BOX = lt.Box((0.1, 0.1, 0.3), (0.55, 0.0, 0.15))
SIZE = {"width": 640, "height": 400}
PATIENCE = 60.0  # s, for software rendering on a busy machine
PARTS = "".join(
    [
        page.contents(["One"]),
        page.heading("One"),
        page.text("Text."),
        page.legend({"shown": "#8a94a0", "made": "#1d2733"}, dashed=["made"]),
        page.gallery([page.figure(Figure(), "a figure")]),
        page.table(["a", "b"], [[1, 2]]),
        page.terms({"a": "the first"}),
    ]
)
ANGLES = "[...leadthrough.scenes[0].links.at(-1)].map((x) => +x.toFixed(6))"


def picture(tab):
    return np.asarray(Image.open(io.BytesIO(tab.screenshot())).convert("RGB"), float)


def share_that_changed(before, after):
    return float((np.abs(before - after).max(axis=2) > 12).mean())


def has_colour(image, colour, tolerance=45):
    return bool((np.abs(image - np.array(colour)).max(axis=2) < tolerance).any())


def until(condition):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.02)


@contextmanager
def opened(browser):
    """A page in which no script fails."""
    context = browser.new_context(viewport=SIZE)
    tab = context.new_page()
    tab.set_default_timeout(1e3 * PATIENCE)
    problems = []
    tab.on("pageerror", lambda error: problems.append(str(error)))
    yield tab
    context.close()
    assert problems == []


@pytest.fixture(scope="module")
def moving(panda, shown):
    motion = lt.DMP().fit(shown).generate(dt=0.05)
    joints = panda.follow(motion)
    drawn = arm_scene(
        panda, joints, demonstrations=shown, obstacles=[BOX], goal=motion.positions[-1]
    )
    beside = motion.positions + np.array([0.0, 0.0, OFF])
    return replace(drawn, readouts=readouts(panda, joints, lt.Scene([BOX]), beside))


@pytest.fixture(scope="module")
def html(browser, moving, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "a.html"
    page.write_page(path, "Panda", page.scene(moving), whole=True)
    asked = []
    with opened(browser) as tab:
        tab.on("request", lambda request: asked.append(request.url))
        tab.goto(path.as_uri())
        tab.wait_for_function("leadthrough.scenes.length && leadthrough.scenes[0].frames > 0")
        tab.evaluate("leadthrough.scenes[0].play(false)")
        yield tab
    assert [url for url in asked if not url.startswith(("file:", "blob:"))] == []


def seek(tab, time):
    tab.evaluate(f"leadthrough.scenes[0].seek({time})")
    tab.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def test_file_shows_the_arm_the_path_and_the_controls(html):
    image = picture(html)
    assert has_colour(image, (0, 114, 178))  # the path
    assert has_colour(image, (220, 222, 224))  # the arm's shell
    assert has_colour(image, (0, 158, 115), 60)  # the goal
    for name in ("play", "time", "clock", "speed", "home"):
        assert html.locator(f".{name}").is_visible()
    layers = html.locator(".layers label").all_inner_texts()
    assert layers == ["arm", "demonstrations", "path", "start", "obstacles", "goal", "clearance"]


def test_arm_in_the_file_moves_as_the_scene_says(html, moving):
    seek(html, 0.0)
    first = picture(html)
    seek(html, 2.5)
    assert share_that_changed(first, picture(html)) > 0.02
    columns = np.array(html.evaluate(ANGLES)).reshape(4, 4)
    position = places_at(moving, 2.5)
    assert np.allclose(columns[3, :3], position[-1], atol=1e-4)


def test_play_goes_on_and_the_slider_follows(html):
    seek(html, 0.0)
    html.locator(".play").click()
    html.wait_for_function("leadthrough.scenes[0].time > 0.2")
    html.locator(".play").click()
    assert float(html.locator(".time").input_value()) > 0.2
    assert re.match(r"\d\.\d\d / \d+\.\d\d s", html.locator(".clock").inner_text())


def test_frames_that_move_are_drawn_in_few_pixels_in_software_and_still_ones_in_all(html):
    html.evaluate("leadthrough.scenes[0].pace = begun(BY_PROCESSOR)")
    html.evaluate("leadthrough.scenes[0].play(true)")
    html.wait_for_function("leadthrough.scenes[0].canvas.width < 640")
    html.evaluate("leadthrough.scenes[0].play(false)")
    html.wait_for_function("leadthrough.scenes[0].canvas.width === 640")


def test_frame_over_what_was_kept_is_the_frame_that_is_drawn_whole(html):
    apart = html.evaluate(
        """() => {
          const scene = leadthrough.scenes[0], painter = scene.painter, gl = painter.gl;
          const pixels = () => {
            scene.draw(WAYS.findIndex((way) => way.blur < 0));
            const seen = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
            const whole = [0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight];
            gl.readPixels(...whole, gl.RGBA, gl.UNSIGNED_BYTE, seen);
            return seen;
          };
          scene.seek(0.0);
          pixels();
          scene.seek(1.0);
          const kept = pixels();
          painter.resting = "";
          painter.keep = (size, items, where) => painter.rest(null, size, items, where);
          const whole = pixels();
          delete painter.keep;
          scene.changed();
          return kept.reduce((most, each, i) => Math.max(most, Math.abs(each - whole[i])), 0);
        }"""
    )
    assert apart <= 2  # of 255


def test_scene_out_of_sight_is_not_drawn(html):
    html.evaluate("leadthrough.scenes[0].play(true)")
    html.evaluate("leadthrough.scenes[0].element.style.display = 'none'")
    html.wait_for_function("leadthrough.scenes[0].unseen && !leadthrough.scenes[0].waiting")
    drawn = html.evaluate("leadthrough.scenes[0].frames")
    html.evaluate("leadthrough.scenes[0].changed()")
    html.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    assert html.evaluate("leadthrough.scenes[0].frames") == drawn
    html.evaluate("leadthrough.scenes[0].element.style.display = ''")
    html.wait_for_function(f"leadthrough.scenes[0].frames > {drawn + 1}")
    html.evaluate("leadthrough.scenes[0].play(false)")


def ways(tab, costs, *, frames, begin=0):
    """The ways in which frames are drawn one after the other, by what each takes, ms.

    A frame is shown with the next of the 60 of a second.
    """
    return tab.evaluate(
        """([costs, frames, begin]) => {
          let pace = begun(begin);
          return Array.from({ length: frames }, () => {
            pace = paced(pace, Math.max(1, Math.ceil(costs[pace.way] / FRAME)) * FRAME);
            return pace.way;
          });
        }""",
        [costs, frames, begin],
    )


def test_frames_are_drawn_in_the_finest_way_that_keeps_up(html):
    count = html.evaluate("WAYS.length")
    ratios = [way["ratio"] for way in html.evaluate("WAYS")]
    assert ratios == sorted(ratios, reverse=True)
    for quick in range(count):
        costs = [40.0] * quick + [12.0] * (count - quick)
        seen = ways(html, costs, frames=3600)
        # Now and then the finer one is tried.
        assert seen[120:].count(quick) > 0.95 * len(seen[120:])
        assert seen[-1200:].count(quick - 1) < 20
        assert set(seen) <= set(range(quick + 1))


def test_machine_that_keeps_up_or_that_nothing_helps_gets_frames_in_full(html):
    count = html.evaluate("WAYS.length")
    assert set(ways(html, [16.0] * count, frames=3600)) == {0}
    seen = ways(html, [33.0] * count, frames=3600)  # a screen of 30 Hz
    assert seen.count(0) > 0.9 * len(seen)


def test_one_stall_is_forgiven_and_a_way_that_has_become_quick_is_taken_again(html):
    count = html.evaluate("WAYS.length")
    assert html.evaluate("paced(paced(begun(0), 900), 16.6).way") == 0
    assert html.evaluate("paced(begun(0), 60000).owed") == 0  # the window was out of sight
    assert ways(html, [12.0] * count, frames=2400, begin=count - 1)[-1] == 0


def test_slider_sets_the_time(html):
    html.locator(".time").fill("1.5")
    assert html.evaluate("leadthrough.scenes[0].time") == pytest.approx(1.5)
    assert html.evaluate("leadthrough.scenes[0].playing") is False


def test_mouse_orbits_and_zooms(html):
    before = picture(html)
    html.mouse.move(320, 200)
    html.mouse.down()
    html.mouse.move(470, 230, steps=3)
    html.mouse.up()
    html.wait_for_function("leadthrough.scenes[0].azimuth < -1.5")
    near = html.evaluate("leadthrough.scenes[0].distance")
    html.mouse.wheel(0, -300)
    html.wait_for_function(f"leadthrough.scenes[0].distance < {0.8 * near}")
    assert share_that_changed(before, picture(html)) > 0.05


def test_keys_turn_zoom_and_play(html):
    html.locator("canvas").focus()
    azimuth, distance = html.evaluate(
        "[leadthrough.scenes[0].azimuth, leadthrough.scenes[0].distance]"
    )
    for key in ("ArrowRight", "+", " "):
        html.keyboard.press(key)
    seen = html.evaluate(
        "(({azimuth, distance, playing}) => [azimuth, distance, playing])(leadthrough.scenes[0])"
    )
    html.keyboard.press(" ")
    assert seen[0] < azimuth and seen[1] < distance and seen[2]


def test_a_click_on_the_path_goes_to_that_time_and_one_beside_it_nowhere(html, moving):
    html.evaluate("leadthrough.scenes[0].home()")
    seek(html, 0.0)
    for at in (1.0, 2.6):
        tip = places_at(moving, at)
        x, y, _ = html.evaluate(f"leadthrough.scenes[0].onCanvas({tip[moving.tip].tolist()})")
        html.mouse.click(x, y)
        assert html.evaluate("leadthrough.scenes[0].time") == pytest.approx(at, abs=0.1)
    html.mouse.click(20, 200)
    assert html.evaluate("leadthrough.scenes[0].time") == pytest.approx(2.6, abs=0.1)


def test_curves_and_the_nearest_pair_are_those_of_the_time_shown(html, moving):
    told = moving.readouts
    chosen = html.locator("select.figure")
    assert html.locator(".curves").is_hidden()
    at = 0.5 * told["times"][-1]
    seek(html, at)
    i = int(np.argmin(np.abs(np.array(told["times"]) - at)))
    near, own = told["pairs"]
    texts = html.locator(".pairs text").all_text_contents()
    assert texts == [f"{1000 * pair['distance'][i]:.0f} mm" for pair in (near, own)]
    ends = [float(html.locator(".pairs line").first.get_attribute(name)) for name in ("x1", "y1")]
    point = html.evaluate(f"leadthrough.scenes[0].onCanvas({near['points'][i][:3]})")
    np.testing.assert_allclose(ends, point[:2], atol=0.2)
    reading = html.locator(".reading").inner_text()
    assert near["bodies"][i] in reading
    off = float(re.search(r"m/s, ([\d.]+) mm off its path", reading)[1])
    assert off == pytest.approx(1e3 * told["error"][i], abs=0.051)
    assert 0.0 < off <= 1e3 * OFF + 0.1
    for name, rows, lines in (
        ("positions, rad", told["positions"], 0),
        ("velocities, share of limits", np.array(told["velocities"]) / np.c_[told["limits"][2]], 2),
    ):
        chosen.select_option(name)
        assert html.locator(".curves polyline").count() == 7
        assert html.locator(".curves .limit").count() == lines
        values = [float(x.split()[-1]) for x in html.locator(".curves span").all_inner_texts()]
        np.testing.assert_allclose(values, np.array(rows)[:, i], atol=0.0051)
    box = html.locator(".curves svg").bounding_box()
    html.mouse.click(box["x"] + 0.25 * box["width"], box["y"] + 20)
    assert html.evaluate("leadthrough.scenes[0].time") == pytest.approx(0.5 * at, rel=0.02)
    now = float(html.locator(".curves .now").get_attribute("x1"))
    assert now == pytest.approx(250, abs=10)
    html.locator(".layers input[name=clearance]").uncheck()
    seek(html, at)
    assert html.locator(".pairs line").first.is_hidden()
    html.locator(".layers input[name=clearance]").check()
    chosen.select_option("")
    assert html.locator(".curves").is_hidden()


def test_keys_work_without_the_focus_on_the_scene(html):
    html.evaluate("document.activeElement.blur()")
    html.keyboard.press("ArrowLeft")
    assert html.evaluate("leadthrough.scenes[0].azimuth") != pytest.approx(-0.85)
    html.keyboard.press("Home")
    assert html.evaluate("leadthrough.scenes[0].azimuth") == pytest.approx(-0.85)
    html.keyboard.press(" ")
    assert html.evaluate("leadthrough.scenes[0].playing")
    html.keyboard.press(" ")
    assert not html.evaluate("leadthrough.scenes[0].playing")


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_page_can_be_used_by_screen_reader_keyboard_and_in_the_dark(html, scheme):
    rules = pytest.importorskip("axe_playwright_python", reason="axe is not installed")
    html.emulate_media(color_scheme=scheme)
    html.add_script_tag(path=Path(rules.__file__).parent / "axe.min.js")
    html.evaluate(
        f"document.querySelector('main').insertAdjacentHTML('beforeend', {json.dumps(PARTS)})"
    )
    broken = html.evaluate("axe.run()")["violations"]
    assert [rule for rule in broken if rule["impact"] in ("serious", "critical")] == []


def test_nothing_is_wider_than_a_phone(html):
    html.set_viewport_size({"width": 390, "height": 844})
    assert html.evaluate("document.documentElement.scrollWidth") <= 390
    html.set_viewport_size(SIZE)


def test_layer_is_hidden_by_its_box(html):
    before = picture(html)
    html.locator(".layers input[name=arm]").uncheck()
    seek(html, 0.0)
    assert share_that_changed(before, picture(html)) > 0.05


@pytest.fixture(scope="module")
def live(panda, shown):
    view = open_view(panda, scene=[BOX], demonstrations=shown, skill=lt.DMP().fit(shown))
    yield view
    view.close()


@pytest.fixture(scope="module")
def window(browser, live):
    with opened(browser) as tab:
        tab.goto(live.url)
        tab.get_by_text("planned in").wait_for()
        until(lambda: has_colour(picture(tab), (0, 114, 178), 70))
        yield tab


def test_live_page_shows_the_arm_and_the_controls_and_plays(window):
    for label in ("duration, s", "weights", "obstacles"):
        assert window.get_by_text(label, exact=True).is_visible()
    assert window.locator(".play").get_attribute("aria-label") == "pause"
    before = picture(window)
    until(lambda: share_that_changed(before[:, 320:], picture(window)[:, 320:]) > 0.01)


def test_dragged_obstacle_replans_and_is_turned(window, live):
    window.evaluate("leadthrough.scenes[0].play(false)")
    before = live.answer
    ring = window.locator(".handle.obstacle").bounding_box()
    x, y = ring["x"] + 0.5 * ring["width"], ring["y"] + 0.5 * ring["height"]
    window.mouse.move(x, y)
    window.mouse.down()
    window.mouse.move(x, y - 30, steps=8)
    window.mouse.up()
    until(lambda: live.session.scene.shapes[0].position[2] > 0.25 and live.session.idle)
    (shape,) = live.session.scene.shapes
    assert not np.array_equal(live.answer.path[: len(before.path)], before.path)
    window.locator(".turning").click()
    window.locator(".handle.obstacle").press("ArrowRight")
    until(lambda: abs(live.session.scene.shapes[0].orientation[0]) < 0.9999)
    np.testing.assert_allclose(live.session.scene.shapes[0].position, shape.position)
    window.locator(".turning").click()
    until(lambda: live.session.idle)


def test_sliders_of_the_duration_and_of_weights_replan(window, live):
    for index, value in ((0, "5"), (1, "9")):
        before = live.answer
        window.locator(".sliders input").nth(index).fill(value)
        until(lambda before=before: live.answer is not before and live.answer.verdict)
    assert live.answer.joints.duration == pytest.approx(5.0, abs=0.1)
    assert len(live.session.planner.skill.system.weights) == 9
