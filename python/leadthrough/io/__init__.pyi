from . import (
    formats as formats,
    headers as headers,
    joint_trajectory as joint_trajectory,
    lasa as lasa,
    robot_programs as robot_programs,
    rosbag as rosbag,
)
from .formats import write_motion as write_motion
from .mesh import read_mesh as read_mesh
from .points import read_point_cloud as read_point_cloud
from .reading import (
    Episode as Episode,
    read_demonstrations as read_demonstrations,
    read_motion as read_motion,
    read_recordings as read_recordings,
    stream_recordings as stream_recordings,
)
from .recording import Recording as Recording
