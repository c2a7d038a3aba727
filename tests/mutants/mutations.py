"""Small faults in sources: their kinds, and a seeded draw of them."""

from __future__ import annotations

import io
import random
import re
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

# The formatters put blanks around every operator of two operands, and around nothing else.
_SWAPS = {
    "operator": {
        "+": "-", "-": "+", "*": "/", "/": "*", "%": "+", "//": "*", "+=": "-=", "-=": "+=",
        "*=": "/=", "/=": "*=", "&&": "||", "||": "&&", "and": "or", "or": "and",
    },
    "comparison": {
        "<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"),
        "==": ("!=",), "!=": ("==",),
    },
}  # fmt: skip
_BETWEEN = re.compile(r"(?<= )(?:[-+*/%<>=!]=?|//|&&|\|\||and|or)(?= )")
_NUMBER = re.compile(r"(?<![\w.])(?:\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+|\d+)(?![\w.])")
_MINUS = re.compile(r"(?<=[(\[{,=<>?:*/+&|] )-(?=[\w(])|(?<=[(\[{])-(?=[\w(])|(?<=return )-")
_ABSOLUTE = re.compile(r"\b(?:std::|np\.|math\.f)?abs(?=\()")
_NO_CODE = re.compile(
    r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])\'|^\s*#[^\n]*', re.DOTALL | re.M
)


@dataclass(frozen=True)
class Mutant:
    """One fault: `old` in a line becomes `new`.

    Attributes:
        part: of the package.
        kind: "operator", "comparison", "constant" or "sign".
        path: of the source, from the repository's root.
        line, column: of the fault, from 1 on.
        old, new: the text before and after.
    """

    part: str
    kind: str
    path: str
    line: int
    column: int
    old: str
    new: str

    def applied(self, text: str) -> str:
        """The source with the fault."""
        lines = text.splitlines(keepends=True)
        line, at = lines[self.line - 1], self.column - 1
        assert line[at:].startswith(self.old), f"{self.path}:{self.line} has changed"
        lines[self.line - 1] = line[:at] + self.new + line[at + len(self.old) :]
        return "".join(lines)


def drawn(part: str, root: Path, sources: list[str], seed: int) -> Iterator[Mutant]:
    """All mutants of a part in random order, one of each kind in turn; one at a place.

    Args:
        part: its name.
        root: of the repository.
        sources: patterns of files.
        seed: of the draw.
    """
    rng = random.Random(f"{seed} {part}")
    by_kind: dict[str, list[Mutant]] = {}
    for path in sorted({path for pattern in sources for path in root.glob(pattern)}):
        if path.suffix in (".cpp", ".hpp", ".py"):
            for mutant in _mutants(part, path, path.relative_to(root).as_posix(), rng):
                by_kind.setdefault(mutant.kind, []).append(mutant)
    for mutants in by_kind.values():
        rng.shuffle(mutants)
    kinds = sorted(by_kind)
    while any(by_kind.values()):
        for kind in kinds:
            if by_kind[kind]:
                yield by_kind[kind].pop()


def _mutants(part: str, path: Path, name: str, rng: random.Random) -> Iterator[Mutant]:
    for number, line in enumerate(_code(path).splitlines(), 1):
        for kind, found, new in _faults(line, rng):
            yield Mutant(part, kind, name, number, found.start() + 1, found.group(), new)


def _faults(line: str, rng: random.Random) -> Iterator[tuple[str, re.Match[str], str]]:
    for found in _BETWEEN.finditer(line):
        text = found.group()
        if text in _SWAPS["operator"]:
            yield "operator", found, _SWAPS["operator"][text]
        elif text in _SWAPS["comparison"]:
            yield "comparison", found, rng.choice(_SWAPS["comparison"][text])
    for found in _NUMBER.finditer(line):
        yield "constant", found, _other_number(found.group(), rng)
    for found in _MINUS.finditer(line):
        yield "sign", found, ""
    for found in _ABSOLUTE.finditer(line):
        yield "sign", found, ""


def _other_number(text: str, rng: random.Random) -> str:
    """A whole number one more or less; another one doubled, and 1 for zero."""
    if text.isdigit():
        value = int(text)
        return str(value + 1 if value == 0 else value + rng.choice((-1, 1)))
    return repr(2.0 * float(text) or 1.0)


def _code(path: Path) -> str:
    """A source with blanks for comments, texts and directives."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return _NO_CODE.sub(lambda found: re.sub(r"[^\n]", " ", found.group()), text)
    lines = [list(line) for line in text.splitlines()]
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type in (tokenize.STRING, tokenize.COMMENT):
            for row in range(token.start[0], token.end[0] + 1):
                first = token.start[1] if row == token.start[0] else 0
                end = token.end[1] if row == token.end[0] else len(lines[row - 1])
                lines[row - 1][first:end] = " " * (end - first)
    return "\n".join("".join(line) for line in lines)
