"""Types what pages print: their commands and lines of Python, in the order printed.

`python read_along.py README.md docs/tutorial/*.md`, with the Python of an environment that has
only what a reader would install. Each page begins in an empty folder; its commands run in bash,
its lines in one Python session, and a profile is written where it is printed. Ends with 1 at the
first fault.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

BLOCK = re.compile(r"^```(python|sh|toml)\n(.*?)^```", re.DOTALL | re.MULTILINE)
ASSIGNED = re.compile(r"^[A-Z]+=.*$", re.MULTILINE)
PROFILE = Path("leadthrough.toml")


def main(pages: list[Path]) -> None:
    """Read along with each page."""
    bin_folder = str(Path(sys.executable).parent)
    os.environ["PATH"] = os.pathsep.join([bin_folder, os.environ["PATH"]])
    os.environ["MPLBACKEND"] = "agg"
    for page in [page.resolve() for page in pages]:
        begin = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            read(page)
            os.chdir("/")
        print(f"{page.name}: everything ran, in {time.monotonic() - begin:.0f} s", flush=True)


def read(page: Path) -> None:
    """Run the blocks of a page in the working directory."""
    names: dict[str, Any] = {}
    variables = ""
    for kind, text in BLOCK.findall(page.read_text(encoding="utf-8")):
        if kind == "python":
            exec(compile(text, str(page), "exec"), names)
        elif kind == "toml":
            PROFILE.write_text(text, encoding="utf-8")
        else:
            type_in(variables + text)
            variables += "".join(f"{line}\n" for line in ASSIGNED.findall(text))


def type_in(text: str) -> None:
    """Run commands in bash, and go to the folder that they end in."""
    reading, writing = os.pipe()
    script = f"set -eu\n{text}\npwd >&{writing}\n"
    done = subprocess.run(["bash", "-c", script], pass_fds=[writing], check=False)
    os.close(writing)
    if done.returncode:
        sys.exit(f"read_along: code {done.returncode} in\n{text}")
    with os.fdopen(reading) as told:
        os.chdir(told.read().rstrip("\n"))


if __name__ == "__main__":
    main([Path(word) for word in sys.argv[1:]])
