"""The commands and their options, from the program itself, and the changelog."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from leadthrough import cli

_CHANGELOG = Path(__file__).parents[2] / "CHANGELOG.md"


def on_page_markdown(markdown: str, **_: Any) -> str:
    if "{{ changelog }}" in markdown:
        markdown = markdown.replace("{{ changelog }}", _changelog())
    if "{{ commands }}" in markdown:
        markdown = markdown.replace("{{ commands }}", "\n".join(_commands()))
    return markdown


def _changelog() -> str:
    """The changelog without its title; its links lead from the repository's root."""
    text = _CHANGELOG.read_text(encoding="utf-8").split("\n", 1)[1]
    return text.replace("](docs/", "](../")


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
