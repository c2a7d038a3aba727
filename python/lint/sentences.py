"""Finds sentences that open with a clause instead of a noun: "What ...", "Which ...", "Where ...".

Run from the project's root: `python python/lint/sentences.py`. Read are docstrings,
comments and error messages of Python, comments of C++, and the documentation, code aside.
Questions are left alone. Any such sentence is an error.
"""

from __future__ import annotations

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

# A sentence: from its first word to the mark at its end.
_SENTENCE = re.compile(
    r"(?:\A(?:[Ww]hat|[Ww]hich|[Ww]here)|(?<=[.!?]\s)(?:What|Which|Where)|(?<=\n\n)(?:[Ww]hat|[Ww]hich|[Ww]here))\b"
    r"[^.!?]*[.!?]?"
)
_COMMENT_OF_CPP = re.compile(r"//+ ?(.*)")
_CODE_OF_DOCS = re.compile(r"^( *)(```|~~~).*?^\1\2|^(?: {4}|\t).*?$|`[^`]*`", re.M | re.S)
_SECTION = re.compile(r"^ *(?:\w+ ?\([^)]*\)|[\w, *]+): ", re.M)  # of a docstring: "name: text"


def main() -> None:
    """Prints the sentences; exits with 1 if there are any."""
    found = [
        (path, line, " ".join(sentence.split()))
        for path in sorted(sources())
        for line, text in texts(path)
        for sentence in openings(text)
    ]
    for path, line, sentence in found:
        print(f"{path}:{line}: {sentence[:90]}: opens with what, which or where")
    if found:
        sys.exit(1)


def sources() -> Iterator[Path]:
    """The files that are read."""
    for folder in ("python", "tests", "cpp"):
        for suffix in ("py", "cpp", "hpp"):
            yield from Path(folder).rglob(f"*.{suffix}")
    yield from Path("docs").rglob("*.md")
    yield from map(Path, ("README.md", "CONTRIBUTING.md"))


def openings(text: str) -> Iterator[str]:
    """The sentences of a text that open with one of the words, questions aside."""
    for match in _SENTENCE.finditer(text):
        if not match[0].endswith("?"):
            yield match[0]


def texts(path: Path) -> Iterator[tuple[int, str]]:
    """The prose of a file, with the line where each piece begins."""
    source = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        yield (
            1,
            re.sub(r"(?<=\n\n)where\b", "with", _CODE_OF_DOCS.sub("code", source)),
        )  # of a formula
    elif path.suffix == ".py":
        yield from _comments(source)
        yield from _docstrings_and_messages(ast.parse(source))
    else:
        lines = enumerate(source.splitlines(), start=1)
        yield from _joined(
            (line, found[1]) for line, text in lines if (found := _COMMENT_OF_CPP.search(text))
        )


def _comments(source: str) -> Iterator[tuple[int, str]]:
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    yield from _joined(
        (token.start[0], token.string.lstrip("# "))
        for token in tokens
        if token.type == tokenize.COMMENT
    )


def _joined(lines: Iterator[tuple[int, str]]) -> Iterator[tuple[int, str]]:
    """Comments on consecutive lines as one text."""
    first, last, text = 0, -1, ""
    for line, words in lines:
        if line == last + 1:
            text, last = f"{text}\n{words}", line
        else:
            if text:
                yield first, text
            first, last, text = line, line, words
    if text:
        yield first, text


def _docstrings_and_messages(tree: ast.AST) -> Iterator[tuple[int, str]]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            text = ast.get_docstring(node)
            if text:
                yield getattr(node, "lineno", 1), _SECTION.sub("\n\n", text)
        elif isinstance(node, ast.Raise) and node.exc is not None:
            for part in ast.walk(node.exc):
                if isinstance(part, ast.Constant) and isinstance(part.value, str):
                    yield node.lineno, part.value


if __name__ == "__main__":
    main()
