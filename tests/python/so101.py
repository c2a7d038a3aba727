"""An arm of five joints and a gripper, and a data set of it as LeRobot 3 writes them.

The arm has the kinematics of the SO-101, whose data sets name its motors so; lengths are rounded to
a millimetre.
"""

import json

import numpy as np
import pyarrow as pa
from motions import minimum_jerk
from pyarrow import parquet

LINKS = """<robot name="five_joints_and_a_gripper">
<link name="base_link"/><link name="shoulder_link"/><link name="wrist_link"/>
<link name="upper_arm_link"><collision><origin xyz="-0.06 -0.02 0"/><geometry>
 <sphere radius="0.03"/></geometry></collision></link>
<link name="lower_arm_link"><collision><origin xyz="-0.07 0 0"/><geometry>
 <sphere radius="0.03"/></geometry></collision></link>
<link name="gripper_link"><collision><origin xyz="0 0 -0.06"/><geometry>
 <sphere radius="0.03"/></geometry></collision></link>
<link name="gripper_frame_link"/><link name="jaw_link"/>
<joint name="gripper_frame_joint" type="fixed">
 <parent link="gripper_link"/><child link="gripper_frame_link"/>
 <origin xyz="-0.008 0 -0.098" rpy="0 3.14159265 0"/></joint>"""
# Name, parent, child, origin, rotation and limits of each joint that moves.
CHAIN = """
shoulder_pan; base; shoulder; 0.039 0 0.062; 3.14159265 0 -3.14159265; -1.91986; 1.91986
shoulder_lift; shoulder; upper_arm; -.030 -.018 -.054; -1.57079633 -1.57079633 0; -1.74533; 1.74533
elbow_flex; upper_arm; lower_arm; -0.113 -0.028 0; 0 0 1.57079633; -1.69; 1.69
wrist_flex; lower_arm; wrist; -0.135 0.005 0; 0 0 -1.57079633; -1.65806; 1.65806
wrist_roll; wrist; gripper; 0 -0.061 0.018; 1.57079633 0.0486795 3.14159265; -2.74385; 2.84121
gripper; gripper; jaw; 0.020 0.019 -0.023; 1.57079633 0 0; -0.174533; 1.74533
"""
MOVING = """<joint name="{}" type="revolute"><parent link="{}_link"/><child link="{}_link"/>
<origin xyz="{}" rpy="{}"/><axis xyz="0 0 1"/>
<limit effort="10" velocity="10" lower="{}" upper="{}"/></joint>"""
_JOINTS = "".join(MOVING.format(*row.split("; ")) for row in CHAIN.split("\n")[1:-1])
URDF = LINKS + _JOINTS + "</robot>"
TIP = "gripper_frame_link"
JOINTS = ("shoulder_pan", "shoulder_lift", "elbow_flex", "wrist_flex", "wrist_roll")
MOTORS = [f"{name}.pos" for name in (*JOINTS, "gripper")]
FPS = 30
FIRST = np.array([-0.5, -0.3, 0.4, 0.7, 0.3])
WAY = np.array([0.9, 0.5, -0.5, 0.3, -0.5])


def motions(count=3, samples=90):
    """Episodes of the arm's joints (n, 5), rad, a little different each, and its opening (n,)."""
    rng = np.random.default_rng(0)
    u = np.linspace(0.0, 1.0, samples)
    rise = minimum_jerk(u)
    for _ in range(count):
        q = FIRST + rng.normal(0.0, 0.01, 5) + np.outer(rise, WAY)
        yield q + rng.normal(0.0, 5e-4, q.shape), np.where(u < 0.7, 80.0, 5.0)


def percent(q, limits):
    """Joints (n, 5) from -100 at the lower limit to 100 at the upper one."""
    return 200.0 * (q - limits.lower) / (limits.upper - limits.lower) - 100.0


def save(folder, episodes):
    """Writes episodes of numbers (n, 6) in the layout of LeRobot 3: many episodes in one file.

    Args:
        folder: of the data set.
        episodes: the arm's five numbers and the gripper's.
    """
    lengths = [len(each) for each in episodes]
    state = np.concatenate(episodes).astype(np.float32)
    index = np.concatenate([np.arange(n) for n in lengths])
    columns = {
        "action": pa.array(state.tolist(), pa.list_(pa.float32(), 6)),
        "observation.state": pa.array(state.tolist(), pa.list_(pa.float32(), 6)),
        "timestamp": pa.array(index / FPS, pa.float32()),
        "frame_index": index,
        "episode_index": np.repeat(np.arange(len(lengths)), lengths),
        "index": np.arange(len(state)),
        "task_index": np.zeros(len(state), int),
    }
    file = folder / "data" / "chunk-000" / "file-000.parquet"
    for path in (file, folder / "meta" / "episodes" / "chunk-000" / "file-000.parquet"):
        path.parent.mkdir(parents=True)
    parquet.write_table(pa.table(columns), file)
    about = {"episode_index": np.arange(len(lengths)), "length": lengths}
    parquet.write_table(pa.table(about), folder / "meta/episodes/chunk-000/file-000.parquet")
    feature = {"dtype": "float32", "shape": [6], "names": MOTORS}
    info = {
        "codebase_version": "v3.0",
        "robot_type": "so101_follower",
        "total_episodes": len(lengths),
        "total_frames": len(state),
        "fps": FPS,
        "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "features": {"action": feature, "observation.state": feature},
    }
    (folder / "meta" / "info.json").write_text(json.dumps(info))
    found = {"min": state.min(axis=0).tolist(), "max": state.max(axis=0).tolist()}
    (folder / "meta" / "stats.json").write_text(json.dumps({"observation.state": found}))
