"""What is made when the pages are built: formulas as MathML, and the commands' options."""

import html
import re
from collections.abc import Iterator
from typing import Any

import typer
from latex2mathml.converter import convert
from mkdocs.exceptions import PluginError

from leadthrough import cli

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
    return f'<div class="formula">{drawn}</div>' if display == "block" else drawn


def on_page_markdown(markdown: str, **_: Any) -> str:
    return markdown.replace("{{ commands }}", "\n".join(_commands()))


def _commands() -> Iterator[str]:
    group: Any = typer.main.get_command(cli.app)
    for name, command in group.commands.items():
        yield f"## {name}\n"
        # Paragraphs that are examples become code.
        yield re.sub(r"(?m)^(leadthrough .*)$", r"    \1", command.help) + "\n"
        yield "| option | what |\n|---|---|"
        for parameter in command.params:
            if parameter.name != "help":
                names = ", ".join(f"`{each}`" for each in _names(parameter))
                yield f"| {names} | {parameter.help.replace('|', '&#124;')} |"
        yield ""


def _names(parameter: Any) -> list[str]:
    if parameter.param_type_name == "argument":
        return [parameter.name.upper()]
    return list(parameter.opts)
