"""Formulas as MathML, which browsers draw without a script."""

import html
import re
from typing import Any

from latex2mathml.converter import convert
from mkdocs.exceptions import PluginError

_FORMULA = re.compile(
    r'<(?P<tag>span|div) class="arithmatex">\\[(\[](?P<latex>.*?)\\[)\]]</(?P=tag)>', re.DOTALL
)


def on_page_content(content: str, **_: Any) -> str:
    return _FORMULA.sub(_drawn, content)


def _drawn(found: re.Match[str]) -> str:
    display = "block" if found["tag"] == "div" else "inline"
    drawn = convert(html.unescape(found["latex"]), display=display)
    if "\\" in drawn:
        raise PluginError(f"a formula that cannot be drawn: {found['latex']}")
    return f'<div class="formula" tabindex="0">{drawn}</div>' if display == "block" else drawn
