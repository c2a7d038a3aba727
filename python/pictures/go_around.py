"""The README's moving picture: a box is dragged into a Panda's way, and the whole arm goes around.

Every frame is the product's own page in headless Chromium, every plan its own:
python python/pictures/go_around.py docs/go-around.webp
"""

import io
import shutil
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

import leadthrough as lt
from leadthrough.show import page
from leadthrough.show.animation import Animation
from leadthrough.show.arm_scene import arm_scene

SIZE = {"width": 800, "height": 500}
CAMERA = {"azimuth": -0.62, "elevation": 0.34, "distance": 2.0, "target": [0.3, 0.0, 0.3]}
SOFTWARE_RENDERING = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
RATE = 12.5  # frames per second
STEP = 0.5 / RATE  # s of the motion from frame to frame: half as fast as the arm may be
BOX = (0.10, 0.10, 0.38)  # m
FROM, TO = np.array((1.0, -0.55, 0.19)), np.array((0.54, -0.02, 0.19))
DRAGS = 12


def shown_by_hand() -> list[lt.Demonstration]:
    """Six slightly different demonstrations that carry an object over a table, flange down."""
    rng = np.random.default_rng(1)
    times = np.linspace(0.0, 3.0, 200)
    way = lt.trajectories.minimum_jerk_time_scaling(times / times[-1])
    result = []
    for _ in range(6):
        first, last = rng.normal([(0.40, -0.38, 0.22), (0.50, 0.36, 0.22)], 0.01)
        path = first + np.outer(way, last - first)
        path[:, 0] += rng.normal(0.08, 0.02) * np.sin(np.pi * way)
        path[:, 2] += rng.normal(0.12, 0.03) * np.sin(np.pi * way) ** 2
        turns = np.tile((0.0, 1.0, 0.0, 0.0), (len(times), 1))
        result.append(lt.Demonstration(lt.PoseTrajectory(times, path, turns)))
    return result


class Camera:
    """Takes frames of scenes, always from the same place."""

    def __init__(self, tab, folder: Path) -> None:
        self._tab, self._file = tab, folder / "scene.html"
        self.frames: list[Image.Image] = []

    def take(self, title: str, shown: Animation, times: Iterable[float]) -> None:
        page.write_page(self._file, title, page.scene(shown), whole=True)
        self._tab.goto(self._file.as_uri())
        self._tab.wait_for_function("leadthrough.scenes.length > 0")
        self._tab.evaluate("camera => Object.assign(leadthrough.scenes[0], camera)", CAMERA)
        for time in times:
            drawn = self._tab.evaluate(
                "t => { let [s] = leadthrough.scenes; s.play(false); s.seek(t); return s.frames }",
                float(time),
            )
            self._tab.wait_for_function(f"leadthrough.scenes[0].frames > {drawn}")
            self.frames.append(Image.open(io.BytesIO(self._tab.screenshot())).convert("RGB"))


def main(out: Path) -> None:
    arm, shown = lt.Arm.load("panda"), shown_by_hand()
    skill = lt.FastMarching().fit(shown)

    def drawn(box: lt.Box | None) -> Animation:
        obstacles = [] if box is None else [box]
        planned = lt.plan_motion(skill, arm, scene=lt.Scene(obstacles, margin=0.02))
        joints = lt.retime(planned.joints, arm.limits, path_tolerance=1e-3)
        assert arm.check(joints, obstacles).ok
        return arm_scene(arm, joints, demonstrations=shown, obstacles=obstacles)

    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=SOFTWARE_RENDERING
        )
        camera = Camera(browser.new_page(viewport=SIZE), Path(folder))
        free = drawn(None)
        camera.take("Shown by hand, six times", free, np.arange(0.0, free.times[-1], STEP))
        for k in range(DRAGS + 1):
            place = FROM + lt.trajectories.minimum_jerk_time_scaling(np.array(k / DRAGS)) * (
                TO - FROM
            )
            last = drawn(lt.Box(BOX, place))
            camera.take("A box is dragged into the way", last, [0.0])
        title = "The whole arm goes around, inside its limits"
        camera.take(title, last, np.arange(0.0, last.times[-1], STEP))
        camera.frames += [camera.frames[-1]] * round(RATE)
        browser.close()
    first, *others = camera.frames
    first.save(out, save_all=True, append_images=others, duration=1000 / RATE, loop=0, quality=70)
    print(f"wrote {out}, {len(camera.frames)} frames, {out.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
