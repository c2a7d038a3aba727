import json

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput

STATE = [[0.1 * i, -0.1 * i] for i in range(6)]


def save(path, state=STATE, **columns):
    path.parent.mkdir(parents=True, exist_ok=True)
    content = {
        "observation.state": pa.array(state, pa.list_(pa.float32())),
        "timestamp": pa.array([0.0, 0.1, 0.2, 0.0, 0.1, 0.2], pa.float32()),
        "episode_index": [3, 3, 3, 5, 5, 5],
        "task": ["pour"] * 6,
    }
    parquet.write_table(pa.table(content | columns), path)
    return path


def describe(folder, names):
    (folder / "meta").mkdir()
    info = {"fps": 10, "features": {"observation.state": {"names": names}}}
    (folder / "meta" / "info.json").write_text(json.dumps(info))


@pytest.fixture
def file(tmp_path):
    return save(tmp_path / "data" / "chunk-000" / "file-000.parquet")


def test_every_episode_is_a_demonstration(file):
    demonstrations = lt.read_demonstrations(file)
    assert [d.name for d in demonstrations] == ["episode_3", "episode_5"]
    for d, state in zip(demonstrations, (STATE[:3], STATE[3:]), strict=True):
        np.testing.assert_allclose(d.motion.positions, state, atol=1e-7)
        np.testing.assert_allclose(d.motion.times, [0, 0.1, 0.2], atol=1e-7)
        assert d.motion.joint_names == ()


@pytest.mark.parametrize("names", [["pan.pos", "lift.pos"], {"motors": ["pan.pos", "lift.pos"]}])
def test_a_data_set_names_its_joints(file, tmp_path, names):
    describe(tmp_path, names)
    for path in (tmp_path, file):
        motion = lt.read_demonstrations(path)[1].motion
        assert motion.joint_names == ("pan.pos", "lift.pos")
        np.testing.assert_allclose(motion.positions, STATE[3:], atol=1e-7)


def test_names_of_a_point_make_points(file, tmp_path):
    describe(tmp_path, ["x", "y"])
    assert type(lt.read_demonstrations(tmp_path)[0].motion) is lt.Trajectory


def test_joints_in_degrees_have_to_be_declared(tmp_path):
    path = save(tmp_path / "degrees.parquet", [[90.0 + i, -45.0] for i in range(6)])
    refused("angles='degrees' or angles='radians'", lt.read_demonstrations, path)
    motion = lt.read_demonstrations(path, angles="degrees")[0].motion
    np.testing.assert_allclose(motion.positions[0], [np.pi / 2, -np.pi / 4])


def test_other_tables_are_refused(tmp_path):
    parquet.write_table(pa.table({"x": [1.0]}), tmp_path / "other.parquet")
    with pytest.raises(InvalidInput, match=r"expected a column 'observation.state', got x"):
        lt.read_demonstrations(tmp_path / "other.parquet")
    with pytest.raises(InvalidInput, match="lists of one length"):
        lt.read_demonstrations(save(tmp_path / "ragged.parquet", [[1, 2], [1], [1, 2, 3]] * 2))
    (tmp_path / "text.parquet").write_text("no Parquet")
    refused("not a readable Parquet file", lt.read_demonstrations, tmp_path / "text.parquet")
    describe(tmp_path, None)
    refused(r"expected files data/\*\*/\*.parquet", lt.read_demonstrations, tmp_path)


def test_missing_values_stay_until_they_are_cleaned(tmp_path):
    state = [*STATE[:1], [np.nan, 0.0], *STATE[2:]]
    path = save(tmp_path / "gaps.parquet", state)
    refused(r"sample 1, column 'observation.state'", lt.read_demonstrations, path)
    assert np.isnan(lt.io.read_recordings(path)[0].positions[1, 0])
