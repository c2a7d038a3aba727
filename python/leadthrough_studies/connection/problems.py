"""The problems of MotionBenchMaker for a Panda: obstacles, a start and a goal (MoveIt's YAML).

Source: Chamzas et al. 2022, "MotionBenchMaker: a tool to generate and benchmark motion planning
datasets", IEEE Robotics and Automation Letters 7(2).
"""

from __future__ import annotations

import tarfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import MissingDependency
from leadthrough.shapes import Box, Cylinder, Scene

KINDS = (
    "bookshelf_small",
    "bookshelf_tall",
    "bookshelf_thin",
    "box",
    "cage",
    "table_pick",
    "table_under_pick",
)
ARCHIVE = "motion_bench_maker/panda_problems.tar.bz2"
_JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
# The problems have the fingers 6.5 cm away from the middle each, and the limit of the fourth joint
# that the maker gave at that time. m, rad
_FINGERS = 0.065
_RANGES = {'upper="0.04"': f'upper="{_FINGERS}"', 'upper="-0.0698"': 'upper="0.0175"'}
_PACKAGE, _URDF = "example-robot-data", "panda.urdf"


@dataclass(frozen=True, eq=False)
class Problem:
    """A way to find.

    Attributes:
        obstacles: in the base frame.
        start: configuration (7,).
        goal: configuration (7,), which often grasps a thing.
    """

    obstacles: tuple[Box | Cylinder, ...]
    start: Float64Array
    goal: Float64Array

    @property
    def scene(self) -> Scene:
        """The obstacles, which may be touched: some ends grasp a thing."""
        return Scene(self.obstacles, margin=0.0)


@cache
def panda() -> Arm:
    """The Panda of the problems: its hand open, its meshes those of example-robot-data.

    Raises:
        MissingDependency: if that package is not installed.
    """
    try:
        files = metadata.distribution(_PACKAGE).files or []
    except metadata.PackageNotFoundError:
        raise MissingDependency(_PACKAGE, extra="test") from None
    urdf = next(Path(str(file.locate())) for file in files if file.name == _URDF)
    document = urdf.read_text(encoding="utf-8")
    for theirs, ours in _RANGES.items():
        assert theirs in document
        document = document.replace(theirs, ours)
    # Its meshes are named by the package, three folders above the URDF's.
    arm = Arm.from_urdf(document, tip="panda_hand", mesh_folders=[urdf.parents[3]])
    return arm.lock_joints({"panda_finger_joint1": _FINGERS})


def problems(archive: Path, kind: str, numbers: Sequence[int]) -> Iterator[Problem]:
    """The problems of a kind.

    Args:
        archive: address of their publication.
        kind: one of KINDS.
        numbers: 1 to 100.
    """
    files = _files(archive)
    for number in numbers:
        names = (f"problems/{kind}_panda/{part}{number:04d}.yaml" for part in ("scene", "request"))
        yield _problem(*(yaml.load(files[name], yaml.CSafeLoader) for name in names))


@lru_cache(maxsize=1)  # each look for one of them would decompress them all
def _files(archive: Path) -> dict[str, bytes]:
    """The contents of the archive's files, by their names."""
    with tarfile.open(archive) as members:
        read = ((member.name, members.extractfile(member)) for member in members)
        return {name.removeprefix("./"): file.read() for name, file in read if file is not None}


def _problem(scene: Mapping[str, Any], request: Mapping[str, Any]) -> Problem:
    start = request["start_state"]["joint_state"]
    at = dict(zip(start["name"], start["position"], strict=True))
    constraints = request["goal_constraints"][0]["joint_constraints"]
    to = {each["joint_name"]: each["position"] for each in constraints}
    return Problem(
        tuple(shape for each in scene["world"]["collision_objects"] for shape in _shapes(each)),
        *(np.array([joints[name] for name in _JOINTS]) for joints in (at, to)),
    )


def _shapes(described: Mapping[str, Any]) -> Iterator[Box | Cylinder]:
    for solid, pose in zip(described["primitives"], described["primitive_poses"], strict=True):
        x, y, z, w = pose["orientation"]
        if solid["type"] == "box":
            yield Box(solid["dimensions"], pose["position"], (w, x, y, z))
        else:
            length, radius = solid["dimensions"]
            yield Cylinder(radius, length, pose["position"], (w, x, y, z))
