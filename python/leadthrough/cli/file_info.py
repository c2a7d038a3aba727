"""The contents of a file: recordings or motions, a skill, or a robot."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import leadthrough._core as core
from leadthrough.arm import Arm, robot_files
from leadthrough.arm.robot_files import link_tree, moves, proposed_tip
from leadthrough.check import InvalidInput, ShortRepr
from leadthrough.io import formats, reader_process, rosbag
from leadthrough.io.files import StrPath, checked_path
from leadthrough.io.reading import blaming, names_of
from leadthrough.io.recording import recording
from leadthrough.io.table import Request
from leadthrough.models import archive
from leadthrough.preprocess.clean import RecordingSummary, summarize

_WRAPPED: dict[str, Any] = {
    "width": 80,
    "subsequent_indent": "  ",
    "break_long_words": False,
    "break_on_hyphens": False,
}


@dataclass(frozen=True)
class FileInfo(ShortRepr):
    path: str  # the file
    format: str  # the name of its format, for people
    kind: str  # "recordings", "skill" or "robot"
    facts: Mapping[str, Any] = field(default_factory=dict)
    recordings: tuple[RecordingSummary, ...] = ()  # a summary of each recording
    text: str = ""  # a robot's description
    problem: str | None = None

    def as_dict(self) -> dict[str, Any]:
        return {
            "path": self.path,
            "format": self.format,
            "kind": self.kind,
            **self.facts,
            "recordings": [each.as_dict() for each in self.recordings],
            "problem": self.problem,
        }

    def __str__(self) -> str:
        lines = [f"{self.path}: {self.format}, {self.kind}"]
        facts = {} if self.text else self.facts  # a description contains them
        for name, value in facts.items():
            if value is None or value == []:
                continue
            text = ", ".join(map(str, value)) if isinstance(value, list | tuple) else str(value)
            lines.append(textwrap.fill(f"{name.replace('_', ' ')}: {text}", **_WRAPPED))
        lines += [str(each) for each in self.recordings]
        lines += [self.text] if self.text else []
        return "\n".join(lines + ([f"! {self.problem}"] if self.problem else []))


def describe(
    path: StrPath,
    *,
    request: Request = Request(),  # noqa: B008 (frozen)
    limits: StrPath | None = None,
    base: str | None = None,
    tip: str | None = None,
    mesh_folders: Sequence[StrPath] = (),
) -> FileInfo:
    """A summary of what a file contains, as far as it can be read."""
    where = checked_path(path)
    if where.suffix.lower() in (".urdf", ".xml", ".xacro") and where.is_file():
        robot = core.Robot(robot_files.read(where))
        if tip is None and (len(robot.leaves) > 1 or not moves(robot)):
            return _branched(where, robot)
        arm = Arm.from_urdf(where, base=base, tip=tip, limits=limits, mesh_folders=mesh_folders)
        return _robot(where, arm)
    with blaming(where):
        kind = formats.of_file(where)
        if kind.name == "npz" and (skill := _skill(where)):
            return skill
        if kind.name == "rosbag" and request.topic is None:
            return _bag(where, kind.title, request)
        return _recordings(where, kind, request)


def _recordings(path: Path, kind: formats.Format, request: Request) -> FileInfo:
    try:
        tables = kind.tables(path, request)
    except InvalidInput as error:
        return FileInfo(str(path), kind.title, "recordings", problem=str(error))
    facts = {"columns": list(tables[0].names)} if tables else {}
    summaries, problem = [], None
    for table, name in zip(tables, names_of(path, tables), strict=True):
        try:
            summaries.append(summarize(recording(table, request, name=name)))
        except InvalidInput as error:
            problem = str(error)
            break
    return FileInfo(str(path), kind.title, "recordings", facts, tuple(summaries), problem=problem)


def _bag(path: Path, title: str, request: Request) -> FileInfo:
    topics = reader_process.plain(rosbag.topics, path)
    summaries = []
    for topic in rosbag.motions(topics):
        asked = Request(**{**vars(request), "topic": topic})
        for table in reader_process.tables(rosbag.tables, path, asked):
            summaries.append(summarize(recording(table, asked, name=topic)))
    facts = {"topics": [f"{name} ({kind})" for name, kind in topics.items()]}
    return FileInfo(str(path), title, "recordings", facts, tuple(summaries))


def _skill(path: Path) -> FileInfo | None:
    try:
        kind, settings, arrays, choice = archive.read(path)
    except InvalidInput:
        return None  # an archive of something else
    why = {} if choice is None or not choice.left_out else {"left_out_errors": choice.table}
    held = [f"{n} {a.shape}" for n, a in arrays.items()]
    facts = {"model": kind, **why, **settings, "arrays": held}
    return FileInfo(str(path), "NumPy archive", "skill", facts)


def _branched(path: Path, robot: core.Robot) -> FileInfo:
    """The links of a robot with several ends, and the lines that choose one."""
    base, tip = robot.links[0], proposed_tip(robot) if moves(robot) else None
    facts = {"base": base, "tip": tip, "ends": list(robot.leaves)}
    if tip is None:
        text = f"{link_tree(robot)}\nno joint moves, so this robot has no arm"
        return FileInfo(str(path), "URDF", "robot", facts, text=text)
    lines = f'base = "{base}"\ntip = "{tip}"'
    text = (
        f"{link_tree(robot)}\nit ends in several links; proposed, for leadthrough.toml:\n"
        f"{lines}\nor type --base {base} --tip {tip}"
    )
    return FileInfo(str(path), "URDF", "robot", facts, text=text)


def _robot(path: Path, arm: Arm) -> FileInfo:
    unknown = [name for name in ("acceleration", "jerk") if getattr(arm.limits, name) is None]
    facts = {"joints": list(arm.joint_names), "unknown_limits": unknown}
    return FileInfo(str(path), "URDF", "robot", facts, text=arm.describe())
