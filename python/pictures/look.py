"""Looks at the built documentation as a phone and as a desktop show it, opened from disk.

`./do docs`, then `python python/pictures/look.py build/docs`: no page is wider than the window, no
script fails, nothing is asked of a network, and the search answers. Ends with 1 where one does.
"""

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from playwright.sync_api import Browser, Page, sync_playwright

WIDTHS = (390, 1200)  # px
HEIGHT = 844
OWN = ("file:", "blob:", "data:")
# Elements that stick out, but for what scrolls by itself.
STICKING_OUT = """() => {
  const wide = document.documentElement.clientWidth;
  const clips = (e) => getComputedStyle(e).overflowX !== 'visible';
  const clipped = (e) => e && (clips(e) || clipped(e.parentElement));
  return [...document.querySelectorAll('article *')]
    .filter((e) => e.getBoundingClientRect().right > wide + 1 && !clipped(e.parentElement))
    .map((e) => `${e.tagName} ${e.textContent.slice(0, 40)}`).slice(0, 3);
}"""


def main(site: Path) -> None:
    """Print what is wrong with each page."""
    pages = [page for page in sorted(site.resolve().rglob("*.html")) if page.name != "404.html"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=["--no-sandbox", "--disable-gpu"]
        )
        found = [fault for width in WIDTHS for fault in faults(browser, pages, width)]
        found += [] if answers(browser, site.resolve() / "index.html") else ["no search"]
        browser.close()
    print(*found, f"{len(pages)} pages looked at", sep="\n")
    sys.exit(bool(found))


def faults(browser: Browser, pages: list[Path], width: int) -> Iterator[str]:
    """Faults of pages in a window of this width."""
    context = browser.new_context(
        viewport={"width": width, "height": HEIGHT}, reduced_motion="reduce"
    )
    tab = context.new_page()
    wrong: list[str] = []
    tab.on("request", lambda each: None if each.url.startswith(OWN) else wrong.append(each.url))
    tab.on("requestfailed", lambda each: wrong.append(f"not found: {each.url}"))
    tab.on("pageerror", lambda error: wrong.append(str(error)))
    tab.route("**/*-scene.html", lambda route: route.fulfill(body=""))  # they draw for long
    for page in pages:
        wrong.clear()
        tab.goto(page.as_uri())
        yield from (f"{width} px, {page}: {each}" for each in (*wrong, *sticking_out(tab)))
    context.close()


def sticking_out(tab: Page) -> list[str]:
    """Elements that are wider than the window."""
    over = tab.evaluate("document.documentElement.scrollWidth - innerWidth")
    return [*([f"{over} px too wide"] if over > 0 else []), *tab.evaluate(STICKING_OUT)]


def answers(browser: Browser, start: Path) -> bool:
    """Whether the search of a page from disk finds something."""
    tab = browser.new_page(viewport={"width": max(WIDTHS), "height": HEIGHT})
    tab.goto(start.as_uri())
    field = tab.locator("input[data-md-component=search-query]")
    field.click()
    field.press_sequentially("margin", delay=50.0)
    tab.locator(".md-search-result__item").first.wait_for()
    return tab.locator(".md-search-result__item").count() > 0


if __name__ == "__main__":
    main(Path(sys.argv[1]))
