"""Makes wheels that run without the Debian packages they were built from.

`python repair.py built.whl... --out dist`: auditwheel copies the native libraries into each and
tags it with the oldest glibc that it runs on. The licences of these libraries and of the
compiled-in headers are added beside the package's own.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from importlib.metadata import distribution
from pathlib import Path

# Packages whose headers are compiled in; those of libraries are found from the wheel.
HEADERS = ("libeigen3-dev", "liborocos-kdl-dev", "liburdfdom-dev", "liburdfdom-headers-dev")
COMMON = Path("/usr/share/common-licenses")


def main() -> None:
    """Repair the wheels that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("wheels", type=Path, nargs="+")
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    for wheel in arguments.wheels:
        repair(wheel, arguments.out)


def repair(built: Path, out: Path) -> None:
    """Put a repaired wheel into a folder."""
    with tempfile.TemporaryDirectory() as folder:
        repaired = Path(folder) / "repaired"
        run("auditwheel", "repair", "--wheel-dir", repaired, built)
        (wheel,) = repaired.glob("*.whl")
        run("wheel", "unpack", "--dest", folder, wheel)
        (content,) = Path(folder).glob("leadthrough-*")
        add_licences(content)
        run("wheel", "pack", "--dest-dir", out, content)


def run(*command: object) -> str:
    """The output of a command of this interpreter's environment or of the system."""
    paths = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    done = subprocess.run(
        list(map(str, command)),
        check=True,
        text=True,
        stdout=subprocess.PIPE,
        env={**os.environ, "PATH": paths},
    )
    return done.stdout


def add_licences(content: Path) -> None:
    """Add the licences of everything in the unpacked wheel to its metadata."""
    (metadata,) = content.glob("*.dist-info")
    licences = metadata / "licenses"
    packages = {package_of(library) for library in content.glob("*.libs/*.so*")}
    for package in sorted(packages | set(HEADERS)):
        text = Path("/usr/share/doc", package, "copyright").read_text(encoding="utf-8")
        write(licences / package / "copyright", text)
        for common in set(re.findall(rf"{COMMON}/([\w.+-]*\w)", text)):
            write(licences / "common" / common, (COMMON / common).read_text(encoding="utf-8"))
    for file in distribution("pybind11").files or ():
        if file.name == "LICENSE":
            write(licences / "pybind11" / "LICENSE", file.locate().read_text(encoding="utf-8"))


def package_of(library: Path) -> str:
    """The Debian package that a library in the wheel was copied from."""
    # auditwheel adds a digest to the name: libtinyxml-93d2f.so.2.6.2
    stem, _, version = library.name.partition(".so")
    original = f"{stem.rpartition('-')[0]}.so{version}"
    owner = run("dpkg", "-S", f"*/{original}").splitlines()[0]
    return owner.partition(":")[0]


def write(path: Path, text: str) -> None:
    """Write a text file; its folder is made if missing."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    if shutil.which("dpkg") is None:
        sys.exit("repair: dpkg is missing; it finds the licences of the libraries")
    main()
