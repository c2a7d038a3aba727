"""The arm: from a URDF to kinematics, inverse kinematics and joint trajectories along a path."""

from leadthrough.arm.arm import Arm
from leadthrough.arm.limits import JointLimits, read_limits
from leadthrough.arm.results import IkBatch, IkResult

__all__ = ["Arm", "IkBatch", "IkResult", "JointLimits", "read_limits"]
