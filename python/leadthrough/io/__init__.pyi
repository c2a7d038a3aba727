from . import formats, headers, joint_trajectory, lasa, robot_programs, rosbag
from .formats import write_motion
from .mesh import read_mesh
from .points import read_point_cloud
from .reading import Episode, read_demonstrations, read_motion, read_recordings, stream_recordings
from .recording import Recording

__all__ = [
    "Episode",
    "Recording",
    "formats",
    "headers",
    "joint_trajectory",
    "lasa",
    "read_demonstrations",
    "read_mesh",
    "read_motion",
    "read_point_cloud",
    "read_recordings",
    "robot_programs",
    "rosbag",
    "stream_recordings",
    "write_motion",
]
