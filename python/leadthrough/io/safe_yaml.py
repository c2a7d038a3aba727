"""YAML from anywhere: plain values only, and none that stand for more than the text says."""

from __future__ import annotations

import re
from functools import cache
from itertools import accumulate
from pathlib import Path
from typing import Any

from leadthrough.errors import InvalidInput
from leadthrough.io import bounds

_DEEPEST = 16  # levels of nesting; PyYAML's compiled loader crashes on deep ones
_LONGEST = 2**25  # bytes
# The loader takes up to 450 bytes and 15 microseconds for each mark that begins a value.
_MOST_MARKS = 2**20
_MARKS = ("[", "{", ",", ":", "\n", "- ", "? ")
# YAML 1.1 reads 1:59:59 in base 60, which takes for ever where it goes on for a million parts.
_LONG_BASE_60 = re.compile(r"\d(:\d{1,2}){8}")
_DEEP_BLOCK = re.compile(r"^[ ?:-]{64}", re.MULTILINE)
# A list that mentions itself a few times over can stand for billions of numbers.
_ANCHOR_AND_ALIAS = [
    re.compile(rf"(?:^|[\s\[{{,:-]){mark}\S", re.MULTILINE) for mark in ("&", r"\*")
]


def load(path: Path) -> object:
    """The plain values in a YAML file."""
    import yaml

    text = bounds.text(path, bounds.Gate(), most=_LONGEST)
    _check_harmless(text)
    try:
        return yaml.load(text, Loader=_loader())
    except yaml.YAMLError as error:
        raise ValueError(str(error)) from None


@cache
def _loader() -> Any:  # Any: the type of a class that depends on how PyYAML was built
    """PyYAML's safe loader, for mappings whose keys are text: others can be chosen to collide."""
    import yaml

    class Loader(getattr(yaml, "CSafeLoader", yaml.SafeLoader)):  # type: ignore[misc]
        def construct_mapping(self, node: Any, deep: bool = False) -> Any:
            for key, _ in node.value:
                if key.tag != "tag:yaml.org,2002:str":
                    raise InvalidInput(f"expected keys of text, got {str(key.value)[:60]!r}")
            return super().construct_mapping(node, deep=deep)

    return Loader


def _check_harmless(text: str) -> None:
    if all(mark.search(text) for mark in _ANCHOR_AND_ALIAS):
        raise InvalidInput("expected YAML without aliases; write the values out")
    marks = sum(map(text.count, _MARKS))
    if marks > _MOST_MARKS:
        raise InvalidInput(
            f"expected YAML of at most {_MOST_MARKS:,} values, got some {marks:,}; "
            "write it as JSON or .npz"
        )
    if _LONG_BASE_60.search(text):
        raise InvalidInput("expected plain numbers, got one in base 60")
    steps = [1 if bracket[0] in "[{" else -1 for bracket in re.finditer(r"[\[\]{}]", text)]
    if _DEEP_BLOCK.search(text) or max(accumulate(steps), default=0) > _DEEPEST:
        raise InvalidInput(f"expected YAML that nests at most {_DEEPEST} deep")
