"""Units and orders are stated by a name, an argument or the format; nothing guesses them."""

import sys

import numpy as np
import pytest
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput, MissingDependency

TURN = [0.8, 0.6, 0.0, 0.0]  # w, x, y, z


def read(path, **options):
    (demonstration,) = lt.read_demonstrations(path, **options)
    return demonstration.motion


@pytest.fixture
def table(tmp_path):
    def to_file(header, *rows):
        path = tmp_path / "recording.csv"
        lines = [header, *(",".join(map(str, row)) for row in rows)]
        path.write_text("\n".join(lines) + "\n")
        return path

    return to_file


@pytest.fixture
def archive(tmp_path):
    def to_file(**arrays):
        path = tmp_path / "recording.npz"
        np.savez(path, times=[0.0, 1.0], positions=np.zeros((2, 3)), **arrays)
        return path

    return to_file


@pytest.mark.parametrize(
    ("header", "row", "time", "angles"),
    [
        ("t,joint_1_deg,joint_2_deg", (1, 90, -180), 1.0, (np.pi / 2, -np.pi)),
        ("time_ms,joint_1 [deg],joint_2 (deg)", (500, 90, -180), 0.5, (np.pi / 2, -np.pi)),
        ("timestamp_ns,joint_1_rad,joint_2_rad", (2e9, 20, 1), 2.0, (20, 1)),
        ("t [us],joint_1_deg,joint_2", (3e6, 90, 1), 3.0, (np.pi / 2, 1)),
        ("Time (Seconds),joint_1 [°],joint_2 [mrad]", (1, 90, 20), 1.0, (np.pi / 2, 0.02)),
    ],
)
def test_units_in_names_are_followed(table, header, row, time, angles):
    motion = read(table(header, row))
    assert motion.times[0] == pytest.approx(time)
    np.testing.assert_allclose(motion.positions, [angles])
    assert motion.joint_names == ("joint_1", "joint_2")


def test_lengths_in_names_are_followed(table):
    motion = read(table("t,x_mm,y_cm,z_m", (0, 1500, 150, 1.5)))
    np.testing.assert_allclose(motion.positions, [[1.5, 1.5, 1.5]])


def test_an_argument_states_the_unit_of_angles(table):
    path = table("t,q0,q1,q0_velocity,q1_velocity", (0, 90, 0, 180, 0), (1, 90, 0, 180, 0))
    refused(r"angles: joints reach 90, .* angles='degrees'", read, path)
    assert read(path, angles="radians").positions[0, 0] == 90
    motion = read(path, angles="degrees")
    assert motion.positions[0, 0] == pytest.approx(np.pi / 2)
    assert motion.velocities[0, 0] == pytest.approx(np.pi)


def test_a_spike_is_not_taken_for_degrees(table):
    path = table("t,q0", (0, 1), (1, 1000), (2, 1))
    assert read(path).positions[1, 0] == 1000


@pytest.mark.parametrize("order", ["wxyz", "xyzw"])
def test_four_numbers_in_one_array_need_an_order(archive, order):
    stored = np.tile([TURN["wxyz".index(axis)] for axis in order], (2, 1))
    path = archive(orientations=stored)
    refused("in orientations is not stated; set quaternio", read, path)
    np.testing.assert_allclose(read(path, quaternions=order).orientations, [TURN] * 2)
    path = archive(**{f"orientations_{order}": stored})
    np.testing.assert_allclose(read(path).orientations, [TURN] * 2)


def test_names_of_components_tell_the_order_however_they_are_listed(table):
    path = table("t,x,y,z,qx,qy,qz,qw", (0, 0, 0, 0, 0.6, 0, 0, 0.8))
    for listed in (["qx", "qy", "qz", "qw"], ["qw", "qx", "qy", "qz"]):
        np.testing.assert_allclose(
            read(path, columns={"orientations": listed}).orientations, [TURN]
        )


def test_names_that_tell_no_component_need_an_order(table):
    path = table("t,x,y,z,r0,r1,r2,r3", (0, 0, 0, 0, 0.6, 0, 0, 0.8))
    columns = {"orientations": ["r0", "r1", "r2", "r3"]}
    refused("order of the numbers in r0, r1, r2, r3 is not stated", read, path, columns=columns)
    motion = read(path, columns=columns, quaternions="xyzw")
    np.testing.assert_allclose(motion.orientations, [TURN])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"angles": "grad"}, "angles: expected one of 'radians', 'degrees'"),
        ({"quaternions": "wzyx"}, "quaternions: expected one of 'wxyz', 'xyzw'"),
        ({"topic": 3}, "topic: expected a topic's name"),
        ({"frames": "base"}, "frames: expected the names"),
        ({"frames": (1, 2)}, "frames: expected the names of a frame"),
    ],
)
def test_statements_that_say_nothing_are_refused(table, options, message):
    for function in (lt.read_demonstrations, lt.io.read_recordings):
        refused(message, function, table("t,x,y", (0, 0, 0)), **options)


def test_recordings_keep_what_demonstrations_may_not_have(table):
    path = table("t,x,y", (1, 0, 0), (0, "", "inf"), (0, "nan", 3))
    refused("line 3, column 'x': expected a finite number, got nan", lt.read_demonstrations, path)
    (recording,) = lt.io.read_recordings(path)
    assert np.array_equal(recording.times, [1, 0, 0])
    assert np.isnan(recording.positions[1:, 0]).all()
    assert (recording.kind, recording.name) == ("points", "recording")
    with pytest.raises(ValueError, match="read-only"):
        recording.times[0] = 0.0
    for wrong in ({"times": [[0]]}, {"orientations": [[1, 0, 0, 0]] * 3}, {"positions": "abc"}):
        with pytest.raises(InvalidInput):
            lt.io.Recording(**{"times": [0.0, 1.0], "positions": [[0.0], [1.0]], **wrong})


@pytest.mark.parametrize(
    ("suffix", "package", "extra"),
    [
        ("hdf5", "h5py", "hdf5"),
        ("parquet", "pyarrow", "lerobot"),
        ("mcap", "rosbags.highlevel", "ros"),
    ],
)
def test_a_missing_package_is_named_with_its_extra(tmp_path, monkeypatch, suffix, package, extra):
    path = tmp_path / f"recording.{suffix}"
    path.touch()
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingDependency, match=rf"leadthrough\[{extra}\]"):
        lt.read_demonstrations(path)


def test_a_bag_cannot_be_written_without_its_package(tmp_path, monkeypatch, poses):
    monkeypatch.setitem(sys.modules, "rosbags.rosbag2", None)
    with pytest.raises(MissingDependency, match=r"leadthrough\[ros\]"):
        lt.write_motion(poses, tmp_path / "bag.mcap")
    assert not list(tmp_path.iterdir())
