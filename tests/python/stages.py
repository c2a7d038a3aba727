"""The tree in CONTRIBUTING.md: the one list of the stages, and of the families of models."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]


def _paths(text):
    """Paths in a tree, folders with a slash at the end; two blanks for each level."""
    above = []
    for line in text.splitlines():
        depth = (len(line) - len(line.lstrip())) // 2
        above[depth:] = [line.split()[0]]
        yield "".join(above)


def _directly_in(folder):
    """Names of the modules and folders that the tree shows in a folder, in its order."""
    below = [path.removeprefix(folder) for path in TREE if path.startswith(folder)]
    return tuple(
        name.removesuffix(".py").rstrip("/") for name in below if re.fullmatch("[^/]+/?", name)
    )


_TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
TREE = tuple(_paths(re.search(r"^```text\n(.*?)^```", _TEXT, re.DOTALL | re.MULTILINE)[1]))
# A stage imports only what stands above it.
STAGES = _directly_in("python/leadthrough/")
# Folders of models/ that every family may use, and that use none; the others are the families.
HALL = ("gaussians",)
FAMILIES = tuple(name for name in _directly_in("python/leadthrough/models/") if name not in HALL)
