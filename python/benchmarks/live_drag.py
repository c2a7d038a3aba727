"""Times from the mouse to the scene while an obstacle is dragged on the live page, in a browser.

A box beside the way of a Panda is dragged to and fro through it, so that path and arm give way.
The page itself takes the times, by its own clock: from the event of the mouse to the remark that
the server sends after the path and the arm of a preview. Needs Chromium and Playwright.
"""

from __future__ import annotations

import shutil
import time
from typing import Any

import numpy as np
from playwright.sync_api import Page, sync_playwright

import leadthrough as lt
from leadthrough.show import open_view

SIZE = {"width": 640, "height": 400}
FLAGS = [
    "--no-sandbox",
    "--ignore-gpu-blocklist",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]
BOX = lt.Box((0.1, 0.1, 0.1), (0.45, 0.0, 0.12))
ENDS = np.array([[0.4, -0.38, 0.18], [0.5, 0.36, 0.22]])
PIXELS = 40  # of the way to and fro
PAUSE = 0.05  # s between moves of the mouse
MAX_WAIT = 1.0  # s
_WATCH = """() => {
  window.moved = []; window.told = [];
  addEventListener('pointermove', () => moved.push(performance.now()), true);
  new MutationObserver(() => {
    const found = document.body.innerText.match(/previewed in \\d+ ms/);
    if (found) told.push(performance.now());
  }).observe(document.body, {subtree: true, childList: true, characterData: true});
}"""


def latencies(moves: int) -> list[float]:
    """Times from the mouse to the scene, ms, of so many moves of a dragged box."""
    shown = demonstrations()
    skill = lt.FastMarching().fit(shown)
    view = open_view(lt.Arm.load("panda"), scene=[BOX], demonstrations=shown, skill=skill)
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=shutil.which("chromium"), args=FLAGS
            )
            tab = browser.new_page(viewport=SIZE)
            tab.goto(view.url)
            tab.get_by_text("planned in").wait_for(timeout=1e5)
            tab.locator(".handle.obstacle").wait_for(timeout=1e5)  # drawn in the next frame
            ring = tab.locator(".handle.obstacle").bounding_box()
            assert ring is not None
            place = ring["x"] + 0.5 * ring["width"], ring["y"] + 0.5 * ring["height"]
            found = _dragged(tab, place, moves)
            browser.close()
    finally:
        view.close()
    return found


def demonstrations() -> list[lt.Demonstration[Any]]:
    """Five hands carry something over a table."""
    rng = np.random.default_rng(1)
    times = np.linspace(0.0, 4.0, 200)
    s = lt.trajectories.minimum_jerk_time_scaling(times / 4.0)[:, None]
    arch = np.sin(np.pi * s) ** 2 * [0.0, 0.0, 1.0]
    turned = np.tile((0.0, 1.0, 0.0, 0.0), (len(times), 1))
    shown = []
    for _ in range(5):
        first, last = ENDS + rng.normal(0.0, 0.01, (2, 3))
        path = first + s * (last - first) + rng.normal(0.25, 0.03) * arch
        shown.append(lt.Demonstration(lt.PoseTrajectory(times, path, turned)))
    return shown


def _dragged(tab: Page, place: tuple[float, float], moves: int) -> list[float]:
    """Times of moves to and fro from a place, in pixels, with the button held down."""
    tab.evaluate(_WATCH)
    x, y = place
    tab.mouse.move(x, y, steps=4)
    tab.mouse.down()
    found = []
    for i in range(moves):
        tab.evaluate("moved.length = told.length = 0")
        tab.mouse.move(x + PIXELS * np.sin(0.2 * (i + 1)), y)
        waited = time.monotonic() + MAX_WAIT
        answered = None
        # The same remark twice changes nothing on the page: such a move is not counted.
        while answered is None and time.monotonic() < waited:
            answered = tab.evaluate("told.find((at) => at > moved[0]) - moved[0] || null")
        found += [] if answered is None else [float(answered)]
        time.sleep(PAUSE)
    tab.mouse.up()
    return found
