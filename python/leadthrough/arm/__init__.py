"""The arm: from a URDF to kinematics, inverse kinematics and joint trajectories along a path."""

from leadthrough.arm.arm import Arm
from leadthrough.arm.collision import Clearance, ClosestPair, CollisionPairs, CollisionReport
from leadthrough.arm.damped_least_squares import DampedLeastSquares
from leadthrough.arm.differential_ik import DifferentialIk, JointState
from leadthrough.arm.following import FollowOptions
from leadthrough.arm.inverse_kinematics import IkBatch, IkOptions, IkResult
from leadthrough.arm.limits import JointLimits, read_limits
from leadthrough.arm.model import ArmModel, check_arm
from leadthrough.arm.path_report import PathReport
from leadthrough.arm.task_stack import StackRun, StackSolution, TaskReport, TaskStack, resolve
from leadthrough.arm.tasks import (
    ArmTask,
    DirectionTask,
    ElbowTask,
    JointLimitTask,
    ObstacleTask,
    PoseTask,
    PositionTask,
    PostureTask,
)

__all__ = [
    "Arm",
    "ArmModel",
    "ArmTask",
    "Clearance",
    "ClosestPair",
    "CollisionPairs",
    "CollisionReport",
    "DampedLeastSquares",
    "DifferentialIk",
    "DirectionTask",
    "ElbowTask",
    "FollowOptions",
    "IkBatch",
    "IkOptions",
    "IkResult",
    "JointLimitTask",
    "JointLimits",
    "JointState",
    "ObstacleTask",
    "PathReport",
    "PoseTask",
    "PositionTask",
    "PostureTask",
    "StackRun",
    "StackSolution",
    "TaskReport",
    "TaskStack",
    "check_arm",
    "read_limits",
    "resolve",
]
