"""The arm: from a URDF to kinematics, inverse kinematics and joint trajectories along a path."""

from leadthrough.arm.arm import Arm
from leadthrough.arm.collision_report import Approach, Clearance, CollisionPairs, CollisionReport
from leadthrough.arm.differential import DifferentialIk, JointState
from leadthrough.arm.keeping_tasks import JointLimitTask, ObstacleTask
from leadthrough.arm.limits import JointLimits, read_limits
from leadthrough.arm.path_report import PathReport
from leadthrough.arm.priorities import resolve
from leadthrough.arm.results import IkBatch, IkResult
from leadthrough.arm.stack_report import StackRun, StackSolution, TaskReport
from leadthrough.arm.task import ArmTask
from leadthrough.arm.task_stack import TaskStack
from leadthrough.arm.tasks import (
    DirectionTask,
    ElbowTask,
    PoseTask,
    PositionTask,
    PostureTask,
)
from leadthrough.arm.yang import DampedLeastSquares

__all__ = [
    "Approach",
    "Arm",
    "ArmTask",
    "Clearance",
    "CollisionPairs",
    "CollisionReport",
    "DampedLeastSquares",
    "DifferentialIk",
    "DirectionTask",
    "ElbowTask",
    "IkBatch",
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
    "read_limits",
    "resolve",
]
