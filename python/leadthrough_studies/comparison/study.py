"""The comparison: all models by one protocol, from accuracy to whether an arm can run the motion.

- Handwriting (LASA, 30 motions of 7 demonstrations): IN learns from all seven and reproduces each,
  LOO leaves each out in turn. Settings of the rivals are chosen by cross-validation among the
  demonstrations that they may learn from; the package's own models stand at their defaults.
- Courses of points in space and motions of poses, recorded (with LEADTHROUGH_DATA) and simulated:
  each demonstration left out in turn, with its start and goal given (`material`).
- Responses: a goal that has moved; pushes at a quarter, half and three quarters of the path, after
  which each model goes on by its own online call (`pushes`), also of a tool that is held, and of
  joints. The same with a simulated Panda in the loop, whose tip a hand pushes (`pushed_arm`).
- Sets of recordings in a folder of yours (`--recordings`): each demonstration left out in turn.
- Stability of the dynamical systems: ten thousand starts for each motion.
- Arms: the motions that were made, on a Panda and a UR3.

Rivals of other libraries take part where these are installed (`rivals`; the extra `rivals`). Tables
1 and 2 of Prados et al. 2023 come anew from these rows, with the printed ones beside them.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from leadthrough.io import lasa
from leadthrough_studies.comparison import material
from leadthrough_studies.comparison.methods import (
    COURSES,
    JOINTS,
    ONLINE,
    POINTS,
    POSES,
    RECORDED,
    SYSTEMS,
)
from leadthrough_studies.comparison.push_trials import push, push_arm
from leadthrough_studies.comparison.recordings import sets_in
from leadthrough_studies.comparison.report import report
from leadthrough_studies.comparison.rivals import MISSING, NOT_INSTALLED
from leadthrough_studies.comparison.trials import draw, examine, leave_out, move, trace
from leadthrough_studies.study import Study, Task

PROTOCOLS = ("IN", "LOO")
_AS_SMALL_AS_A_PUSH = ("symbol17",)  # of the arm
_QUICK, _QUICK_JOINTS = ("Angle",), ("DMP", "AlignedMean")
_SLOW = ("LPV-DS", "UMIC")  # to fit


@dataclass(frozen=True)
class ComparisonConfig:
    """The configuration of the study.

    Attributes:
        motions: names of motions of the LASA set.
        points: keys of POINTS.
        protocols: of PROTOCOLS.
        courses: courses of points in space, with their recordings.
        motions_of_poses: motions of poses, with their recordings.
        poses: keys of POSES.
        motions_of_joints: motions of joints, which are pushed only.
        joints: keys of JOINTS.
        online: of ONLINE, methods that lead a simulated arm.
        left_out: number of demonstrations that are tested of each motion; None for all.
        folds: number of demonstrations that inner cross-validation leaves out; 0 for none.
        pushed: number of left-out demonstrations of each motion for the pushes; None for all.
        pushed_on_arm: the same of a simulated arm.
        starts: number of starts of each test of stability.
        recordings: sets of recorded demonstrations, with their files.
        seed: of simulated demonstrations; methods draw with their own seeds.
    """

    motions: tuple[str, ...]
    points: tuple[str, ...] = tuple(POINTS)
    protocols: tuple[str, ...] = PROTOCOLS
    courses: tuple[tuple[str, str], ...] = ()
    motions_of_poses: tuple[tuple[str, str], ...] = ()
    poses: tuple[str, ...] = tuple(POSES)
    motions_of_joints: tuple[str, ...] = ()
    joints: tuple[str, ...] = tuple(JOINTS)
    online: tuple[str, ...] = ONLINE
    left_out: int | None = None
    folds: int = 2
    pushed: int | None = 3
    pushed_on_arm: int | None = 1
    starts: int = 10_000
    recordings: tuple[tuple[str, str], ...] = ()
    seed: int = 0


def configure(quick: bool, seed: int) -> ComparisonConfig:
    """All motions and, with LEADTHROUGH_DATA, all recordings; or one of each kind and few tests."""
    if MISSING:
        print(NOT_INSTALLED.format(", ".join(MISSING)), file=sys.stderr)
    courses, poses = _named(material.courses()), _named(material.motions_of_poses())
    if quick:
        return ComparisonConfig(
            _QUICK,
            points=tuple(name for name in POINTS if name not in _SLOW),
            poses=tuple(name for name in POSES if name not in _SLOW),
            courses=courses[:1],
            motions_of_poses=poses[:1],
            motions_of_joints=material.MOTIONS_OF_JOINTS,
            joints=_QUICK_JOINTS,
            online=_QUICK_JOINTS,
            left_out=1,
            folds=0,
            pushed=1,
            starts=200,
            seed=seed,
        )
    return ComparisonConfig(
        tuple(lasa.motions()),
        courses=courses,
        motions_of_poses=poses,
        motions_of_joints=material.MOTIONS_OF_JOINTS,
        seed=seed,
    )


def of_recordings(config: ComparisonConfig, folder: Path) -> ComparisonConfig:
    """The configuration with the sets in a folder, and nothing else."""
    nothing: dict[str, Any] = {"motions": (), "courses": (), "motions_of_poses": ()}
    nothing |= {"motions_of_joints": ()}
    return replace(config, recordings=sets_in(folder), **nothing)


def _named(motions: Mapping[str, Path | None]) -> tuple[tuple[str, str], ...]:
    return tuple((name, str(file or "")) for name, file in motions.items())


def tasks(config: ComparisonConfig) -> list[Task]:
    """A task for every motion and method with each protocol, and for every stability test."""
    common = {"left_out": config.left_out, "folds": config.folds}
    drawings = [
        Task(draw, {"motion": motion, "method": method, "protocol": protocol, **common})
        for motion in config.motions
        for protocol in config.protocols
        for method in config.points
    ]
    examined = [
        Task(examine, {"motion": motion, "method": method, "starts": config.starts})
        for motion in config.motions
        for method in config.points
        if method in SYSTEMS
    ]
    others = [
        Task(
            function,
            {"name": name, "method": method, "seed": config.seed, **common},
            {"file": Path(file)} if file else {},
        )
        for function, motions, methods in (
            (trace, config.courses, [each for each in config.points if each in COURSES]),
            (move, config.motions_of_poses, config.poses),
        )
        for name, file in motions
        for method in methods
    ]
    recorded = [
        Task(leave_out, {"name": name, "method": method, **common}, {"file": Path(file)})
        for name, file in config.recordings
        for method in RECORDED
    ]
    return [*drawings, *examined, *others, *_pushes(config), *recorded]


def _pushes(config: ComparisonConfig) -> list[Task]:
    """A task for every motion and method with pushes, and one on the arm if the motion is long."""
    flat = {*config.motions, *_AS_SMALL_AS_A_PUSH}
    drawings, joints = (_unrecorded(each) for each in (config.motions, config.motions_of_joints))
    return [
        Task(
            function,
            {
                "part": part,
                "name": name,
                "method": method,
                "left_out": left_out,
                "seed": config.seed,
            },
            {"file": Path(file)} if file else {},
        )
        for part, motions, methods in (
            ("drawings", drawings, config.points),
            ("courses", config.courses, config.points),
            ("poses", config.motions_of_poses, config.poses),
            ("joints", joints, config.joints),
        )
        for function, left_out in ((push, config.pushed), (push_arm, config.pushed_on_arm))
        for name, file in motions
        for method in methods
        if function is push or (name not in flat and method in config.online)
    ]


def _unrecorded(names: Sequence[str]) -> tuple[tuple[str, str], ...]:
    return tuple((name, "") for name in names)


STUDY = Study(configure, tasks, report, of_recordings)
