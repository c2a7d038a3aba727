"""YAML from anywhere: plain values only, and none that stand for more than the text says."""

from __future__ import annotations

import re
from itertools import accumulate

from leadthrough.errors import InvalidInput

_DEEPEST = 16  # levels of nesting; PyYAML's compiled loader crashes on deep ones
_DEEP_BLOCK = re.compile(r"^[ ?:-]{64}", re.MULTILINE)
# A list that mentions itself a few times over can stand for billions of numbers.
_ANCHOR_AND_ALIAS = [
    re.compile(rf"(?:^|[\s\[{{,:-]){mark}\S", re.MULTILINE) for mark in ("&", r"\*")
]


def load(text: str) -> object:
    """The plain values of a YAML text.

    Args:
        text: of one document.

    Raises:
        InvalidInput: if it has aliases or nests too deep.
        ValueError: if it is not YAML.
    """
    import yaml

    _check_harmless(text)
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        return yaml.load(text, Loader=loader)
    except yaml.YAMLError as error:
        raise ValueError(str(error)) from None


def _check_harmless(text: str) -> None:
    if all(mark.search(text) for mark in _ANCHOR_AND_ALIAS):
        raise InvalidInput("expected YAML without aliases; write the values out")
    steps = [1 if bracket[0] in "[{" else -1 for bracket in re.finditer(r"[\[\]{}]", text)]
    if _DEEP_BLOCK.search(text) or max(accumulate(steps), default=0) > _DEEPEST:
        raise InvalidInput(f"expected YAML that nests at most {_DEEPEST} deep")
