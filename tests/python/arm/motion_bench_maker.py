"""Problems of MotionBenchMaker for a Panda: obstacles, a start and a goal (MoveIt's YAML)."""

import tarfile
from dataclasses import dataclass

import numpy as np
import yaml

import leadthrough as lt

KINDS = (
    "bookshelf_small",
    "bookshelf_tall",
    "bookshelf_thin",
    "box",
    "cage",
    "table_pick",
    "table_under_pick",
)
_JOINTS = [f"panda_joint{i}" for i in range(1, 8)]


@dataclass(frozen=True, eq=False)
class Problem:
    obstacles: list[lt.Box | lt.Cylinder]
    start: np.ndarray
    goal: np.ndarray


def problems(folder, numbers):
    """The problems of these numbers of each kind, by kind and number."""
    with tarfile.open(folder / "motion_bench_maker" / "panda_problems.tar.bz2") as archive:
        members = {member.name.lstrip("./"): member for member in archive.getmembers()}
        for kind in KINDS:
            for number in numbers:
                scene, request = (
                    yaml.load(archive.extractfile(members[name]), yaml.CSafeLoader)
                    for name in (
                        f"problems/{kind}_panda/scene{number:04d}.yaml",
                        f"problems/{kind}_panda/request{number:04d}.yaml",
                    )
                )
                yield kind, number, _problem(scene, request)


def _problem(scene, request):
    start = request["start_state"]["joint_state"]
    at = dict(zip(start["name"], start["position"], strict=True))
    constraints = request["goal_constraints"][0]["joint_constraints"]
    to = {each["joint_name"]: each["position"] for each in constraints}
    return Problem(
        [shape for each in scene["world"]["collision_objects"] for shape in _shapes(each)],
        *(np.array([joints[name] for name in _JOINTS]) for joints in (at, to)),
    )


def _shapes(described):
    for solid, pose in zip(described["primitives"], described["primitive_poses"], strict=True):
        x, y, z, w = pose["orientation"]
        place = pose["position"], (w, x, y, z)
        if solid["type"] == "box":
            yield lt.Box(solid["dimensions"], *place)
        else:
            length, radius = solid["dimensions"]
            yield lt.Cylinder(radius, length, *place)
