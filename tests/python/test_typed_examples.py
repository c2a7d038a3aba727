"""The Python of the README and the guide passes the strictest type check, page by page."""

import os
import re
import subprocess
import sys
from pathlib import Path

import leadthrough

ROOT = Path(__file__).parents[2]
PACKAGE = Path(leadthrough.__file__).parent
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs" / "guide").glob("*.md"))]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)


def scripts(folder):
    """A script of each page's examples, in their order and on the page's own lines."""
    for page in PAGES:
        text = page.read_text()
        if BLOCK.search(text):
            script = folder / f"{page.stem}.py"
            script.write_text(python_of(text))
            yield script


def python_of(text):
    """The text with its Python blocks alone; all other lines are blank."""
    kept, end = "", 0
    for block in BLOCK.finditer(text):
        kept += "\n" * text.count("\n", end, block.start(1)) + block[1]
        end = block.end(1)
    return kept


def test_examples_pass_mypy_strict(tmp_path):
    paths = [str(path) for path in scripts(tmp_path)]
    assert len(paths) > 3
    # As in a project of a user's: without our configuration, the package's types as they are.
    options = ["--strict", "--config-file=", "--follow-imports=silent", "--cache-dir"]
    result = subprocess.run(
        [sys.executable, "-m", "mypy", *options, str(ROOT / "build" / "mypy-examples"), *paths],
        cwd=tmp_path,
        env=os.environ | {"MYPYPATH": str(PACKAGE.parent)},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    assert (PACKAGE / "py.typed").is_file()
