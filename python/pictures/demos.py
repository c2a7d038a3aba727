"""The pictures of the demos' pages: what each script draws, or its page in headless Chromium.

python python/pictures/demos.py docs/demos/pictures [NAME ...]
"""

import io
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Browser, sync_playwright

DEMOS = Path(__file__).parents[1] / "demos"
WIDTH = 960  # px
PAGE = {"width": 960, "height": 600}
PART = 0.45  # of the motion, at which a page is taken
SOFTWARE_RENDERING = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def main(folder: Path, names: list[str]) -> None:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=SOFTWARE_RENDERING
        )
        for demo in sorted(DEMOS.glob("[0-9]*.py")):
            if not names or demo.stem in names:
                with tempfile.TemporaryDirectory() as own:
                    picture = drawn(demo, Path(own), browser)
                    if picture is not None:
                        smaller(picture).save(folder / f"{demo.stem}.webp", quality=75)
        browser.close()


def drawn(demo: Path, folder: Path, browser: Browser) -> Image.Image | None:
    """The first picture that a demo writes, else the page; None if it writes neither."""
    environment = os.environ | {"MPLBACKEND": "agg"}
    subprocess.run([sys.executable, demo, folder], check=True, cwd=folder, env=environment)
    for file in sorted(folder.glob("*.png")):
        return Image.open(file).convert("RGB")
    for file in sorted(folder.glob("*.html")):
        return taken(file, browser)
    return None


def taken(file: Path, browser: Browser) -> Image.Image:
    """A page, in the middle of its motion if it has one."""
    tab = browser.new_page(viewport=PAGE)
    tab.goto(file.as_uri())
    if tab.locator("figure.scene").count():
        tab.wait_for_function("leadthrough.scenes.length > 0")
        tab.evaluate(
            "part => { let [s] = leadthrough.scenes; s.play(false); s.seek(part * s.duration) }",
            PART,
        )
    tab.wait_for_timeout(1000.0)
    shot = Image.open(io.BytesIO(tab.screenshot())).convert("RGB")
    tab.close()
    return shot


def smaller(picture: Image.Image) -> Image.Image:
    """The picture, no wider than `WIDTH`."""
    picture.thumbnail((WIDTH, picture.height))
    return picture


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2:])
