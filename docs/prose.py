"""Our docstrings, which are prose, as Markdown: what explains an argument begins a line."""

import re
from typing import Any

import griffe


class Prose(griffe.Extension):
    """Marks the names of arguments and fields where `name:` explains them."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        if obj.docstring is not None:
            obj.docstring.value = marked(obj.docstring.value, _explained(obj))


def _explained(obj: griffe.Object) -> list[str]:
    if obj.is_function:
        return [parameter.name for parameter in obj.parameters]
    return [
        name for name, member in obj.members.items() if not member.is_alias and member.is_attribute
    ]


def marked(text: str, names: list[str]) -> str:
    """The text with what explains a name, and what is raised and cited, on lines of their own."""
    listed = "|".join(map(re.escape, names)) or "(?!)"
    explained = re.compile(rf"(^|\n|\. )((?:{listed})(?:, (?:{listed}))*):(?=\s|$)")
    text = explained.sub(lambda found: f"{_ended(found[1])}{_as_code(found[2])}:", text)
    return re.sub(
        r"(\n|\. )(?=(?:Raises|Returns|Sources?)\b)", lambda found: _ended(found[1]), text
    )


def _ended(before: str) -> str:
    """What stands before a new line, with Markdown's hard break."""
    return before and f"{before.strip()}  \n"


def _as_code(names: str) -> str:
    return ", ".join(f"`{name}`" for name in names.split(", "))
