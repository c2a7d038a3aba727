"""Columns that names tell, or tell only to a person: proposed, named or refused, never mistaken."""

import json
import re

import numpy as np
import pytest
from refusals import raised, refused

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.io import formats
from leadthrough.io.guesses import guessed
from leadthrough.io.table import Request, as_request
from leadthrough.sanity import ImplausibleInputWarning


def test_columns_in_another_order_than_their_names_tell_are_refused_and_proposed_in_it(write):
    """PolyScope's names by the alphabet: `base` and `shoulder` tell no joint alone."""
    joints = [f"{name}_joint" for name in ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1")]
    arm, names = dict.fromkeys(joints, (-4.0, 4.0)), ["base", "elbow", "shoulder", "wrist1"]
    path = write("time,mode," + ",".join(names) + "\n0,7,1,2,3,4\n1,7,1,2,3,4\n")
    wanted = "base,shoulder,elbow,wrist1"
    error = raised(InvalidInput, lt.read_motion, path, joints=arm)
    assert str(error).endswith(f"columns['joints']={wanted}")
    refused(
        "elbow stands for shoulder_lift",
        lt.read_motion,
        path,
        joints=arm,
        columns={"joints": names},
    )
    told = lt.read_motion(path, joints=arm, columns={"joints": wanted.split(",")})
    assert told.joint_names == tuple(joints)
    assert np.array_equal(told.positions[0], [1, 3, 2, 4])


@pytest.mark.parametrize(
    "header",
    [
        "tcpX,tcpY,tcpZ,tcpRx,tcpRy,tcpRz",
        "Position_px,Position_py,Position_pz,Quaternion_qw,a,b",
        "x_mm,y_mm,z_mm,a_deg,b_deg,c_deg",
    ],
)
def test_tool_poses_are_not_proposed_as_joints(write, header):
    arm = dict.fromkeys(["a1", "a2", "a3", "a4", "a5", "a6"], (-4.0, 4.0))
    path = write(f"time,{header}\n0,1,2,3,1,5,6\n1,1,2,4,1,5,6\n")
    (table,) = formats.of_file(path).tables(path, Request())
    assert "joints" not in guessed(table, as_request(joints=arm))


def test_merged_cells_above_several_columns_are_of_all_of_them(write):
    rows = "0,1,2,3,4\n0.1,1,2,3,4\n"
    for title in (",Joint angles,,,", "Robot,UR3,,,"):
        motion = lt.read_motion(write(f"{title}\ntime,q1,q2,q3,q4\n{rows}"))
        assert motion.joint_names == ("q1", "q2", "q3", "q4")
    path = write(f",Actual,,Target,\ntime,q1,q2,q1,q2\n{rows}")
    assert lt.read_motion(path).joint_names == ("Actual_q1", "Actual_q2")
    rows = "0,0,1,2,3,0,0,0,1\n1,0.1,1,2,3,0,0,0,1\n"  # as OptiTrack writes them
    title = (
        ",Type,Body,Body,Body,Body,Body,Body,Body\n,,Position,Position,Position" + ",Rotation" * 4
    )
    poses = lt.read_motion(write(f"{title}\nFrame,Time (Seconds),X,Y,Z,X,Y,Z,W\n{rows}"))
    assert np.array_equal(poses.times, [0.0, 0.1])
    assert np.array_equal(poses.orientations[0], [1.0, 0.0, 0.0, 0.0])
    rows = "0,1,2,3,4\n0.1,1,2,3,4\n"
    refused(
        "both poses and joints",
        lt.read_motion,
        write(f",Position,,Joints,\ntime,x,y,q1,q2\n{rows}"),
    )


def test_axis_t_of_a_yaskawa_is_no_time(write):
    rows = "1,2,3,4,5,6.0\n1,2,3,4,5,6.5\n"
    path = write(f"S,L,U,R,B,T\n{rows}")
    refused("rate: the file has no time column", lt.read_motion, path)
    motion = lt.read_motion(path, rate=10.0)
    assert motion.joint_names == ("S", "L", "U", "R", "B", "T")
    assert motion.times[1] == pytest.approx(0.1)
    seven = lt.read_motion(write("S,L,U,R,B,T,E\n1,2,3,4,5,6,7\n1,2,3,4,5,6,8\n"), rate=10.0)
    assert seven.joint_names == ("S", "L", "E", "U", "R", "B", "T")
    named = {"joints": ["a", "T"]}
    assert lt.read_motion(write("a,T\n1,2\n1,3\n"), columns=named, rate=10.0).positions[1, 1] == 3.0


def test_words_for_missing_numbers_are_missing_and_no_other_words(write):
    cells = ["NA", "n/a", "#N/A", "--", "None", "null", ""]
    rows = "".join(f"{i / 10},{cell},{i}\n" for i, cell in enumerate(["1", *cells, "1", "1"]))
    (found,) = lt.io.read_recordings(write(f"time,q1,q2\n{rows}"))
    assert np.array_equal(np.isnan(found.positions[:, 0]), [False] + [True] * 7 + [False] * 2)
    refused("expected a number, got 'off'", lt.read_motion, write(f"time,q1,q2\n{rows}2,off,1\n"))


def test_two_columns_for_one_joint_are_never_chosen_between(write):
    arm = {"a_joint": (-4.0, 4.0), "b_joint": (-4.0, 4.0)}
    for header in (
        "time,joint_1,joint_2,joint_1_position,joint_2_position",
        "time,joint_1_position,joint_2_position,joint_1,joint_2",
        "time,q1,q2,Q1,Q2",
        "time,a_joint,b_joint,a_joint_position,b_joint_position",
    ):
        path = write(f"{header}\n0,1,2,3,4\n1,1,2,3,4\n")
        refused("joints: several fit", lt.read_motion, path)
    refused("joints: several fit", lt.read_motion, path, joints=arm)
    told = lt.read_motion(
        write("time,a_joint,b_joint,ref_a_joint,ref_b_joint\n0,1,2,3,4\n1,1,2,3,4\n")
    )
    assert told.joint_names == ("a_joint", "b_joint")


@pytest.mark.parametrize(
    "turned", ["qi,qj,qk,qr", "euler_x,euler_y,euler_z", "alpha,beta,gamma", "nx,ny,nz,ox,oy,oz"]
)
def test_orientations_that_are_not_read_are_named(write, turned):
    numbers = ",".join("1" * len(turned.split(",")))
    path = write(f"time,x,y,z,{turned}\n0,1,2,3,{numbers}\n1,1,2,4,{numbers}\n")
    with pytest.warns(ImplausibleInputWarning, match=f"{turned.replace(',', ', ')} are left out"):
        lt.read_motion(path)
    named = path.read_text().replace(turned, ",".join(f"tip_rot_{i}" for i in turned.split(",")))
    path = write(re.sub(r"x,y,z", "tip_pos_x,tip_pos_y,tip_pos_z", named))
    with pytest.warns(ImplausibleInputWarning, match="are left out"):
        lt.read_motion(path, columns={"positions": ["tip_pos_x", "tip_pos_y", "tip_pos_z"]})


def test_the_position_of_one_body_has_no_orientation_of_another(write):
    rows = "0,1,2,3,1,0,0,0\n1,1,2,4,1,0,0,0\n"
    turned = ",".join(f"camera_quat_{axis}" for axis in "wxyz")
    path = write(f"time,tool_pos_x,tool_pos_y,tool_pos_z,{turned}\n{rows}")
    refused("position is of tool, the orientation of camera", lt.read_motion, path)
    with pytest.warns(ImplausibleInputWarning, match="taken for one pose"):
        lt.read_motion(write(f"time,x,y,z,{turned}\n{rows}"))
    poses = lt.read_motion(write(f"time,x,y,z,ox,oy,oz,ow\n{rows.replace('1,0,0,0', '0,0,0,1')}"))
    assert np.array_equal(poses.orientations[0], [1.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize(
    "due", [{"secs": 1, "nsecs": 500_000_000}, 1.5, {"sec": 1.5, "nanosec": 0}]
)
def test_points_are_timed_as_in_ros_1_or_by_numbers_and_never_truncated(write, due):
    points = [{"positions": [i], "time_from_start": each} for i, each in enumerate((0, due))]
    path = write(json.dumps({"joint_names": ["a"], "points": points}), "motion.json")
    if isinstance(due, dict) and "sec" in due:
        refused("sec: expected an integer", lt.read_motion, path)
    else:
        assert np.array_equal(lt.read_motion(path).times, [0.0, 1.5])


def test_arrays_of_more_numbers_than_a_point_has_are_asked_about(tmp_path):
    np.savez(
        tmp_path / "a.npz", time=np.arange(9.0), position=np.ones((9, 6)), velocity=np.ones((9, 6))
    )
    with pytest.warns(ImplausibleInputWarning, match="6 numbers are read as a point; joints by"):
        lt.read_motion(tmp_path / "a.npz")


@pytest.mark.parametrize("suffix", ["csv", "npz", "json", "yaml"])
def test_joints_whose_names_are_axes_or_end_in_units_come_back_or_are_named(tmp_path, suffix):
    path, times = tmp_path / f"a.{suffix}", np.arange(3) / 10.0
    gantry = lt.JointTrajectory(
        times, np.ones((3, 3)), np.zeros((3, 3)), joint_names=("x", "y", "z")
    )
    if suffix == "csv":
        with pytest.warns(ImplausibleInputWarning, match="not all joints are told"):
            lt.io.write_motion(gantry, path)
    else:
        lt.io.write_motion(gantry, path)
        back = lt.read_motion(path)
        assert back.joint_names == ("x", "y", "z")
        assert back.velocities is not None
    tilted = lt.JointTrajectory(times, np.ones((3, 1)), np.zeros((3, 1)), joint_names=("tilt_deg",))
    with pytest.warns(ImplausibleInputWarning, match="tilt_deg are written in rad"):
        lt.io.write_motion(tilted, path)
