"""The plain damped least squares of Yang, Liu and Pears, "Enhancing Learning from Demonstration
with DLS-IK and ProMPs", equations 3 to 7: a reference for studies of singularities.

One step of joint velocity is

    J^T (J J^T + (lambda^2 + alpha) I)^-1 xdot + (I - J^+ J) qdot_middle,

with J^+ of the undamped Jacobian, so that the second part leaves the tool alone. The paper lets
lambda grow with the condition number kappa of J (4) but gives no rule; ours is

    lambda^2 = damping^2 (1 - (condition_threshold / kappa)^2) where kappa > condition_threshold,

and 0 below: it starts smoothly and ends at `damping` in the singularity.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import Arm, IkBatch
from leadthrough.check import Float64Array, InvalidInput, ShortRepr
from leadthrough.motion import JointTrajectory, PoseTrajectory, Trajectory, with_derivatives

_STATUSES = np.array(("converged", "unreachable", "limits", "budget"))  # by the core's codes


@dataclass(frozen=True)
class DampedLeastSquares:
    """The settings of the method.

    Attributes:
        damping: lambda at the singularity in m per rad, >= 0; 0 is the plain pseudo-inverse (2).
        alpha: of equation 5, added to lambda^2 everywhere, >= 0.
        condition_threshold: condition number kappa above which lambda grows, >= 1. kappa is
            dimensionless only with the rotation rows of J in metres, see `rotation_weight`; with
            0.3 m per rad the Panda's kappa is 4.5 in its ready posture and 11 in the middle of
            random ones. With a weight of 1, where the paper weighs nothing, these are 8.2 and 18,
            and its thresholds of 8 and 10 are low.
        nullspace_gain: rate at which the joints approach the middle of their ranges, 1/s, >= 0.
        rotation_weight: weight of rotations in J, in the task and in the damping, in m per rad,
            > 0. 0.3 m is about an arm's reach from its wrist.
    """

    damping: float = 0.1
    alpha: float = 0.0
    condition_threshold: float = 10.0
    nullspace_gain: float = 0.5
    rotation_weight: float = 0.3

    def __post_init__(self) -> None:
        check.number(self.damping, "damping", at_least=0.0)
        check.number(self.alpha, "alpha", at_least=0.0)
        check.number(self.condition_threshold, "condition_threshold", at_least=1.0)
        check.number(self.nullspace_gain, "nullspace_gain", at_least=0.0)
        check.number(self.rotation_weight, "rotation_weight", above=0.0)

    def compiled(self) -> core.YangOptions:
        """The settings as the core takes them."""
        return core.YangOptions(
            self.damping,
            self.alpha,
            self.condition_threshold,
            self.nullspace_gain,
            self.rotation_weight,
        )


@dataclass(frozen=True, eq=False)
class DampedPath(ShortRepr):
    """Joints along a motion, and what the step that led to each sample was like."""

    joints: JointTrajectory  # the joints, with the motion's times and events
    condition: Float64Array  # condition number kappa (n,) where each step began
    damping: Float64Array  # lambda (n,) in m per rad where each step began
    position_error: Float64Array  # (n,) in m, of the tip after each step
    orientation_error: Float64Array  # (n,) in rad, of the tip after each step


def damped_inverse_kinematics(
    arm: Arm,
    positions: ArrayLike,
    orientations: ArrayLike | None = None,
    *,
    q0: ArrayLike | None = None,
    threads: int = 1,
    settings: DampedLeastSquares | None = None,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
    max_iterations: int = 2000,
) -> IkBatch:
    """The configurations in which damped least-squares steps towards poses end.

    This is a reference for studies of singularities; `Arm.inverse_kinematics` reaches more poses
    and is faster. Each iteration is a step of one second.

    Args:
        positions: (m, 3) in m, base frame.
        orientations: (m, 4) w, x, y, z; None leaves them free.
        q0: configurations (m, joints) where the steps start, or (joints,) for all of them; by
            default the middle of the joints' ranges.
        threads: number of threads, 1 to 256; does not change the answer.
        settings: those of the method; by default `DampedLeastSquares()`.
        position_tolerance: error in m that counts as reached, > 0.
        orientation_tolerance: error in rad that counts as reached, > 0.
        max_iterations: budget of steps for each pose.

    Returns:
        One row per pose.

    Source: Yang, Liu and Pears, equations 3 to 7.
    """
    chain = _chain(arm)
    where = check.array(positions, "positions", shape=("m", 3))
    turned = np.empty((0, 4))
    if orientations is not None:
        turned = check.quaternions(orientations, "orientations", shape=(len(where), 4))
    q, codes, *errors, iterations, limiting = core.solve_yang(
        chain,
        where,
        turned,
        _starts(chain, q0, len(where)),
        core.IkTolerance(
            check.number(position_tolerance, "position_tolerance", above=0.0),
            check.number(orientation_tolerance, "orientation_tolerance", above=0.0),
        ),
        check.integer(max_iterations, "max_iterations", at_least=1, at_most=10**9),
        _checked(settings).compiled(),
        check.integer(threads, "threads", at_least=1, at_most=256),
    )
    return IkBatch(q, codes == 0, _STATUSES[codes], errors[0], errors[1], iterations, limiting)


def follow_path(
    arm: Arm,
    motion: Trajectory | PoseTrajectory,
    *,
    q0: ArrayLike,
    settings: DampedLeastSquares | None = None,
) -> DampedPath:
    """One step per sample along a motion; the error that a step leaves joins the next one's task.

    Source: Yang, Liu and Pears, equations 3 to 7.
    """
    chain = _chain(arm)
    q, *columns = core.yang_path(
        chain,
        *_poses(motion),
        check.array(q0, "q0", shape=(chain.joints,)),
        _steps(motion.times),
        _checked(settings).compiled(),
    )
    joints = JointTrajectory(motion.times, q, joint_names=arm.joint_names, events=motion.events)
    return DampedPath(with_derivatives(joints), *columns)


def _chain(arm: Arm) -> core.Chain:
    """The arm as the core takes it."""
    chain = core.Chain(arm.robot, arm.base, arm.tip)
    return arm.attachment.applied_to(chain.with_bounds(arm.limits.lower, arm.limits.upper))


def _starts(chain: core.Chain, q0: ArrayLike | None, count: int) -> Float64Array:
    """Configurations (count, joints) from as many rows of q0, or from one for all."""
    if q0 is not None and np.ndim(q0) == 2:
        return check.array(q0, "q0", shape=(count, chain.joints))
    one = chain.middle if q0 is None else check.array(q0, "q0", shape=(chain.joints,))
    return np.tile(one, (count, 1))


def _poses(motion: Trajectory | PoseTrajectory) -> tuple[Float64Array, Float64Array]:
    """Positions (n, 3) and orientations (n, 4), or no rows where they are free."""
    if isinstance(motion, PoseTrajectory):
        return motion.positions, motion.orientations
    if not isinstance(motion, Trajectory) or motion.positions.shape[1] != 3:
        raise InvalidInput("motion: expected a PoseTrajectory or a Trajectory in 3-D")
    return motion.positions, np.empty((0, 4))


def _steps(times: Float64Array) -> Float64Array:
    """Intervals (n,) in s that lead to each sample."""
    if len(times) == 1:
        return np.ones(1)
    steps = np.diff(times)
    return np.concatenate([steps[:1], steps])


def _checked(value: DampedLeastSquares | None) -> DampedLeastSquares:
    """The settings, or the defaults."""
    if value is None:
        return DampedLeastSquares()
    if not isinstance(value, DampedLeastSquares):
        raise InvalidInput(f"settings: expected DampedLeastSquares, got {type(value).__name__}")
    return value
