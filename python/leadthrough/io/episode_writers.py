"""Episodes of an arm, for policies that learn from them, written by the path's suffix.

HDF5 is as robomimic reads it, with a group `data/demo_<i>` for each episode: `obs` has the arrays
that robosuite calls `robot0_joint_pos`, `robot0_joint_vel`, `robot0_eef_pos`, `robot0_eef_quat`
(x, y, z, w), `robot0_gripper_qpos` and `object`; `actions` are the next joints and gripper,
`actions_eef` the next pose. Needs the extra `hdf5`.

A folder is a LeRobot data set of version 3: Parquet files, and JSON about them.
`observation.state` holds the joints, and the gripper if there is one, `action` the next ones;
`observation.velocity`, `observation.ee_pose` and `ee_action` are further columns (m, then x, y, z,
w), and `observation.environment_state` has the objects, which a policy without cameras needs.
Frames are written a file at a time, so that memory is bounded. Needs the extra `lerobot`.

Images are not made. Sources: https://robomimic.github.io/docs/datasets/overview.html and
https://huggingface.co/docs/lerobot/lerobot-dataset-v3.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.io.files import StrPath, checked_path, making_folder, replacing


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
        return (*self.joints, "gripper") if self.has_gripper else self.joints


def following(rows: Float64Array) -> Float64Array:
    """The rows that follow, the last one again at the end."""
    return np.concatenate([rows[1:], rows[-1:]])


_FILES = 1000  # of a folder
_FRAMES = 50_000  # of a file, and of memory
_EPISODES = 1000  # of a file about episodes
_POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")
_INDICES = ("frame_index", "episode_index", "index", "task_index")
_DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_ABOUT = "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"

Values = NDArray[np.generic]


class LeRobotWriter:
    """A folder to which episodes are added."""

    def __init__(self, folder: Path, layout: Layout) -> None:
        self._arrow = check.package("pyarrow", extra="lerobot")
        self._parquet = check.package("pyarrow.parquet", extra="lerobot")
        self._folder, self._layout = folder, layout
        self._frames: list[dict[str, Values]] = []  # of the file to be written
        self._about: list[dict[str, Any]] = []  # of its episodes, and of those before
        self._pending = 0  # frames of the file to be written
        self._files = self._about_files = 0
        self._episodes = self._total = 0
        self._sums: dict[str, _Sums] = {}

    def add(self, episode: Episode) -> None:
        """Writes an episode, or keeps it for the next file."""
        rows = self._columns(episode)
        count = len(episode.q)
        if self._pending and self._pending + count > _FRAMES:
            self._write_frames()
        chunk, file = divmod(self._files, _FILES)
        about_chunk, about_file = divmod(self._about_files, _FILES)
        about: dict[str, Any] = {
            "episode_index": self._episodes,
            "tasks": [self._layout.task],
            "length": count,
            "data/chunk_index": chunk,
            "data/file_index": file,
            "dataset_from_index": self._total,
            "dataset_to_index": self._total + count,
            "meta/episodes/chunk_index": about_chunk,
            "meta/episodes/file_index": about_file,
        }
        for name, values in rows.items():
            own = _Sums.of(values)
            self._sums[name] = own if name not in self._sums else self._sums[name].joined(own)
            about |= {f"stats/{name}/{kind}": each for kind, each in own.told().items()}
        self._about.append(about | {f"origin/{k}": v for k, v in episode.origin.items()})
        self._frames.append(rows)
        self._pending += count
        self._total += count
        self._episodes += 1
        if len(self._about) >= _EPISODES:
            self._write_about()

    def close(self) -> None:
        if self._frames:
            self._write_frames()
        if self._about:
            self._write_about()
        self._write_tasks()
        told = {name: sums.told() for name, sums in self._sums.items()}
        for name, content in (
            ("info", self._info()),
            ("stats", told),
            ("leadthrough", self._layout.origin),
        ):
            file = self._folder / "meta" / f"{name}.json"
            file.write_text(json.dumps(content, indent=4) + "\n", encoding="utf-8")

    def _columns(self, episode: Episode) -> dict[str, Values]:
        count = len(episode.q)
        frames = np.arange(count)
        floats = {
            "observation.state": episode.joints,
            "observation.velocity": episode.qd,
            "observation.ee_pose": episode.tip,
            "observation.environment_state": np.tile(episode.objects, (count, 1)),
            "action": following(episode.joints),
            "ee_action": following(episode.tip),
            "timestamp": frames / self._layout.rate,
        }
        numbers = (frames, np.full(count, self._episodes), self._total + frames, np.zeros(count))
        return {
            **{name: rows.astype(np.float32) for name, rows in floats.items()},
            **{name: n.astype(np.int64) for name, n in zip(_INDICES, numbers, strict=True)},
        }

    def _write_frames(self) -> None:
        names = self._frames[0]
        columns = {
            name: self._column(np.concatenate([rows[name] for rows in self._frames]))
            for name in names
        }
        self._write(_DATA, self._files, self._arrow.table(columns))
        self._files += 1
        self._frames, self._pending = [], 0

    def _write_about(self) -> None:
        self._write(_ABOUT, self._about_files, self._arrow.Table.from_pylist(self._about))
        self._about_files += 1
        self._about = []

    def _write(self, pattern: str, number: int, table: Any) -> None:
        chunk, file = divmod(number, _FILES)
        path = self._folder / pattern.format(chunk_index=chunk, file_index=file)
        path.parent.mkdir(parents=True, exist_ok=True)
        self._parquet.write_table(table, path)

    def _column(self, values: Values) -> Any:
        if values.ndim == 1:
            return self._arrow.array(values)
        flat = self._arrow.array(values.ravel())
        return self._arrow.FixedSizeListArray.from_arrays(flat, values.shape[1])

    def _write_tasks(self) -> None:
        """The tasks as pandas writes them, with their texts as its index."""
        table = self._arrow.table({"task_index": [0], "task": [self._layout.task]})
        column = {"pandas_type": "int64", "numpy_type": "int64", "metadata": None}
        text = {"pandas_type": "unicode", "numpy_type": "object", "metadata": None}
        told = {
            "index_columns": ["task"],
            "column_indexes": [],
            "columns": [
                {"name": "task_index", "field_name": "task_index", **column},
                {"name": "task", "field_name": "task", **text},
            ],
            "pandas_version": "2.2.0",
        }
        self._parquet.write_table(
            table.replace_schema_metadata({"pandas": json.dumps(told)}),
            self._folder / "meta" / "tasks.parquet",
        )

    def _info(self) -> dict[str, Any]:
        layout = self._layout
        vectors = {
            "observation.state": layout.state,
            "observation.velocity": layout.joints,
            "observation.ee_pose": _POSE,
            "observation.environment_state": layout.objects,
            "action": layout.state,
            "ee_action": _POSE,
        }
        scalars = {"timestamp": "float32", **dict.fromkeys(_INDICES, "int64")}
        rate = layout.rate
        return {
            "codebase_version": "v3.0",
            "robot_type": layout.robot,
            "total_episodes": self._episodes,
            "total_frames": self._total,
            "total_tasks": 1,
            "chunks_size": _FILES,
            "data_files_size_in_mb": 100,
            "video_files_size_in_mb": 500,
            "fps": int(rate) if rate == int(rate) else rate,
            "splits": {"train": f"0:{self._episodes}"},
            "data_path": _DATA,
            "video_path": None,
            "features": {
                **{
                    name: {"dtype": "float32", "shape": [len(names)], "names": list(names)}
                    for name, names in vectors.items()
                },
                **{
                    name: {"dtype": kind, "shape": [1], "names": None}
                    for name, kind in scalars.items()
                },
            },
        }


class _Sums:
    """Extents, mean and variance of columns, joined episode by episode (Chan et al. 1979)."""

    def __init__(
        self,
        count: int,
        extent: tuple[Float64Array, Float64Array],
        mean: Float64Array,
        squares: Float64Array,
    ) -> None:
        self._count, self._extent, self._mean, self._squares = count, extent, mean, squares

    @staticmethod
    def of(values: Values) -> _Sums:
        rows = values.astype(np.float64).reshape(len(values), -1)
        mean = rows.mean(axis=0)
        squares = ((rows - mean) ** 2).sum(axis=0)
        return _Sums(len(rows), (rows.min(axis=0), rows.max(axis=0)), mean, squares)

    def joined(self, other: _Sums) -> _Sums:
        count = self._count + other._count
        away = other._mean - self._mean
        extent = (
            np.minimum(self._extent[0], other._extent[0]),
            np.maximum(self._extent[1], other._extent[1]),
        )
        mean = self._mean + away * other._count / count
        squares = self._squares + other._squares + away**2 * (self._count * other._count / count)
        return _Sums(count, extent, mean, squares)

    def told(self) -> dict[str, list[float] | list[int]]:
        return {
            "min": self._extent[0].tolist(),
            "max": self._extent[1].tolist(),
            "mean": self._mean.tolist(),
            "std": np.sqrt(self._squares / self._count).tolist(),
            "count": [self._count],
        }


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


EpisodeWriter = LeRobotWriter | RobomimicWriter


def writes_hdf5(path: StrPath) -> bool:
    """Whether episodes at a path are written as HDF5; else as a LeRobot data set."""
    return checked_path(path).suffix.lower() in (".hdf5", ".h5")


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
