"""Writers of episodes by the path's suffix: HDF5 as robomimic reads it, else a folder for LeRobot.

The HDF5 file has a group `data/demo_<i>` for each episode.

`obs` has the arrays that robosuite calls `robot0_joint_pos`, `robot0_joint_vel`, `robot0_eef_pos`,
`robot0_eef_quat` (x, y, z, w), `robot0_gripper_qpos` and `object`; `actions` are the next joints
and gripper, `actions_eef` the next pose. Images are not made. Needs the extra `hdf5`.

Source: https://robomimic.github.io/docs/datasets/overview.html.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from leadthrough import check
from leadthrough.io.episodes import Episode, Layout, following
from leadthrough.io.files import StrPath, checked_path, making_folder, replacing
from leadthrough.io.lerobot_writer import LeRobotWriter


class RobomimicWriter:
    """A file to which episodes are added while it is open."""

    def __init__(self, path: Path, layout: Layout) -> None:
        self._h5py = check.package("h5py", extra="hdf5")
        self._path = path
        self._layout = layout
        self._count = self._frames = 0
        self._data: Any = None  # of h5py, which declares no types

    @contextmanager
    def open(self) -> Iterator[None]:
        """Keeps the file open."""
        with self._h5py.File(self._path, "w") as file:
            self._data = file.create_group("data")
            yield

    def add(self, episode: Episode) -> None:
        """Writes an episode."""
        group = self._data.create_group(f"demo_{self._count}")
        count = len(episode.q)
        seen = _observed(episode)
        for folder, rows in (
            ("obs", seen),
            ("next_obs", {k: following(v) for k, v in seen.items()}),
        ):
            for name, values in rows.items():
                group.create_dataset(f"{folder}/{name}", data=values)
        done = np.zeros(count, np.int64)
        done[-1] = 1
        group.create_dataset("actions", data=following(episode.joints))
        group.create_dataset("actions_eef", data=following(episode.tip))
        group.create_dataset("rewards", data=done.astype(np.float64))
        group.create_dataset("dones", data=done)
        group.attrs["num_samples"] = count
        for name, value in episode.origin.items():
            group.attrs[name] = value
        self._count += 1
        self._frames += count

    def close(self) -> None:
        """Writes what is about all episodes."""
        layout = self._layout
        arguments = {
            "env_name": layout.task,
            "env_type": 1,
            "env_kwargs": {"control_freq": layout.rate, "robots": [layout.robot]},
        }
        self._data.attrs["total"] = self._frames
        self._data.attrs["env_args"] = json.dumps(arguments)
        self._data.attrs["joints"] = json.dumps(layout.state)
        self._data.attrs["objects"] = json.dumps(layout.objects)
        self._data.attrs["origin"] = json.dumps(layout.origin)


def _observed(episode: Episode) -> dict[str, Any]:
    rows = {
        "robot0_joint_pos": episode.q,
        "robot0_joint_vel": episode.qd,
        "robot0_eef_pos": episode.tip[:, :3],
        "robot0_eef_quat": episode.tip[:, 3:],
        "object": np.tile(episode.objects, (len(episode.q), 1)),
    }
    if episode.gripper is not None:
        rows["robot0_gripper_qpos"] = episode.gripper[:, None]
    return rows


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
    """A writer of a robomimic file, or else of a LeRobot folder, made whole or not at all."""
    target = checked_path(path)
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
