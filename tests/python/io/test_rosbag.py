import numpy as np
import pytest
from motions import two_pandas
from refusals import refused
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.io import rosbag

TYPES = get_typestore(Stores.ROS2_HUMBLE)
TYPES_OF_ROS_1 = get_typestore(Stores.ROS1_NOETIC)
STAMPS = [1_700_000_000_000_000_000 + 10_000_000 * i for i in range(5)]
TURNED = lt.rotations.exp([[0.1 * i, 0.2, -0.3] for i in range(5)])


def header(time, frame="base", types=TYPES):
    stamp = types.types["builtin_interfaces/msg/Time"](time // 10**9, time % 10**9)
    extra = {"seq": 0} if types is TYPES_OF_ROS_1 else {}
    return types.types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame, **extra)


def joint_state(time, positions, velocities=(), types=TYPES):
    return types.types["sensor_msgs/msg/JointState"](
        header=header(time, types=types),
        name=list(positions),
        position=np.array(list(positions.values()), float),
        velocity=np.array(velocities, float),
        effort=np.zeros(0),
    )


def pose(time, i, frame="base"):
    w, x, y, z = TURNED[i]
    return TYPES.types["geometry_msgs/msg/PoseStamped"](
        header=header(time, frame),
        pose=TYPES.types["geometry_msgs/msg/Pose"](
            position=TYPES.types["geometry_msgs/msg/Point"](x=float(i), y=2.0, z=3.0),
            orientation=TYPES.types["geometry_msgs/msg/Quaternion"](x=x, y=y, z=z, w=w),
        ),
    )


def transforms(time, i):
    def edge(parent, child, shift):
        w, x, y, z = TURNED[i]
        return TYPES.types["geometry_msgs/msg/TransformStamped"](
            header=header(time, parent),
            child_frame_id=child,
            transform=TYPES.types["geometry_msgs/msg/Transform"](
                translation=TYPES.types["geometry_msgs/msg/Vector3"](x=shift + i, y=0.0, z=0.0),
                rotation=TYPES.types["geometry_msgs/msg/Quaternion"](x=x, y=y, z=z, w=w),
            ),
        )

    return TYPES.types["tf2_msgs/msg/TFMessage"](
        transforms=[edge("base", "tool", 0.0), edge("map", "base", 9.0)]
    )


@pytest.fixture(params=[StoragePlugin.SQLITE3, StoragePlugin.MCAP])
def record(request, tmp_path):
    """Writes a bag of {topic: messages}, each message at a second of the bag's own clock."""

    def to_bag(topics):
        path = tmp_path / "bag"
        with Writer(path, version=9, storage_plugin=request.param) as writer:
            for topic, messages in topics.items():
                kind = messages[0].__msgtype__
                connection = writer.add_connection(topic, kind, typestore=TYPES)
                for i, message in enumerate(messages):
                    data = TYPES.serialize_cdr(message, kind)
                    writer.write(connection, 10**9 * (i + 1), data)
        return path

    return to_bag


def arm_states():
    return [joint_state(t, {"b": i, "a": -i}, (1.0, 2.0)) for i, t in enumerate(STAMPS)]


def test_joint_states_are_read_by_their_names_and_stamps(record):
    motion = lt.read_motion(record({"/joint_states": arm_states()}))
    assert motion.joint_names == ("b", "a")
    assert np.array_equal(motion.times, [0.0, 0.01, 0.02, 0.03, 0.04])
    assert np.array_equal(motion.positions, [[i, -i] for i in range(5)])
    assert np.array_equal(motion.velocities, [[1.0, 2.0]] * 5)


def test_joints_may_change_their_order_between_messages(record):
    states = [
        joint_state(t, {"a": -i, "b": i} if i % 2 else {"b": i, "a": -i})
        for i, t in enumerate(STAMPS)
    ]
    motion = lt.read_motion(record({"/joint_states": states}))
    assert motion.joint_names == ("b", "a")
    assert np.array_equal(motion.positions, [[i, -i] for i in range(5)])


def test_of_a_gripper_and_an_arm_on_one_topic_the_one_asked_for_is_read(record):
    states = arm_states() + [joint_state(t + 1, {"finger": 0.04}) for t in STAMPS]
    path = record({"/joint_states": states})
    refused(r"different joints, b, a \| finger", lt.read_motion, path)
    motion = lt.read_motion(path, columns={"joints": ["a", "b"]})
    assert motion.joint_names == ("a", "b")
    assert len(motion.times) == 5
    refused("no joint 'c'; there are b, a, finger", lt.read_motion, path, columns={"joints": ["c"]})


def test_joints_that_come_one_a_message_are_brought_together(record):
    states = []
    for i, t in enumerate(STAMPS):
        states += [joint_state(t, {"a": i}), joint_state(t + 5_000_000, {"b": 10 * i})]
    motion = lt.read_motion(record({"/joint_states": states}), columns={"joints": ["a", "b"]})
    np.testing.assert_allclose(motion.times, [0.01, 0.02, 0.03, 0.04])
    np.testing.assert_allclose(motion.positions, [[i, 10 * i - 5] for i in range(1, 5)])


def test_poses_are_turned_from_x_y_z_w(record):
    motion = lt.read_motion(record({"/tool": [pose(t, i) for i, t in enumerate(STAMPS)]}))
    np.testing.assert_allclose(motion.orientations, TURNED, atol=1e-12)
    assert np.array_equal(motion.positions, [[i, 2, 3] for i in range(5)])


def test_poses_in_two_frames_are_no_motion(record):
    path = record({"/tool": [pose(t, i, f"frame{i % 2}") for i, t in enumerate(STAMPS)]})
    refused("one frame, got frame0, frame1", lt.read_motion, path)


def test_transforms_are_chosen_by_their_frames(record):
    path = record({"/tf": [transforms(t, i) for i, t in enumerate(STAMPS)]})
    motion = lt.read_motion(path, frames=("base", "tool"))
    np.testing.assert_allclose(motion.orientations, TURNED, atol=1e-12)
    assert np.array_equal(motion.positions[:, 0], range(5))
    with pytest.raises(InvalidInput, match=r"one of \('base', 'tool'\), \('map', 'base'\)"):
        lt.read_motion(path, frames=("base", "nothing"))
    refused(r"no topic fits; .*: /tf \(TFMessage, needs frames\)", lt.read_motion, path)


def test_of_several_topics_one_has_to_be_named(record):
    poses = [pose(t, i) for i, t in enumerate(STAMPS)]
    path = record({"/joint_states": arm_states(), "/tool": poses})
    refused(r"/joint_states \(JointState\), /tool \(PoseStamped\)", lt.read_motion, path)
    assert type(lt.read_motion(path, topic="/tool")) is lt.PoseTrajectory
    assert type(lt.read_motion(path, columns={"joints": ["a"]})) is lt.JointTrajectory
    with pytest.raises(InvalidInput, match="no /nothing; topics with motions: /joint_states"):
        lt.read_motion(path, topic="/nothing")


def test_without_stamps_the_bag_tells_the_time(record):
    motion = lt.read_motion(record({"/joint_states": [joint_state(0, {"a": i}) for i in range(3)]}))
    assert np.array_equal(motion.times, [0, 1, 2])


def test_bags_of_ros_1_are_read(tmp_path):
    with Writer1(tmp_path / "old.bag") as writer:
        kind = "sensor_msgs/msg/JointState"
        connection = writer.add_connection("/joint_states", kind, typestore=TYPES_OF_ROS_1)
        for i, time in enumerate(STAMPS):
            state = joint_state(time, {"a": i}, types=TYPES_OF_ROS_1)
            data = TYPES_OF_ROS_1.serialize_ros1(state, kind)
            writer.write(connection, time, data)
    motion = lt.read_motion(tmp_path / "old.bag")
    assert np.array_equal(motion.positions[:, 0], range(5))


@pytest.mark.parametrize("name", ["motion", "motion.mcap", "motion.db3"])
def test_what_is_written_is_read_back(tmp_path, ur_motion, poses, name):
    path = tmp_path / name
    rosbag.write_joint_states(ur_motion, path)
    back = lt.read_motion(path)
    assert np.array_equal(back.times, np.round(ur_motion.times, 9))
    assert np.array_equal(back.positions, ur_motion.positions)
    assert np.array_equal(back.velocities, ur_motion.velocities)
    assert back.joint_names == ur_motion.joint_names
    assert back.events == ur_motion.events
    rosbag.write_poses(poses, tmp_path / f"poses_{name}", topic="/tool", frame="map")
    back = lt.read_motion(tmp_path / f"poses_{name}", topic="/tool")
    assert np.array_equal(back.times, np.round(poses.times, 9))
    np.testing.assert_allclose(back.orientations, poses.orientations, atol=1e-15)
    assert np.array_equal(back.positions, poses.positions)
    assert len(list(tmp_path.iterdir())) == 2


def test_events_of_a_bag_are_no_motion(tmp_path, ur_motion):
    lt.write_motion(ur_motion, tmp_path / "arm.mcap")
    back = lt.read_motion(tmp_path / "arm.mcap")
    np.testing.assert_allclose([event.time for event in back.events], [0.26, 0.91])
    with pytest.raises(InvalidInput, match="/events has no motion; topics with motions: /joint_tr"):
        lt.read_motion(tmp_path / "arm.mcap", topic="/events")


def test_a_bag_is_whole_or_not_there(tmp_path, ur_motion, poses):
    standing = tmp_path / "bag"
    standing.mkdir()
    (standing / "precious").touch()
    refused("cannot be written", rosbag.write_joint_states, ur_motion, standing)
    refused(r"got .bag, which is ROS 1", rosbag.write_poses, poses, tmp_path / "old.bag")
    with pytest.raises(InvalidInput, match="expected joints or poses"):
        lt.write_motion(lt.Trajectory([0, 1], [[0, 0], [1, 1]]), tmp_path / "points.mcap")
    refused("no such folder", rosbag.write_poses, poses, tmp_path / "missing" / "bag")
    assert list(tmp_path.iterdir()) == [standing]
    assert [path.name for path in standing.iterdir()] == ["precious"]


def test_joint_states_of_two_arms_are_a_demonstration_of_both(record):
    """In the order of one driver: by name, as they come."""
    pair = two_pandas()
    names = sorted(pair.joint_names, reverse=True)
    rows = [{name: -0.01 * i - 0.05 * k for k, name in enumerate(names)} for i in range(5)]
    bag = record({"/joint_states": [joint_state(t, q) for t, q in zip(STAMPS, rows, strict=True)]})
    shown = pair.demonstration(lt.read_demonstrations(bag)[0])
    wanted = [[row[name] for name in pair.joint_names] for row in rows]
    np.testing.assert_allclose(shown.joints.positions, wanted)
