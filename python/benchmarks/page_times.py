"""Times of a page from disk in a browser that draws in software: first paint, frame to frame.

The page is that of a Panda that carries an object past a box, as `leadthrough view --html` writes
it. The browser takes the times, by its own clock. Needs Chromium and Playwright.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from live_drag import BOX, FLAGS, demonstrations
from playwright.sync_api import Browser, sync_playwright

import leadthrough as lt
from leadthrough.show import view

SIZE = {"width": 1200, "height": 800}
SETTLED = 3000.0  # ms, in which a page has found how well it can draw
_PAINT = "performance.getEntriesByName('first-contentful-paint')[0].startTime"
_DRAWN = "window.leadthrough && leadthrough.scenes.length && leadthrough.scenes[0].frames > 0"
_FRAMES = """count => new Promise((done) => {
  const [scene] = leadthrough.scenes, times = [];
  scene.play(true);
  const frame = (now) => {
    times.push(now);
    if (times.length <= count) requestAnimationFrame(frame); else done(times);
  };
  requestAnimationFrame(frame);
})"""


def of_a_scene(loads: int, frames: int) -> tuple[list[float], list[float]]:
    """First paints of so many loads, and times from frame to frame while the scene plays, ms."""
    with tempfile.TemporaryDirectory() as folder, _browser() as browser:
        page = Path(folder) / "scene.html"
        _write(page)
        paints = [_paint(browser, page) for _ in range(loads)]
        tab = browser.new_page(viewport=SIZE)
        tab.goto(page.as_uri())
        tab.wait_for_function(_DRAWN)
        tab.wait_for_timeout(SETTLED)
        times = tab.evaluate(_FRAMES, frames)
    return paints, np.diff(times).tolist()


def _write(page: Path) -> None:
    arm, shown = lt.Arm.load("panda"), demonstrations()
    joints = lt.retime(arm.follow(lt.DMP().fit(shown).generate()), arm.limits, rate=100.0)
    view(arm, joints, scene=[BOX], demonstrations=shown, html=page)


def _paint(browser: Browser, page: Path) -> float:
    """The time to the first paint with content of a page that nothing was kept of, ms."""
    context = browser.new_context(viewport=SIZE)
    tab = context.new_page()
    tab.goto(page.as_uri())
    tab.wait_for_function(_DRAWN)
    taken = float(tab.evaluate(_PAINT))
    context.close()
    return taken


@contextmanager
def _browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        yield browser
        browser.close()
