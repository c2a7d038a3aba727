"""Episodes of an arm for policies that learn from them, written one after the other."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.io.files import StrPath, checked_path, making_folder, replacing

HDF5 = (".hdf5", ".h5")


@dataclass(frozen=True, eq=False)
class Episode:
    """A motion of an arm, one row a frame, and the poses of objects, which stand still.

    An action is what the arm does next: the row that follows; at the end the last one again.
    """

    q: Float64Array  # (n, joints), rad
    qd: Float64Array  # (n, joints), rad/s
    tip: Float64Array  # (n, 7) in the base frame, m, then x, y, z, w
    gripper: Float64Array | None  # (n,), 1 is open, 0 closed
    objects: Float64Array  # (k,), as `Layout.objects` names them
    origin: dict[str, Any]  # numbers and texts that tell where it comes from

    @property
    def joints(self) -> Float64Array:
        """Joints, and the gripper as a further one."""
        return self.q if self.gripper is None else np.column_stack([self.q, self.gripper])


@dataclass(frozen=True)
class Layout:
    """Names and rate that all episodes of a data set share."""

    robot: str
    joints: tuple[str, ...]
    objects: tuple[str, ...]
    has_gripper: bool
    rate: float  # frames per second
    task: str  # what the arm does, in words
    origin: dict[str, Any]  # of the data set

    @property
    def state(self) -> tuple[str, ...]:
        """Names of the joints, and of the gripper."""
        return (*self.joints, "gripper") if self.has_gripper else self.joints


class EpisodeWriter(Protocol):
    """Writes episodes in their order, with memory for some of them."""

    def add(self, episode: Episode) -> None:
        """Writes an episode."""

    def close(self) -> None:
        """Writes what is about all episodes."""


def following(rows: Float64Array) -> Float64Array:
    """The rows that follow, the last one again at the end."""
    return np.concatenate([rows[1:], rows[-1:]])


def writes_hdf5(path: StrPath) -> bool:
    """Whether episodes at a path are written as HDF5; else as a LeRobot data set."""
    return checked_path(path).suffix.lower() in HDF5


@contextmanager
def writing(path: StrPath, layout: Layout) -> Iterator[EpisodeWriter]:
    """A writer of a robomimic file, or else of a LeRobot folder, made whole or not at all.

    Raises:
        InvalidInput: if the path cannot be written, or the folder is there already.
        MissingDependency: if the extra `hdf5` or `lerobot` is not installed.
    """
    target = Path(path)
    if writes_hdf5(target):
        from leadthrough.io.robomimic_writer import RobomimicWriter

        with replacing(target) as temporary:
            file = RobomimicWriter(temporary, layout)
            with file.open():
                yield file
                file.close()
        return
    from leadthrough.io.lerobot_writer import LeRobotWriter

    with making_folder(target) as temporary:
        folder = LeRobotWriter(temporary, layout)
        yield folder
        folder.close()
