"""Data sets as streams: bounded memory, each episode's faults in a table, damaged ones left out."""

import csv
import json
import tracemalloc

import h5py
import numpy as np
import pyarrow as pa
import pytest
from cli.command_line import run
from motions import minimum_jerk
from pyarrow import parquet
from refusals import refused

import leadthrough as lt
from leadthrough.io import stream_recordings

EPISODES, SAMPLES = 60, 50


def path_of(number):
    """Joints (SAMPLES, 3) of an episode."""
    phase = np.linspace(0.0, 1.0, SAMPLES)[:, None]
    eased = minimum_jerk(phase)
    return eased * [0.5, -0.3, 0.8] + 0.001 * number


def with_faults(number):
    rows = path_of(number)
    if number == 7:
        rows[20] = np.nan
    if number == 9:
        rows[:] = np.nan
    return rows


@pytest.fixture
def robomimic(tmp_path):
    path = tmp_path / "low_dim.hdf5"
    with h5py.File(path, "w") as file:
        data = file.create_group("data")
        data.attrs["env_args"] = json.dumps({"env_kwargs": {"control_freq": 20}})
        for number in range(EPISODES):
            data[f"demo_{number}/obs/robot0_joint_pos"] = with_faults(number)
        del data["demo_11/obs/robot0_joint_pos"]
    return path


@pytest.fixture
def lerobot(tmp_path):
    folder = tmp_path / "set"
    for chunk in range(3):
        numbers = range(20 * chunk, 20 * (chunk + 1))
        rows = np.concatenate([with_faults(number) for number in numbers])
        content = {
            "observation.state": pa.array(rows.tolist(), pa.list_(pa.float64())),
            "timestamp": np.tile(np.arange(SAMPLES) / 20.0, len(numbers)),
            "episode_index": np.repeat(numbers, SAMPLES),
        }
        file = folder / "data" / "chunk-000" / f"file-{chunk:03d}.parquet"
        file.parent.mkdir(parents=True, exist_ok=True)
        parquet.write_table(pa.table(content), file)
    (folder / "meta").mkdir()
    (folder / "meta" / "info.json").write_text("{}")
    return folder


def table_of(path):
    with path.open() as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("which", ["robomimic", "lerobot"])
def test_a_skill_is_learned_and_each_episodes_fault_is_told(which, tmp_path, request):
    path = request.getfixturevalue(which)
    words = ("--model", "promp", "--samples", 40, "--table", tmp_path / "faults.csv")
    run("learn", path, *words, "-o", tmp_path / "skill.npz")
    rows = table_of(tmp_path / "faults.csv")
    assert len(rows) == EPISODES
    left_out = [row["episode"].split("_")[1] for row in rows if row["used"] == "no"]
    assert left_out == (["9", "11"] if which == "robomimic" else ["9"])
    assert all(row["problem"] for row in rows if row["used"] == "no")
    faulty = {row["episode"]: row["missing"] for row in rows if row["missing"] not in ("", "0")}
    assert list(faulty.values()) == ["1"] and "7" in next(iter(faulty))
    end = lt.load_skill(tmp_path / "skill.npz").generate().positions[-1]
    assert end == pytest.approx(path_of(EPISODES / 2)[-1], abs=2e-3)


def test_cleaned_episodes_are_files_with_the_episodes_numbers(robomimic, tmp_path):
    out = tmp_path / "clean" / "episode.npz"
    out.parent.mkdir()
    run("clean", robomimic, "--table", tmp_path / "faults.csv", "-o", out)
    numbers = sorted(int(path.stem.split("_")[1]) for path in out.parent.iterdir())
    assert numbers == [n + 1 for n in range(EPISODES) if n not in (9, 11)]


def test_a_stream_is_what_is_read_at_once(lerobot, robomimic):
    for path in (lerobot, robomimic):
        for episode in stream_recordings(path):
            if episode.recording is None:
                assert "11" in episode.name
                continue
            number = int(episode.recording.name.split("_")[1])
            assert np.array_equal(episode.recording.positions, with_faults(number), equal_nan=True)


def test_motors_have_the_extents_of_the_whole_data_set(lerobot):
    names = ["pan.pos", "lift.pos", "gripper.pos"]
    info = {"features": {"observation.state": {"names": names}}}
    (lerobot / "meta" / "info.json").write_text(json.dumps(info))
    whole = lt.io.read_recordings(lerobot, angles="degrees")
    streamed = [each.recording for each in stream_recordings(lerobot, angles="degrees")]
    assert [each.events for each in streamed] == [each.events for each in whole]
    for one, other in zip(streamed, whole, strict=True):
        assert np.array_equal(one.positions, other.positions, equal_nan=True)


def test_memory_does_not_grow_with_the_number_of_episodes(robomimic):
    peaks = []
    for count in (20, EPISODES):
        tracemalloc.start()
        episodes = stream_recordings(robomimic)
        for _ in range(count):
            next(episodes)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.3 * peaks[0] + 50_000


def test_where_nothing_can_be_used_the_command_says_why(tmp_path):
    (tmp_path / "broken.csv").write_text("t,q1\n0,nan\n")
    result = run("learn", tmp_path / "broken.csv", "--table", tmp_path / "faults.csv", "-o",
                 tmp_path / "skill.npz", code=2)  # fmt: skip
    assert "broken" in result.stderr
    assert table_of(tmp_path / "faults.csv")[0]["used"] == "no"
    refused("rate", next, stream_recordings(tmp_path / "broken.csv", rate=-1.0))
