"""The pictures of the page that teaches: each of its states, driven with the pointer in Chromium.

python python/pictures/teach.py docs/howto
"""

import io
import os
import shutil
import sys
import tempfile
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

import leadthrough as lt
from demos import SOFTWARE_RENDERING
from leadthrough.show.teaching import teach

WIDE, PHONE = {"width": 960, "height": 640}, {"width": 390, "height": 844}
SCENE = "leadthrough.scenes[0]"
BOX = lt.Box((0.08, 0.08, 0.3), (0.45, -0.12, 0.15))


def main(folder: Path) -> None:
    with tempfile.TemporaryDirectory() as own, sync_playwright() as playwright:
        folder = folder.resolve()
        os.chdir(own)
        page = teach(lt.Arm.load("panda"), [BOX], folder="recorded")
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=SOFTWARE_RENDERING
        )
        tab = browser.new_page(viewport=WIDE)
        tab.goto(page.url)
        settled(tab, "state.text")
        for k in range(3):
            press(tab, "Record")
            drag(tab, "tip", (0, -100 - 8 * k), (110, 90 + 5 * k), release=False)
            if k == 0:
                take(tab, folder / "teach-record.webp")
            tab.mouse.up()
            press(tab, "Stop")
            settled(tab, f"state.demonstrations.length === {k + 1}")
        tab.wait_for_timeout(1000.0)
        take(tab, folder / "teach-list.webp")
        press(tab, "Learn")
        settled(tab, "state.goal && /lear by/.test(state.text)")
        drag(tab, "goal", (40, -40))
        settled(tab, "/--goal=/.test(state.command) && /lear by/.test(state.text)")
        halfway(tab)
        take(tab, folder / "teach-move.webp")
        drag(tab, "point", (0, -50))
        settled(tab, "state.corrections === 1 && /lear by/.test(state.text)")
        halfway(tab)
        take(tab, folder / "teach-correct.webp")
        tab.locator("select.figure").select_option(label="velocities, share of limits")
        take(tab, folder / "teach-curves.webp")
        phone = browser.new_page(viewport=PHONE)
        phone.goto(page.url)
        settled(phone, "state.text")
        halfway(phone)
        take(phone, folder / "teach-phone.webp")
        browser.close()
        page.close()


def settled(tab: Page, condition: str) -> None:
    tab.wait_for_function("leadthrough.scenes.length > 0")
    tab.wait_for_function(f"(({{state}}) => {condition})({SCENE})")


def press(tab: Page, name: str) -> None:
    tab.get_by_role("button", name=name, exact=True).click()


def drag(tab: Page, kind: str, *moves: tuple[int, int], release: bool = True) -> None:
    """Drags a ring through moves of so many pixels."""
    box = tab.locator(f".handle.{kind}").first.bounding_box()
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    tab.mouse.move(x, y)
    tab.mouse.down()
    for dx, dy in moves:
        x, y = x + dx, y + dy
        tab.mouse.move(x, y, steps=12)
        tab.wait_for_timeout(700.0)
    if release:
        tab.mouse.up()


def halfway(tab: Page) -> None:
    tab.evaluate(f"{SCENE}.play(false); {SCENE}.seek(0.5 * {SCENE}.duration)")


def take(tab: Page, file: Path) -> None:
    tab.wait_for_timeout(2500.0)  # until the frame is drawn as finely as it will be
    Image.open(io.BytesIO(tab.screenshot())).convert("RGB").save(file, quality=75)
    print(f"wrote {file}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
