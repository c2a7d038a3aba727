"""The files of a robot: URDFs by path and by name, and their meshes; its links as a tree.

A mesh of collision geometry counts as its convex parts. They contain the mesh, so no collision is
missed, but the free space inside a closed mesh counts as occupied.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module, metadata
from importlib.util import find_spec
from math import inf
from os import PathLike
from pathlib import Path
from typing import TypeGuard
from urllib.parse import unquote, urlparse

import leadthrough._core as core
from leadthrough import check, sanity
from leadthrough.arm.convex_decomposition import convex_parts
from leadthrough.arm.limits import JointLimits, read_limits
from leadthrough.check import Float64Array, InvalidInput, InvalidRobot

# Bytes: above the core's own bound, which refuses the document with a reason.
_MAX_FILE = 2**25
_PACKAGES = "example-robot-data or robot_descriptions"
_COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
_XACRO_PREFIX = re.compile(r"""xmlns:([\w.-]+)\s*=\s*["'][^"']*xacro/?["']""")
_IN_DEGREES = 720.0  # the largest limit of a joint in degrees; more stands for none
_MAX_MESHES = 256  # read last, some kB each
_NOT_OF_AN_ARM = ("fixed", "planar", "floating")
# Links of tools, and joints of fingers, by how arms' makers name them.
_TOOL = re.compile(r"(^|[_/-])(tool0|tcp|ee_link|flange)$", re.IGNORECASE)
_FINGER = re.compile(
    r"finger|gripper|jaw|knuckle|thumb|claw|hand|pinky|(^|_)(index|middle|ring|little)(_|$)",
    re.IGNORECASE,
)
_BESIDE_MESHES = ("urdf", "robots", "xacro")  # a package's folders for descriptions


def is_document(path_or_xml: str | PathLike[str]) -> TypeGuard[str]:
    """Whether this is the document itself and not its path."""
    return isinstance(path_or_xml, str) and path_or_xml.lstrip("\ufeff \t\r\n")[:1] == "<"


def read(path_or_xml: str | PathLike[str]) -> str:
    """The document, or the text of the file; a xacro file is expanded."""
    try:
        if is_document(path_or_xml):
            document = str(path_or_xml.encode("utf-8"), "utf-8")
        else:
            with Path(path_or_xml).open("rb") as file:
                document = str(file.read(_MAX_FILE), "utf-8")
    except (OSError, ValueError, TypeError) as error:
        raise InvalidInput(f"path_or_xml: expected a URDF or its path: {error}") from None
    if not is_document(path_or_xml) and Path(path_or_xml).suffix.lower() == ".xacro":
        document = _expanded(Path(path_or_xml))
    _refuse_xacro(document)
    return document


def _expanded(path: Path) -> str:
    """The URDF that a xacro file describes, with the defaults of its arguments."""
    xacro = check.package("xacro", extra="xacro")
    try:
        return str(xacro.process_file(str(path)).toxml())
    except Exception as error:  # of whatever its expressions call
        raise InvalidRobot(
            path.name, f"cannot be expanded ({error}); expand it by `xacro` where its packages are"
        ) from None


def _refuse_xacro(document: str) -> None:
    """Refuses elements that only the tool xacro understands: without them the arm is another."""
    text = _COMMENT.sub("", document)
    for prefix in {"xacro", *_XACRO_PREFIX.findall(text)}:
        if element := re.search(rf"<{re.escape(prefix)}:[\w.-]+", text):
            raise InvalidRobot(
                f"{element[0]}>",
                "is of xacro, not of URDF; expand the file, as by `xacro robot.urdf.xacro > "
                'robot.urdf`, or name it .xacro and install "leadthrough[xacro]"',
            )


def ends_and_limits(
    document: str,
    ends: tuple[str | None, str | None],
    locked: Mapping[str, float],
    limits: JointLimits | str | PathLike[str] | None,
) -> tuple[str, str, JointLimits]:
    """The base and tip link of an arm, and its limits: those given, or the URDF's, completed."""
    robot = core.Robot(document)
    base, tip = ends
    base = robot.links[0] if base is None else check.choice(base, "base", robot.links)
    tip = _only_leaf(robot) if tip is None else check.choice(tip, "tip", robot.links)
    chain = core.Chain(robot.hold(list(locked.items())), base, tip)
    names = tuple(chain.joint_names)
    stated = JointLimits(names, chain.lower, chain.upper, chain.velocity, effort=chain.effort)
    known = sorted(bound for bound in map(max, -stated.lower, stated.upper) if bound < inf)
    if len(known) > 1 and known[-1] <= _IN_DEGREES and sanity.degrees(known[0]):
        sanity.warn(f"limits: the URDF lets all joints turn by {known[0]:.4g} rad; degrees?")
    if limits is None:
        return base, tip, stated
    if isinstance(limits, JointLimits):
        return base, tip, limits
    return base, tip, read_limits(limits, stated, other_joints=robot.joints)


def _only_leaf(robot: core.Robot) -> str:
    if len(robot.leaves) > 1:
        raise InvalidInput(
            f"tip: expected a link's name, as the robot ends in several links; name one of "
            f"{robot.leaves}"
        )
    return robot.leaves[0]


@dataclass(frozen=True)
class RobotFiles:
    urdf: Path  # the robot description
    limits: Path | None = None  # the limits file; None if there is none
    mesh_folders: tuple[Path, ...] = ()  # where its meshes are looked for besides


def find_robot(name: str) -> RobotFiles:
    if isinstance(name, str):
        _refuse_path(name)
        for search in (_own, _of_example_robot_data, _of_robot_descriptions):
            if found := search(name):
                return found
    names = ", ".join(map(repr, own_names())) or "none"
    raise InvalidInput(
        f"name: expected one of the robots {names}, or of {_PACKAGES} where these are installed, "
        f"got {name!r}; in Python, a URDF is read by Arm.from_urdf"
    )


def own_names() -> list[str]:
    return [folder.name for folder in _folders()]


def _refuse_path(name: str) -> None:
    if name.lower().endswith((".urdf", ".xml", ".xacro")) or "/" in name or "\\" in name:
        names = ", ".join(map(repr, own_names()))
        raise InvalidInput(
            f"name: expected the name of a robot such as {names}, got {name!r}; in Python, read a "
            f"file with Arm.from_urdf({name!r})"
        )


def _own(name: str) -> RobotFiles | None:
    for folder in _folders():
        if folder.name == name:
            return RobotFiles(folder / f"{name}.urdf", folder / "limits.toml")
    return None


def _folders() -> list[Path]:
    return [
        folder
        for place in _places()
        for folder in sorted((place / "robots").glob("*"))
        if (folder / f"{folder.name}.urdf").is_file()
    ]


def _places() -> list[Path]:
    """The package's folders: of an editable install the sources and that of the built module."""
    package = find_spec("leadthrough")
    return [Path(each) for each in (package.submodule_search_locations if package else None) or ()]


def _of_example_robot_data(name: str) -> RobotFiles | None:
    """Its files are named after the robot, some with "_robot" added: ur5_robot.urdf."""
    found = sorted(set(_urdfs(name)))
    if len(found) > 1:
        listed = ", ".join(map(str, found))
        raise InvalidInput(
            f"name: example-robot-data has several robots {name!r}; name one of their files: "
            f"{listed}; in Python, read it with Arm.from_urdf"
        )
    return RobotFiles(found[0]) if found else None


def _urdfs(name: str) -> Iterator[Path]:
    try:
        files = metadata.files("example-robot-data") or []
    except metadata.PackageNotFoundError:
        return
    for file in files:
        if file.name in (f"{name}.urdf", f"{name}_robot.urdf"):
            yield Path(str(file.locate())).resolve()


def _of_robot_descriptions(name: str) -> RobotFiles | None:
    """Its modules are named after the robot; one downloads its files when first imported."""
    if not name.isidentifier() or find_spec("robot_descriptions") is None:
        return None
    module = f"robot_descriptions.{name.removesuffix('_description')}_description"
    if find_spec(module) is None:
        return None
    try:
        described = import_module(module)
    except Exception as error:  # of git, which it calls
        raise InvalidInput(
            f"name: the files of {name!r} could not be downloaded by robot_descriptions ({error}); "
            "load it once with a network, or name its URDF; in Python, by Arm.from_urdf"
        ) from None
    if not hasattr(described, "URDF_PATH"):
        raise InvalidInput(f"name: {module} has no URDF, got {name!r}")
    folder = Path(getattr(described, "PACKAGE_PATH", Path(described.URDF_PATH).parent))
    return RobotFiles(Path(described.URDF_PATH), mesh_folders=(folder, folder.parent))


def folders(
    path_or_xml: str | PathLike[str], mesh_folders: Sequence[str | PathLike[str]]
) -> tuple[str, ...]:
    """The folders in which an arm's meshes are looked for: those given, then the URDF's own."""
    if isinstance(mesh_folders, str | Path) or not isinstance(mesh_folders, Sequence):
        raise InvalidInput(f"mesh_folders: expected a sequence of folders, got {mesh_folders!r}")
    try:
        given = [Path(folder).resolve() for folder in mesh_folders]
    except (TypeError, ValueError, OSError) as error:
        raise InvalidInput(f"mesh_folders: expected paths of folders: {error}") from None
    if not is_document(path_or_xml):
        given.append(Path(path_or_xml).resolve().parent)
    return tuple(str(folder) for folder in given)


def mesh_parts(
    link: str, file: str, scale: Float64Array, folders: Sequence[str]
) -> tuple[Float64Array, ...]:
    """Vertices (n, 3) of the convex parts of a link's mesh in m, in the mesh's frame."""
    from scipy.spatial import QhullError  # only robots with meshes need it

    where = f"link {link!r}"
    path = find_mesh(file, folders)
    if path is None:
        places = ", ".join(folders) or "none"
        raise InvalidRobot(
            where,
            f"mesh {file!r} was not found in the robot's folders ({places}); if it lies elsewhere, "
            "name its folder in mesh_folders",
        )
    try:
        written = path.stat()
        return _parts(path, tuple(scale), written.st_mtime_ns, written.st_size)
    except InvalidInput as error:
        raise InvalidRobot(where, str(error)) from None
    except QhullError:
        raise InvalidRobot(where, f"mesh {file!r} is flat or has too few vertices") from None


@lru_cache(_MAX_MESHES)
def _parts(
    path: Path, scale: tuple[float, ...], _written: int, _size: int
) -> tuple[Float64Array, ...]:
    """Vertices (n, 3) of the convex parts of a mesh file, anew when it is written again."""
    from leadthrough.io.mesh import read_vertices  # it takes long to load

    vertices, faces = read_vertices(path)
    return check.freeze(convex_parts(vertices * scale, faces))


def find_mesh(file: str, folders: Sequence[str]) -> Path | None:
    """The file that a URDF's mesh names, or None if it is not found or lies outside the robot."""
    try:
        for candidate, root in _candidates(file, folders):
            plain = Path(os.path.normpath(candidate))  # without the links' targets
            if plain.is_relative_to(root) and candidate.is_file():
                return candidate
    except ValueError:  # no address, or no path
        return None
    return None


def _candidates(file: str, folders: Sequence[str]) -> Iterator[tuple[Path, Path]]:
    """Possible paths of a mesh, each with the folder that it must not leave."""
    address = urlparse(file)
    if address.scheme == "package":
        name, rest = address.netloc, unquote(address.path).lstrip("/")
        if not name:  # package:///name/rest, as some exporters write it
            name, _, rest = rest.partition("/")
        if name == "leadthrough":  # its own robots, also in a copy of their URDF
            yield from ((own / rest, own) for own in _places())
        starts = [Path(folder).resolve() for folder in folders if name.strip(".")]
        for start in starts:
            for place in (start, *start.parents):
                yield place / name / rest, place / name
        for start in starts:
            root = _root(start)
            for place in (start, *start.parents):
                if place.is_relative_to(root):
                    yield place / rest, root
        parts = Path(rest).parts
        if ".." not in parts:
            for start in starts:
                yield from ((start / Path(*parts[i:]), start) for i in range(1, len(parts)))
        return
    path = Path(unquote(address.path) if address.scheme == "file" else file)
    for folder in folders:
        yield Path(folder) / path, _root(Path(folder))  # of an absolute path it is the path itself


def _root(folder: Path) -> Path:
    """The folder of the robot that has this one."""
    for place in (folder, *folder.parents):
        if (place / "package.xml").is_file():
            return place
    return folder.parent if folder.name in _BESIDE_MESHES else folder


def moves(robot: core.Robot) -> bool:
    return any(joint.kind not in _NOT_OF_AN_ARM for joint in robot.tree)


def proposed_tip(robot: core.Robot) -> str:
    """The tool's link after the most moving joints, else the last link before the fingers."""
    fingers = {
        joint.name for joint in robot.tree if joint.kind != "fixed" and _is_finger(robot, joint)
    }
    moving = _moving_before(robot, fingers)
    return _last(robot, moving if any(moving.values()) else _moving_before(robot, set()))


def _moving_before(robot: core.Robot, left_out: Collection[str]) -> dict[int, int]:
    """The number of joints before each link that is not behind one of those left out."""
    moving = {0: 0}  # a parent comes before its children
    for joint in robot.tree:
        if joint.parent in moving and joint.name not in left_out:
            moves = joint.kind != "fixed" and joint.mimic is None
            moving[joint.child] = moving[joint.parent] + moves
    return moving


def proposed_ends(document: str, recorded: Sequence[str] = ()) -> tuple[str, str]:
    """The base and tip of an arm: around the joints that were recorded, else as `proposed_tip`."""
    robot = core.Robot(document)
    first: dict[int, int] = {}  # the link before the recorded joints, by the link behind them
    behind: dict[int, int] = {}  # how many of them are before a link
    for joint in robot.tree:
        is_recorded = joint.name in recorded and not _is_finger(robot, joint)
        follows = joint.kind == "fixed" or (joint.mimic and not _is_finger(robot, joint))
        if is_recorded or (follows and joint.parent in behind):
            first[joint.child] = first.get(joint.parent, joint.parent)
            behind[joint.child] = behind.get(joint.parent, 0) + is_recorded
    if not behind:
        return robot.links[0], proposed_tip(robot)
    tip = _last(robot, behind)
    return robot.links[first[robot.links.index(tip)]], tip


def _last(robot: core.Robot, joints: Mapping[int, int]) -> str:
    """The link behind the most joints: the robot's only end, else a tool's before others."""
    most = max(joints.values())
    names = [robot.links[i] for i, count in joints.items() if count == most]
    only = robot.leaves if len(robot.leaves) == 1 else ()
    return max(names, key=lambda n: (n in only, n.endswith("tool0"), bool(_TOOL.search(n))))


def _is_finger(robot: core.Robot, joint: core.Joint) -> bool:
    """Whether a joint moves a finger: by its name, or that of the link, unless it is a palm."""
    link = robot.links[joint.child]
    return bool(_FINGER.search(joint.name) or re.search("finger|jaw|knuckle|thumb", link.lower()))


def link_tree(robot: core.Robot) -> str:
    """The links, each below its parent, with the joint between them."""

    def rows(link: int, depth: int) -> Iterator[str]:
        for joint in robot.tree:
            if joint.parent == link:
                yield f"{'  ' * depth}{robot.links[joint.child]} ({joint.name}, {joint.kind})"
                yield from rows(joint.child, depth + 1)

    return "\n".join([robot.links[0], *rows(0, 1)])
