from . import formats, franka, headers, joint_trajectory, lasa, rosbag_writer, urscript
from .mesh import read_mesh
from .points import read_point_cloud
from .reading import read_demonstrations, read_motion, read_recordings
from .recording import Recording
from .streaming import Episode, stream_recordings
from .writing import write_motion

__all__ = [
    "Episode",
    "Recording",
    "formats",
    "franka",
    "headers",
    "joint_trajectory",
    "lasa",
    "read_demonstrations",
    "read_mesh",
    "read_motion",
    "read_point_cloud",
    "read_recordings",
    "rosbag_writer",
    "stream_recordings",
    "urscript",
    "write_motion",
]
