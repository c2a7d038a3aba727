"""Recorded demonstrations of an arm, each in a file of its own, and changes of them."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.augmentation import write_data_set
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.demonstration_quality.judge import suspicions
from leadthrough.io.files import replacing
from leadthrough.io.formats import write_motion
from leadthrough.motion import Demonstration, Event, JointTrajectory
from leadthrough.preprocess.resample import arc_length, trimmed
from leadthrough.shapes import Scene

_STILL = 1e-4  # rad or m; joints that differ by less at a recording's ends rest
_MIN_SAMPLES = 10
_MIN_PATH, _MIN_TURN = 0.01, 0.1  # m and rad, of the tip in a demonstration
_ROUNDING = 1e-5  # s, of times on the page
_NAMES = re.compile(r"\w([\w .+()-]{0,78}[\w+()-])?")  # that files can have everywhere


class Recordings:
    """Joint motions of an arm, in a folder."""

    def __init__(self, arm: Arm, folder: Path, demonstrations: Sequence[Any]) -> None:
        self.arm, self.folder = arm, folder
        self.demonstrations = [_of_arm(arm, each, i) for i, each in enumerate(demonstrations)]
        self.former: tuple[int, list[Demonstration[JointTrajectory]], bytes | None] | None = None
        self._listed: list[dict[str, Any]] | None = None
        self.source = folder  # of the demonstrations as they are

    def add(self, motion: JointTrajectory) -> Path:
        """Writes a motion to a new file, whose path is returned."""
        name = self._free_name()
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.path(name)
        write_motion(motion, path)
        self.demonstrations.append(Demonstration(motion, name))
        self.former = None
        self._changed()
        return path

    def remove(self, index: int) -> str:
        """Deletes a demonstration and its file; its name."""
        self._remember(index).unlink(missing_ok=True)
        return self.demonstrations.pop(index).name

    def rename(self, index: int, name: object) -> Path:
        """Gives a demonstration and its file another name; the file's path."""
        given = self._checked_name(index, name)
        before, after = self._remember(index), self.path(given)
        if before.exists():
            before.rename(after)
        self.demonstrations[index] = Demonstration(self.demonstrations[index].motion, given)
        return after

    def trim(self, index: int, first: object, last: object) -> JointTrajectory:
        """Leaves the part of a motion between two times, s from its start; None is its end."""
        given = self.demonstrations[index]
        whole = float(given.motion.duration)
        most = whole + _ROUNDING
        begin = 0.0 if first is None else check.number(first, "first", at_least=0, at_most=most)
        end = whole if last is None else check.number(last, "last", at_least=0, at_most=most)
        motion = trimmed(given.motion, begin, min(end, whole))
        if not _moves(self.arm, motion):
            raise InvalidInput(f"motion: the arm hardly moves between {begin:.2f} and {end:.2f} s")
        write_motion(motion, self._remember(index))
        self.demonstrations[index] = Demonstration(motion, given.name)
        return motion

    def restore(self) -> JointTrajectory | None:
        """Takes the last change of a demonstration back, in its file too; its motion."""
        if self.former is None:
            return None
        index, demonstrations, content = self.former
        known = {each.name for each in demonstrations}
        if content is not None:
            with replacing(self.path(demonstrations[index].name)) as temporary:
                temporary.write_bytes(content)
        for each in self.demonstrations:
            if each.name not in known:
                self.path(each.name).unlink(missing_ok=True)
        self.demonstrations[:] = demonstrations
        self.former = None
        self._changed()
        return demonstrations[index].motion

    def export(self, scene: Scene) -> Path:
        """The LeRobot data set of the demonstrations, written to a new folder beside theirs."""
        names = (f"{self.folder.name}-lerobot{f'-{n}' * (n > 1)}" for n in count(1))
        free = next(path for path in map(self.folder.with_name, names) if not path.exists())
        self.source = write_data_set(self.demonstrations, self.arm, free, scene)
        return self.source

    def path(self, name: str) -> Path:
        return self.folder / f"{name}.csv"

    def _remember(self, index: int) -> Path:
        """The file of a demonstration that is about to change, kept for `restore`."""
        path = self.path(self.demonstrations[index].name)
        content = path.read_bytes() if path.exists() else None
        self.former = index, list(self.demonstrations), content
        self._changed()
        return path

    def _changed(self) -> None:
        self.source, self._listed = self.folder, None

    def _checked_name(self, index: int, name: object) -> str:
        given = name.strip() if isinstance(name, str) else ""
        if not _NAMES.fullmatch(given):
            wanted = "1 to 80 letters, digits, spaces and . + - _ ( ), first a letter or digit"
            raise check.refused("name", wanted, repr(name)[:100])
        own = self.demonstrations[index].name
        if given.casefold() in {each.casefold() for each in self._taken() - {own}}:
            raise InvalidInput(f"name: there is a {given} already")
        return given

    def checked(self, index: object) -> int:
        """The index, if there is a demonstration at it."""
        last = len(self.demonstrations) - 1
        return check.integer(-1 if index is None else index, "index", at_least=0, at_most=last)

    def listed(self) -> list[dict[str, Any]]:
        """Name, duration, length of the tip's path, and difference from the others of each."""
        if self._listed is None:
            self._listed = self._described()
        return self._listed

    def _described(self) -> list[dict[str, Any]]:
        poses = [self.arm.poses(each.motion) for each in self.demonstrations]
        several = len(poses) > 1
        differs, faults = suspicions(poses) if several else ([None] * len(poses), [()] * len(poses))
        return [
            {
                "name": each.name,
                "seconds": round(float(each.motion.duration), 2),
                "metres": round(float(arc_length(pose.positions)[-1]), 3),
                "differs": None if differ is None else round(float(differ), 1),
                "faults": fault,
            }
            for each, pose, differ, fault in zip(
                self.demonstrations, poses, differs, faults, strict=True
            )
        ]

    def _taken(self) -> set[str]:
        return {each.name for each in self.demonstrations} | {
            path.stem for path in self.folder.glob("*.csv")
        }

    def _free_name(self) -> str:
        numbers = (
            int(found[1]) for name in self._taken() if (found := re.fullmatch(r".*-(\d+)", name))
        )
        return f"demonstration-{max(numbers, default=0) + 1}"


def _of_arm(arm: Arm, given: object, index: int) -> Demonstration[JointTrajectory]:
    """A demonstration with the arm's joints in its order."""
    if not isinstance(given, Demonstration):
        raise check.refused(f"demonstrations[{index}]", "a Demonstration", type(given).__name__)
    return Demonstration(arm.joints_of(given.motion), given.name)


def recording_of(
    arm: Arm, samples: Sequence[tuple[float, Float64Array]], events: Sequence[Event]
) -> JointTrajectory | None:
    """The motion in a recording, without rest at its ends; None if the tip did not move."""
    times = np.array([time for time, _ in samples])
    q = np.array([each for _, each in samples])
    moved = np.flatnonzero(
        (np.abs(q - q[0]).max(axis=1) > _STILL) & (np.abs(q - q[-1]).max(axis=1) > _STILL)
    )
    if len(moved) < _MIN_SAMPLES:
        return None
    first, last = max(moved[0] - 1, 0), min(moved[-1] + 1, len(q) - 1)
    kept = slice(first, last + 1)
    motion = JointTrajectory(
        times[kept] - times[first],
        q[kept],
        joint_names=arm.joint_names,
        events=[
            Event(float(np.clip(each.time, times[first], times[last]) - times[first]), each.name)
            for each in events
        ],
    )
    return motion if _moves(arm, motion) else None


def _moves(arm: Arm, motion: JointTrajectory) -> bool:
    poses = arm.poses(motion)
    turned = math.dist(poses.orientations[0], poses.orientations[-1]) > 0.5 * _MIN_TURN
    return bool(arc_length(poses.positions)[-1] > _MIN_PATH or turned)
