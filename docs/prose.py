"""Our docstrings, which are prose, as Markdown: what explains an argument begins a line."""

import re
from typing import Any

import griffe

_SENTENCES = ("Raises", "Returns", "Source", "Sources")


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
    """The text with a line break before, and code marks around, each explained name."""
    listed = "|".join(map(re.escape, names)) or "(?!)"
    text = re.sub(
        rf"\n((?:(?:{listed})(?:, (?:{listed}))*:|(?:{'|'.join(_SENTENCES)})\b))", r"  \n\1", text
    )
    return re.sub(
        rf"(?m)(?:(?<=^)|(?<=\. ))((?:{listed})(?:, (?:{listed}))*):(?= |$)",
        lambda found: ", ".join(f"`{name}`" for name in found[1].split(", ")) + ":",
        text,
    )
