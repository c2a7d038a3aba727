"""The arm: from a URDF to kinematics, inverse kinematics and joint trajectories along a path."""

from leadthrough.arm.arm import Arm as Arm, check_arm as check_arm
from leadthrough.arm.collision import (
    Clearance as Clearance,
    ClosestPair as ClosestPair,
    CollisionPairs as CollisionPairs,
    CollisionReport as CollisionReport,
)
from leadthrough.arm.differential_ik import (
    DifferentialIk as DifferentialIk,
    JointState as JointState,
)
from leadthrough.arm.dual_arm import (
    DualArm as DualArm,
    HeldObject as HeldObject,
    check_arms as check_arms,
)
from leadthrough.arm.dual_coordination import (
    CoordinatedMotion as CoordinatedMotion,
    Wait as Wait,
    coordinate as coordinate,
)
from leadthrough.arm.dual_demonstration import (
    BaseLocation as BaseLocation,
    DualDemonstration as DualDemonstration,
    left_tip as left_tip,
    right_tip as right_tip,
    tips_of as tips_of,
)
from leadthrough.arm.following import FollowOptions as FollowOptions
from leadthrough.arm.inverse_kinematics import (
    Axis as Axis,
    IkBatch as IkBatch,
    IkOptions as IkOptions,
    IkResult as IkResult,
    IkSolutions as IkSolutions,
)
from leadthrough.arm.limits import JointLimits as JointLimits, read_limits as read_limits
from leadthrough.arm.model import GRAVITY as GRAVITY, ArmModel as ArmModel
from leadthrough.arm.path_report import PathReport as PathReport
from leadthrough.arm.task_stack import (
    StackRun as StackRun,
    StackSolution as StackSolution,
    TaskReport as TaskReport,
    TaskStack as TaskStack,
    resolve as resolve,
)
from leadthrough.arm.tasks import (
    ArmTask as ArmTask,
    DirectionTask as DirectionTask,
    ElbowTask as ElbowTask,
    JointLimitTask as JointLimitTask,
    ObstacleTask as ObstacleTask,
    PoseTask as PoseTask,
    PositionTask as PositionTask,
    PostureTask as PostureTask,
)
