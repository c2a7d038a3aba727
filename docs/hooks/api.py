"""A summary of each API page: its names, each with the first line of its docstring."""

import importlib
import inspect
import re
from typing import Any

from mkdocs.structure.pages import Page

_NAME = re.compile(r"^::: (?P<name>[\w.]+)$", re.MULTILINE)
_FEWEST = 3  # names, from which a summary is a help


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    names = _NAME.findall(markdown)
    if not page.file.src_uri.startswith("api/") or len(names) < _FEWEST:
        return markdown
    rows = "\n".join(f"| [`{_short(name)}`][{name}] | {_said(name)} |" for name in names)
    first = markdown.index(f"::: {names[0]}")
    summary = f"| name | what it is |\n|---|---|\n{rows}\n\n"
    return markdown[:first] + summary + markdown[first:]


def _short(name: str) -> str:
    return name.rpartition(".")[2]


def _said(name: str) -> str:
    """The first line of the docstring of an object or a module."""
    try:
        found: Any = importlib.import_module(name)
    except ModuleNotFoundError:
        module, _, attribute = name.rpartition(".")
        found = getattr(importlib.import_module(module), attribute)
    first = (inspect.getdoc(found) or "").split("\n\n")[0].replace("\n", " ")
    return first.replace("|", "&#124;")
