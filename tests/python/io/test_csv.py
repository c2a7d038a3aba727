import numpy as np
import pytest
from hypothesis import given, strategies as st
from refusals import raised, refused

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.sanity import ImplausibleInputWarning

HEADER = "t,x,y,z,qw,qx,qy,qz,joint_1,joint_2,label"
JOINTS = {"joints": ["joint_1", "joint_2"]}


def test_points_are_found_by_their_names(write):
    motion = lt.read_motion(write("t,x,y\n0,1,2\n0.5,3,4\n"))
    assert type(motion) is lt.Trajectory
    assert np.array_equal(motion.times, [0, 0.5])
    assert np.array_equal(motion.positions, [[1, 2], [3, 4]])


@pytest.mark.parametrize(
    "names",
    [
        "Time,px,py,pz,qw,qx,qy,qz",
        "timestamp,pos_x,pos_y,pos_z,orientation_w,orientation_x,orientation_y,orientation_z",
        "stamp,position.x,position.y,position.z,quat_w,quat_x,quat_y,quat_z",
        "t,tool_position_x,tool_position_y,tool_position_z,tool_rot_w,tool_rot_x,tool_rot_y,tool_rot_z",
    ],
)
def test_poses_are_found_by_their_names(write, names):
    motion = lt.read_motion(write(f"{names}\n0,1,2,3,1,0,0,0\n1,4,5,6,0,1,0,0\n"))
    assert type(motion) is lt.PoseTrajectory
    assert np.array_equal(motion.positions, [[1, 2, 3], [4, 5, 6]])
    assert np.array_equal(motion.orientations, [[1, 0, 0, 0], [0, 1, 0, 0]])


def test_quaternions_are_read_as_w_x_y_z_wherever_w_stands(write):
    motion = lt.read_motion(write("t,x,y,z,qx,qy,qz,qw\n0,0,0,0,0.6,0,0,0.8\n"))
    assert np.array_equal(motion.orientations, [[0.8, 0.6, 0, 0]])


@pytest.mark.parametrize(
    "names", ["joint_1,joint_2", "q0,q1", "panda_joint1,panda_joint2", "pan_joint,lift_joint"]
)
def test_joints_are_found_by_their_names_and_keep_them(write, names):
    motion = lt.read_motion(write(f"t,{names}\n0,1,2\n1,3,4\n"))
    assert type(motion) is lt.JointTrajectory
    assert motion.joint_names == tuple(names.split(","))
    assert np.array_equal(motion.positions, [[1, 2], [3, 4]])


@pytest.mark.parametrize(
    "pattern",
    [
        "{q} velocity_{q} effort_{q}",
        "position_{q} velocity_{q}",
        "position.{q} velocity.{q} torque.{q}",
        "{q}_position {q}_velocity {q}_effort",
        "{q}_pos {q}_vel",
        "/joint_states/{q}/position /joint_states/{q}/velocity",
        "/joint_states/position/{q} /joint_states/effort/{q}",
    ],
)
@pytest.mark.parametrize("names", ["panda_joint1 panda_joint2", "pan_joint lift_joint"])
def test_positions_are_told_from_what_else_was_logged_of_the_joints(write, pattern, names):
    header = [part.format(q=q) for part in pattern.split() for q in names.split()]
    numbers = ",".join(map(str, range(1, len(header) + 1)))
    path = write(f"t,{','.join(header)}\n0,{numbers}\n1,{numbers}\n")
    ranges = dict.fromkeys(names.split(), (-np.pi, np.pi))
    (recording,) = lt.io.read_recordings([path], joints=ranges)
    motion = recording.motion()
    assert motion.joint_names == tuple(names.split())
    assert np.array_equal(motion.positions, [[1, 2], [1, 2]])


def test_a_joint_may_be_called_by_what_other_columns_are_of(write):
    names = ("cart_joint", "force_joint", "elbow_joint")
    motion = lt.read_motion(write(f"t,{','.join(names)}\n0,1,2,3\n0.1,1,2,3\n"))
    assert motion.joint_names == names


@pytest.mark.parametrize("pattern", ["field.{}{}", "{}_{}", "/joint_states/{}[{}]"])
def test_numbers_of_joint_states_have_the_names_in_their_cells(write, pattern):
    names, arm = ["elbow", "lift", "pan"], dict.fromkeys(["pan", "lift", "elbow"], (-4.0, 4.0))
    fields = [pattern.format(f, i) for f in ("name", "position", "velocity") for i in range(3)]
    rows = [[k, *names, 3, 2, 1, 6, 5, 4] for k in range(2)]
    table = [["time", *fields], *rows]
    motion = lt.read_motion(write("\n".join(",".join(map(str, r)) for r in table)), joints=arm)
    assert motion.joint_names == ("pan", "lift", "elbow")
    assert np.array_equal(motion.positions[0], [1, 2, 3])
    assert np.array_equal(motion.velocities[0], [4, 5, 6])
    rows[1][1:4] = ["a", "b", "c"]  # another arm's message
    path = write("\n".join(",".join(map(str, r)) for r in table))
    refused("no names of positions or joints found", lt.read_motion, path, joints=arm)


@pytest.mark.parametrize(
    "names", ["elbow,shoulder_lift,wrist_1", "Elbow_Joint,Shoulder Lift,WRIST1", "a.elbow,b,1_j"]
)
def test_columns_are_the_joints_that_their_names_tell_or_in_the_order_of_the_arm(write, names):
    arm = dict.fromkeys(["shoulder_lift_joint", "elbow_joint", "wrist_1_joint"], (-4.0, 4.0))
    path, columns = write(f"t,{names}\n0,1,2,3\n1,1,2,3\n"), {"joints": names.split(",")}
    told = lt.read_motion(path, joints=arm, columns=columns).joint_names
    by_name = ("elbow_joint", "shoulder_lift_joint", "wrist_1_joint")
    assert told == (tuple(arm) if names.endswith("_j") else by_name)


def test_the_table_that_a_ur_records_is_read(write):
    header = "timestamp target_q_0 target_q_1 actual_q_0 actual_q_1 actual_qd_0 actual_qd_1"
    for each in (header, "t cmd_a_joint cmd_b_joint a_joint b_joint effort_a_joint effort_b_joint"):
        motion = lt.read_motion(write(f"{each}\n9.5 1 2 3 4 5 6\n9.6 1 2 3.1 4.1 5 6\n"))
        assert np.array_equal(motion.positions, [[3, 4], [3.1, 4.1]])


def test_joints_are_ordered_by_their_numbers(write):
    names = [f"joint_{i}" for i in (10, 1, 2, 3, 4, 5, 6, 7, 8, 9)]
    motion = lt.read_motion(write(f"t,{','.join(names)}\n0,10,1,2,3,4,5,6,7,8,9\n"))
    assert np.array_equal(motion.positions, [np.arange(1, 11)])


def test_columns_choose_what_is_read(write):
    path = write(f"{HEADER}\n0,1,2,3,1,0,0,0,0.1,0.2,go\n1,4,5,6,1,0,0,0,0.3,0.4,stop\n")
    joints = lt.read_motion(path, columns=JOINTS)
    assert joints.joint_names == ("joint_1", "joint_2")
    assert np.array_equal(joints.times, [0, 1])
    poses = lt.read_motion(path, columns={"orientations": ["qw", "qx", "qy", "qz"]})
    assert np.array_equal(poses.positions, [[1, 2, 3], [4, 5, 6]])
    points = lt.read_motion(path, columns={"time": "joint_1", "positions": ["z", "x"]})
    assert type(points) is lt.Trajectory
    assert np.array_equal(points.positions, [[3, 1], [6, 4]])
    assert np.array_equal(points.times, [0.1, 0.3])


def test_several_positions_need_a_choice(write):
    path = write("t,current_pos_x,current_pos_y,goal_pos_x,goal_pos_y\n0,1,2,3,4\n")
    refused(r"current_pos_x, current_pos_y \| goal_pos_x, goal_pos", lt.read_motion, path)
    chosen = lt.read_motion(path, columns={"positions": ["goal_pos_x", "goal_pos_y"]})
    assert np.array_equal(chosen.positions, [[3, 4]])


def test_a_rate_stands_in_for_time(write):
    text = write("time,x,y\n2024-05-01 12:00:00.0,1,2\n2024-05-01 12:00:00.5,3,4\n")
    assert np.array_equal(lt.read_motion(text, rate=2.0).times, [0, 0.5])
    refused("column 'time': expected a number, got '2024-05-01 12:00:00.0'", lt.read_motion, text)
    path = write("x,y\n1,2\n3,4\n5,6\n")
    assert np.array_equal(lt.read_motion(path, rate=20).times, [0, 0.05, 0.1])
    refused("rate: the file has no time column", lt.read_motion, path)
    with pytest.raises(InvalidInput, match="rate: the file has a time column, 't'"):
        lt.read_motion(write("t,x,y\n0,1,2\n"), rate=20)


def test_choices_that_are_missing_or_impossible_are_refused(write):
    with pytest.raises(InvalidInput, match="no names of positions or joints found"):
        lt.read_motion(write("t,joint_1,joint_3\n0,1,2\n"))
    with pytest.raises(InvalidInput, match=r"positions \(x, y, z\) or joints \(joint_1, joint_2\)"):
        lt.read_motion(write(f"{HEADER}\n0,1,2,3,1,0,0,0,0.1,0.2,go\n"))
    for rate in [0, -1, np.nan, np.inf, "20", True]:
        refused("rate: ", lt.read_motion, write("x,y\n1,2\n"), rate=rate)


def test_a_proposal_takes_no_joint_for_the_time_and_nothing_else_for_a_joint(write):
    s = np.linspace(0.0, 1.0, 20)
    joint = 0.3 + s**2 * (3.0 - 2.0 * s)  # rises as time does, not by even steps
    for header, words in [
        ("clock,a,b", "columns['time']=clock columns['positions']=a,b"),
        ("tick,a,b,seq", "columns['time']=tick columns['positions']=a,b"),
        ("hand_x0,hand_x1", "columns['positions']=hand_x0,hand_x1"),
        ("t,ee_x,ee_y,ee_z", "such as columns['positions']=ee_x,ee_y,ee_z"),
        ("t,dX [m],dY [m],dZ [m],dRoll [rad]", "there are t, dX [m], dY [m], dZ [m], dRoll [rad]"),
        ("x,y,z", "rate=100"),
        *(
            (f"t,{n}0,{n}1,{n}2", f"there are t, {n}0, {n}1, {n}2")
            for n in ("ee_quat_", "O_T_EE_", "v")
        ),
        ("t,vx,vy,vz", "there are t, vx, vy, vz"),
        ("t,v.lin.x,v.lin.y,v.ang.x,v.ang.y", "v.ang.y"),
        *((f"t,{n}_q0,{n}_q1", f"{n}_q1") for n in ("acc", "speed", "jerk", "moment")),
    ]:
        names = header.split(",")
        clock = 0.01 * np.arange(20)
        rows = [clock if name in ("t", "clock", "tick", "y") else joint for name in names]
        text = "\n".join(",".join(map(str, row)) for row in zip(*rows, strict=True))
        assert str(raised(InvalidInput, lt.read_motion, write(f"{header}\n{text}"))).endswith(words)


@pytest.mark.parametrize(
    "names",
    [
        "secs,nsecs",
        "header.stamp.sec,header.stamp.nanosec",
        "time_sec,time_nsec",
        "ZeitSec,ZeitNanoSec",
    ],
)
def test_a_clock_of_seconds_and_nanoseconds_is_one(write, names):
    path = write(f"{names},q1,q2\n1635361626,990000000,1,2\n1635361627,5000000,1,3\n")
    for columns in (None, {"time": names.split(",")}):
        motion = lt.read_motion(path, columns=columns)
        np.testing.assert_allclose(motion.times - 1635361626, [0.99, 1.005], atol=1e-6)
        np.testing.assert_array_equal(motion.positions, [[1, 2], [1, 3]])


@pytest.mark.parametrize(("name", "beyond"), [("usec", 600_000), ("msec", 600)])
def test_other_parts_of_a_second_are_no_nanoseconds(write, name, beyond):
    path = write(f"sec,{name},q1\n10,100,1\n10,{beyond},2\n11,100,3\n")
    words = f"{name}: expected nanoseconds beyond the seconds, got"
    refused(words, lt.read_motion, path, columns={"time": ["sec", name]})


def test_seconds_that_both_columns_of_a_clock_hold_count_once(write):
    path = write("sec,nsec,q1\n1635361626.99,1635361626990000000,1\n")
    assert lt.read_motion(path).times[0] == pytest.approx(1635361626.99, abs=1e-6)


@pytest.mark.parametrize(("mark", "line"), [(", ", ","), (" ", " "), ("\t", "\t")])
def test_the_header_asked_for_above_bare_numbers_makes_them_readable(write, mark, line):
    rows = "\n".join(mark.join(map(str, row)) for row in ([0, 1, 2], [1, 3, 4]))
    words = line.join(("time", "joint_1", "joint_2"))
    refused(
        f"got 3 numbers; put as many names above, such as {words};", lt.read_motion, write(rows)
    )
    assert lt.read_motion(write(f"{words}\n{rows}")).joint_names == ("joint_1", "joint_2")


def test_an_unnamed_quaternion_is_no_position(write):
    rows = "0,1,2,3,0.5,0.5,0.5,0.5\n1,1,2,4,0.5,0.5,0.5,0.5"
    motion = lt.read_motion(write(f"t,px,py,pz,x,y,z,w\n{rows}"))
    assert type(motion) is lt.PoseTrajectory
    refused("no names of positions", lt.read_motion, write("t,w,x,y,z\n0,1,0,0,0\n1,1,0,0,0\n"))
    arm = dict.fromkeys("abcdefg", (-4.0, 4.0))
    error = raised(
        InvalidInput, lt.read_motion, write(f"t,tx,ty,tz,qx,qy,qz,qw\n{rows}"), joints=arm
    )
    assert str(error).endswith("columns['positions']=tx,ty,tz columns['orientations']=qw,qx,qy,qz")


def test_a_clock_that_is_one_column_comes_before_one_that_is_two(write):
    motion = lt.read_motion(write("Time,stamp_secs,stamp_nsecs,q1\n0,7,0,1\n0.5,8,9,1\n"))
    np.testing.assert_array_equal(motion.times, [0.0, 0.5])


def test_four_numbers_of_norm_one_are_proposed_as_orientations(write):
    path = write("t,x,y,z,q1,q2,q3,q4\n0,1,2,3,0.5,0.5,0.5,0.5\n1,1,2,3,0.6,0,0.8,0\n")
    words = "columns['positions']=x,y,z columns['orientations']=q1,q2,q3,q4"
    assert str(raised(InvalidInput, lt.read_motion, path)).endswith(words)


def test_lists_in_cells_are_refused_with_their_cure(write):
    path = write('t,position\n0,"[1.0, 2.0]"\n1,"[1.0, 3.0]"\n')
    refused("got '.1.0, 2.0.'; put each number in a column of its own", lt.read_motion, path)


def test_a_clock_of_text_is_refused_with_the_rate_that_reads_it(write):
    path = write("time,x,y\n2024-01-01 12:30:01.1,1,2\n2024-01-01 12:30:01.2,1,2\n")
    refused("got '2024-.*'; give the rate in Hz for clocks of text, rate=100", lt.read_motion, path)
    assert lt.read_motion(path, rate=10.0).times[1] == 0.1


@pytest.mark.parametrize(
    "text",
    [
        "t;x;y\n0;1;2\n1;3;4\n",
        "t\tx\ty\n0\t1\t2\n1\t3\t4\n",
        "\ufefft,x,y\r\n0,1,2\r\n1,3,4\r\n",
        "# t, x, y\n0, 1, 2\n1, 3, 4",
        "# made by a recorder\n\nt,x,y\n0,1,2\n# paused\n\n1,3,4\n\n",
        '"t","x","y"\n"0",1,2\n1,3.0,4e0\n',
        "%time,x,y,,\n0,1,2,,\n1,3,4,,\n",
        "__time,x,y\n0,1,2\n1,3,4\n",
        "Time (Seconds);X;Y\n0;1;2\n1;3;4\n",
    ],
)
def test_dialects_are_understood(write, text):
    motion = lt.read_motion(write(text))
    assert np.array_equal(motion.times, [0, 1])
    assert np.array_equal(motion.positions, [[1, 2], [3, 4]])


TRACKED = """Format Version,1.23,Take Name,Take 1

,,RigidBody,RigidBody,RigidBody,RigidBody,RigidBody,RigidBody,RigidBody
,,tool,tool,tool,tool,tool,tool,tool
,,Rotation,Rotation,Rotation,Rotation,Position,Position,Position
Frame,Time (Seconds),X,Y,Z,W,X,Y,Z
0,0.0,0,0,0,1,0.1,0.2,0.3
1,0.5,0,0,1,0,0.4,0.5,0.6
"""


def test_headers_of_several_rows_are_joined_and_titles_left_out(write):
    motion = lt.read_motion(write(TRACKED))
    assert np.array_equal(motion.positions, [[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]])
    assert np.array_equal(motion.orientations, [[1, 0, 0, 0], [0, 0, 0, 1]])
    for units, factor in (("s,deg,deg", np.pi / 180.0), ("[s],[rad],[mrad]", 1.0)):
        motion = lt.read_motion(write(f'A "UR5\ntime,joint_1,joint_2\n{units}\n0,1,2\n1,3,4'))
        last = 1e-3 if "m" in units else factor
        np.testing.assert_allclose(motion.positions, np.array([[1, 2], [3, 4]]) * [factor, last])


def test_text_of_windows_with_two_bytes_a_letter_is_read(tmp_path):
    (tmp_path / "wide.csv").write_text("time,x,y\n0,1,2\n1,3,4\n", encoding="utf-16")
    motion = lt.read_motion(tmp_path / "wide.csv")
    assert np.array_equal(motion.positions, [[1, 2], [3, 4]])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "got a file without rows"),
        ("\n\n", "got a file without rows"),
        ("t,x,y\n", "expected rows of samples below the header"),
        ("# t,x,y\n", "expected rows of samples below the header"),
        ("0,1,2\n1,3,4\n", "line 1: expected a header"),
        ("t,x,y\n0,1,2\n1,3\n", "line 3: expected 3 cells, as in the header, got 2"),
        ("t,x,y\n0,1,2,3\n", "line 2: expected 3 cells, as in the header, got 4"),
        ("t,x,y\n0,1,2\n1,nan,4\n", "line 3, column 'x': expected a finite number, got nan"),
        ("t,x,y\n0,1,2\n1,,4\n", "line 3, column 'x': expected a finite number, got nan"),
        ("t,x,y\n0,1,2\n\n1,3,one\n", "line 4, column 'y': expected a number, got 'one'"),
        ("t,x,y\n0,1,2_0\n", "line 2, column 'y': expected a number, got '2_0'"),
        ("t,x,y\n0,1,1e999\n", "line 2, column 'y': expected a finite number, got inf"),
        ("t,x,y\n0,1,2\n0,3,4\n", "samples 0 and 1; `leadthrough clean` leaves"),
        ("t,x,y\n1,1,2\n0,3,4\n", "times: expected strictly increasing"),
        ("t,x,y,x\n0,1,2,3\n", "line 1: expected different column names, got 'x' twice"),
        (
            "t,a,b\n0,1,2\n",
            "no names of positions or joints found; name the columns to read, there are t, a",
        ),
        (f"t,q{'1' * 5000}\n0,1\n", "no names of positions or joints found"),
        ("t,time,x,y\n0,0,1,2\n", "columns: time: several fit, t | time"),
        ('t,x,y\n0,"1,2\n', "line 2: "),
        (b"t,x,y\n0,1,\xff\n", "expected UTF-8 text"),
        ("t,x,y,z,qw,qx,qy,qz\n0,1,2,3,0,0,0,0\n", "orientations: expected unit quaternions"),
    ],
)
def test_what_is_wrong_with_a_file_is_said(write, text, message):
    path = write(text)
    caught = raised(InvalidInput, lt.read_motion, path)
    assert str(caught).startswith(f"{path}: ")
    assert message in str(caught)


@given(st.text(alphabet='txyq0123456789.,;\t\n\r#"-+en_ \0', max_size=60))
def test_any_text_is_read_or_refused(tmp_path_factory, text):
    path = tmp_path_factory.mktemp("any") / "recording.csv"
    path.write_text(text)
    try:
        lt.read_motion(path)
    except InvalidInput as error:
        assert "recording.csv" in str(error)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"velocity": ["x"]}, "columns: expected one of 'time', 'positions'"),
        ({"positions": ["x", "u"]}, r"columns\['positions'\]: no column 'u'; there are t, x"),
        ({"positions": []}, r"columns\['positions'\]: expected at least one name, each only"),
        (
            {"positions": ["x", "x"]},
            r"columns\['positions'\]: expected at least one name, each only",
        ),
        ({"positions": 3}, r"columns\['positions'\]: expected names of columns"),
        ({"positions": [1, 2]}, r"columns\['positions'\]: expected names of columns"),
        ({"time": ["t", "x", "y"]}, r"columns\['time'\]: expected one or two names, got 3"),
        ({"positions": ["x"], "joints": ["y"]}, "expected either poses or joints, got both"),
        ({"positions": ["x", "y", "z"], "orientations": ["qw"]}, "orientations: expected shape"),
        (["x", "y"], "columns: expected a mapping, got list"),
    ],
)
def test_wrong_columns_are_refused(write, columns, message):
    path = write(f"{HEADER}\n0,1,2,3,1,0,0,0,0.1,0.2,go\n")
    refused(message, lt.read_motion, path, columns=columns)


@pytest.mark.parametrize("names", [("pan", "lift"), ("lift", "joint_1"), ("pan_joint", "a")])
def test_what_has_a_velocity_is_a_joint_where_no_name_tells_more(tmp_path, names):
    times = [0.0, 0.1, 0.2]
    joints = np.array([[0.0, 1.0], [0.5, 1.5], [1.0, 2.0]])
    motion = lt.JointTrajectory(times, joints, 0.0 * joints, joint_names=names)
    lt.write_motion(motion, tmp_path / "motion.csv")
    found = lt.read_motion(tmp_path / "motion.csv")
    assert found.joint_names == names
    assert np.array_equal(found.positions, joints)
    assert np.array_equal(found.velocities, 0.0 * joints)


def test_joints_that_would_not_all_be_read_back_are_warned_of(tmp_path):
    motion = lt.JointTrajectory([0.0, 0.1], np.zeros((2, 2)), joint_names=("lift", "joint_1"))
    with pytest.warns(ImplausibleInputWarning, match="motion: not all joints"):
        lt.write_motion(motion, tmp_path / "motion.csv")


def test_patterns_name_columns_without_their_derivatives(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("t,arm_1,arm_1_velocity,arm_2,arm_2_velocity,grip\n0,1,9,2,9,5\n1,3,9,4,9,5\n")
    for pattern in ("arm_*", "arm_?"):
        motion = lt.read_motion(path, columns={"joints": pattern})
        assert motion.joint_names == ("arm_1", "arm_2")
        np.testing.assert_array_equal(motion.positions, [[1.0, 2.0], [3.0, 4.0]])
    with pytest.raises(InvalidInput, match=r"no column 'leg_\*'; there are t, arm_1"):
        lt.read_motion(path, columns={"joints": "leg_*"})


@pytest.mark.parametrize(
    ("header", "columns", "words"),
    [
        ("clock,a,b,c,d", None, "columns['time']=clock columns['joints']=a,b,c,d"),
        ("clock,a,b,c d", None, "columns['time']=clock columns['positions']='a,b,c d'"),
        ("t,x,y,z,q1", None, "such as columns['joints']=q1"),
        *(
            (f"t,{name}0,{name}1", None, f"there are t, {name}0, {name}1")
            for name in ("actual_TCP_pose_", "velocity_joint_", "tau_J", "effort_pan_joint", "dq")
        ),
        ("t,arm_1,arm_2,a,b", {"joints": ["arm1", "arm2"]}, "columns['joints']=arm_1,arm_2"),
    ],
)
def test_errors_about_columns_end_with_the_words_that_choose_them(tmp_path, header, columns, words):
    path = tmp_path / "a.csv"
    count = header.count(",") + 1
    rows = [",".join("01928"[:count]), ",".join("13849"[:count])]
    path.write_text("\n".join([header, *rows]))
    with pytest.raises(InvalidInput) as caught:
        lt.read_motion(path, columns=columns)
    assert str(caught.value).endswith(words)


@pytest.mark.parametrize(
    "text",
    [
        "t;x;y\n0;1,5;2\n0,5;-3e-1;4\n",
        "t\tx\ty\n0\t1,5\t2\n0,5\t-0,3\t4\n",
        "t x y\n0 1.5 2\n0.5 -0.3 4\n",
        "# t  x  y\n 0.00  1.5 2\n 0.50 -0.3 4\n",
        "t [ms]  x (m) y\n0 1.5 2\n500 -0,3 4\n",
    ],
)
def test_spaces_split_cells_and_commas_that_split_none_are_decimal(write, text):
    motion = lt.read_motion(write(text))
    np.testing.assert_allclose(motion.times, [0.0, 0.5])
    np.testing.assert_allclose(motion.positions, [[1.5, 2.0], [-0.3, 4.0]])


@pytest.mark.parametrize("unit", [1.0, 1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("begin", [1_000_000_001, 1_795_000_000, 9_999_999_000])
def test_times_since_1970_are_read_in_the_unit_of_their_digits(write, unit, begin):
    stamps = [round(begin / unit) + round(k / unit) for k in range(3)]
    rows = "\n".join(f"{stamp},{k},0" for k, stamp in enumerate(stamps))
    motion = lt.read_motion(write(f"timestamp,x,y\n{rows}\n"))
    np.testing.assert_allclose(np.diff(motion.times), 1.0, rtol=1e-5)
    assert motion.times[0] == pytest.approx(begin)


@pytest.mark.parametrize(
    ("header", "columns"),
    [
        ("t,turn,lift,turn_velocity,lift_velocity", None),
        ("t,turn_deg,lift,turn_velocity,lift_velocity", None),
        ("t,turn,lift_mm,turn_velocity,lift_velocity", None),
        ("t,a,b,c,d", {"joints": ["a", "b"]}),
    ],
)
def test_prismatic_joints_stay_in_metres_where_the_others_are_degrees(write, header, columns):
    lift = 200.0 if "mm" in header else 0.2
    path = write(f"{header}\n0,90,{lift},180,0.5\n1,180,{lift},180,0.5\n")
    joints = {"turn": (-4.0, 4.0), "lift": (0.0, 0.3, "m")}
    motion = lt.read_motion(path, angles="degrees", columns=columns, joints=joints)
    assert motion.joint_names == ("turn", "lift")
    np.testing.assert_allclose(motion.positions, [[np.pi / 2, 0.2], [np.pi, 0.2]])
    if motion.velocities is not None:
        np.testing.assert_allclose(motion.velocities[0], [np.pi, 0.5])


def test_percent_of_a_joint_without_limits_are_refused(write):
    path, joints = write("t,turn\n0,9\n1,18\n"), {"turn": (-np.inf, np.inf)}
    refused("angles: .* turn has no limits", lt.read_motion, path, angles="percent", joints=joints)


@pytest.mark.parametrize(
    "angles",
    [
        *("rx,ry,rz", "Roll [deg],Pitch [deg],Yaw [deg]", "rot_x,rot_y", "A,B,C"),
        *("W (deg),P (deg),R", "i,j,k", "tool_qx,tool_qy", "r11,r12", "quat_a,quat_b", "ori.0"),
    ],
)
def test_orientations_that_are_no_quaternions_are_not_left_out_silently(write, angles):
    path = write(f"t,x,y,z,{angles}\n" + "0,1,2,3" + ",0" * len(angles.split(",")))
    with pytest.warns(ImplausibleInputWarning, match="are left out; orientations are read as qua"):
        lt.read_motion(path)
    lt.read_motion(path, columns={"positions": ["x", "y", "z"]})
