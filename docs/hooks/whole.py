"""Every link, anchor, picture and script of the built pages leads somewhere on this disk."""

import html
import re
from pathlib import Path
from urllib.parse import unquote

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError

_TARGET = re.compile(
    r"""<(?:a|img|script|link|iframe|source)\b[^>]*?\b(?:href|src)=(["'])(.*?)\1"""
)
_PLACE = re.compile(r"""\b(?:id|name)=(["'])(.*?)\1""")
_ELSEWHERE = ("http://", "https://", "mailto:", "data:", "javascript:")


def on_post_build(config: MkDocsConfig) -> None:
    site = Path(config.site_dir)
    pages = {
        page: page.read_text(encoding="utf-8")
        for page in sorted(site.rglob("*.html"))
        if page.name != "404.html"  # has addresses of a server's root
    }
    places = {
        page: {html.unescape(each[1]) for each in _PLACE.findall(pages[page])} for page in pages
    }
    lost = [
        f"{page.relative_to(site)}: {target}"
        for page, text in pages.items()
        for target in sorted({html.unescape(each[1]) for each in _TARGET.findall(text)})
        if not target.startswith(_ELSEWHERE) and not _leads(page, target, places)
    ]
    if lost:
        raise PluginError("links that lead nowhere:\n" + "\n".join(lost))


def _leads(page: Path, target: str, places: dict[Path, set[str]]) -> bool:
    path, _, place = target.partition("#")
    found = (page.parent / unquote(path.partition("?")[0])).resolve() if path else page
    if not found.exists():
        return False
    return not place or found not in places or unquote(place) in places[found] or place == "__top"
