import numpy as np
import pytest
from hypothesis import given, strategies as st
from refusals import refused
from scipy.io import savemat
from scipy.sparse import csr_array

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.io.mat import variables

TIMES = np.linspace(0.0, 1.0, 5)
POINTS = np.vstack([TIMES, TIMES**2, TIMES**3])


@pytest.fixture
def save(tmp_path):
    def to_file(**variables):
        savemat(tmp_path / "recording.mat", variables)
        return tmp_path / "recording.mat"

    return to_file


def cells(*structures):
    result = np.empty(len(structures), object)
    result[:] = structures
    return result


def test_each_structure_is_a_demonstration(save):
    path = save(demos=cells({"pos": POINTS, "t": TIMES}, {"pos": POINTS[:, :4], "t": TIMES[:4]}))
    demonstrations = lt.read_demonstrations(path)
    assert [d.name for d in demonstrations] == ["recording[0]", "recording[1]"]
    assert np.array_equal(demonstrations[0].motion.positions, POINTS.T)
    assert np.array_equal(demonstrations[1].motion.times, TIMES[:4])


def test_arrays_of_structures_are_read_as_well(save):
    structures = np.empty((1, 2), dtype=[("pos", object), ("vel", object)])
    structures["pos"] = [[cells(POINTS)[0], cells(2 * POINTS)[0]]]
    structures["vel"] = [[cells(POINTS)[0], cells(POINTS)[0]]]
    demonstrations = lt.read_demonstrations(save(symbol=structures), rate=4)
    assert np.array_equal(demonstrations[1].motion.positions, 2 * POINTS.T)
    assert np.array_equal(demonstrations[1].motion.times, TIMES)


def test_plain_variables_are_one_demonstration(save):
    (demonstration,) = lt.read_demonstrations(save(time=TIMES, joints=POINTS.T, rate=4.0))
    assert demonstration.name == "recording"
    assert type(demonstration.motion) is lt.JointTrajectory
    assert np.array_equal(demonstration.motion.positions, POINTS.T)


def test_fields_can_be_mapped(save):
    path = save(demos=cells({"path": POINTS, "clock": TIMES, "note": "by hand"}))
    (demonstration,) = lt.read_demonstrations(path, columns={"time": "clock", "positions": "path"})
    assert np.array_equal(demonstration.motion.positions, POINTS.T)


def test_newer_matlab_files_are_named_as_such(tmp_path):
    path = tmp_path / "recording.mat"
    path.write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + bytes(400))
    refused(r"expected MATLAB 7.2 or older; save with -v7", lt.read_demonstrations, path)


@pytest.mark.parametrize("compressed", [True, False])
@pytest.mark.parametrize("kind", ["f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "?"])
def test_numbers_of_every_kind_keep_their_order_and_shape(tmp_path, compressed, kind):
    values = (np.arange(24).reshape(2, 3, 4) % 100).astype(kind)
    path = tmp_path / "numbers.mat"
    savemat(path, {"a": values, "b": {"deep": cells({"c": values[0]})}}, do_compression=compressed)
    found = variables(path.read_bytes())
    assert np.array_equal(found["a"], values)
    assert np.array_equal(found["b"][0]["deep"][0][0]["c"], values[0])


def test_what_is_no_number_is_left_out(tmp_path):
    path = tmp_path / "others.mat"
    savemat(path, {"text": "by hand", "complex": 1j, "sparse": csr_array(np.eye(3)), "empty": []})
    found = variables(path.read_bytes())
    assert found["text"] is found["complex"] is found["sparse"] is None
    assert found["empty"].size == 0


def test_what_makes_no_motion_is_refused(save):
    for given_variables, message in [
        ({"a": {"pos": POINTS}, "b": {"pos": POINTS}}, "structures in one variable, got them in a"),
        ({"demos": {"force": POINTS}}, "no names of positions or joints found"),
        ({"demos": {"pos": POINTS}}, "rate: the file has no time column"),
        ({"demos": {"pos": POINTS, "t": TIMES[:3]}}, "t: expected one time for each of 5 samples"),
        ({"demos": {"pos": POINTS * np.nan, "t": TIMES}}, "'pos': expected a finite"),
        ({"demos": {"pos": "text", "t": TIMES}}, "pos: expected numbers"),
        (
            {"demos": {"pos": np.zeros((0, 0)), "t": TIMES}},
            "t: expected one time for each of 0 samples",
        ),
        ({}, "no names of positions or joints found"),
    ]:
        refused(message, lt.read_demonstrations, save(**given_variables))
    path = save(demos=cells({"pos": cells(POINTS, TIMES), "t": TIMES}))
    refused("pos: expected ", lt.read_demonstrations, path)


@given(data=st.data(), compressed=st.booleans())
def test_a_damaged_file_is_read_or_refused(tmp_path_factory, data, compressed):
    """A few of its bytes are changed and its end is cut off; errors have to name the file."""
    path = tmp_path_factory.mktemp("damaged") / "damaged.mat"
    savemat(path, {"demos": {"pos": POINTS, "t": TIMES}}, do_compression=compressed)
    content = bytearray(path.read_bytes())
    for i in data.draw(st.lists(st.integers(0, len(content) - 1), max_size=4)):
        content[i] = data.draw(st.integers(0, 255))
    path.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    try:
        lt.read_demonstrations(path)
    except InvalidInput as error:
        assert path.name in str(error)
