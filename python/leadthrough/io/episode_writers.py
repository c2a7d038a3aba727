"""Writers of episodes by the path's suffix: HDF5 for robomimic, else a folder for LeRobot."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Protocol

from leadthrough.io.episodes import Episode, Layout
from leadthrough.io.files import StrPath, checked_path, making_folder, replacing
from leadthrough.io.lerobot_writer import LeRobotWriter
from leadthrough.io.robomimic_writer import RobomimicWriter

_HDF5 = (".hdf5", ".h5")


class EpisodeWriter(Protocol):
    """Writes episodes in their order, with memory for some of them."""

    def add(self, episode: Episode) -> None:
        """Writes an episode."""

    def close(self) -> None:
        """Writes what is about all episodes."""


def writes_hdf5(path: StrPath) -> bool:
    """Whether episodes at a path are written as HDF5; else as a LeRobot data set."""
    return checked_path(path).suffix.lower() in _HDF5


@contextmanager
def writing(path: StrPath, layout: Layout) -> Iterator[EpisodeWriter]:
    """A writer of a robomimic file, or else of a LeRobot folder, made whole or not at all.

    Raises:
        InvalidInput: if the path cannot be written, or the folder is there already.
        MissingDependency: if the extra `hdf5` or `lerobot` is not installed.
    """
    target = Path(path)
    if writes_hdf5(target):
        with replacing(target) as temporary:
            file = RobomimicWriter(temporary, layout)
            with file.open():
                yield file
                file.close()
        return
    with making_folder(target) as temporary:
        folder = LeRobotWriter(temporary, layout)
        yield folder
        folder.close()
