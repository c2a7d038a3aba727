"""Demonstrations of two arms: the object that both hold, their relative motion, the other base.

A movement primitive of both tips is learned over their middle and their difference: columns of the
two tips that move alike are correlated, and the covariance of few demonstrations is shrunk towards
columns that are not.

With the tips' poses L_i and R_i in their arms' base frames, the right base B and the grasp G
between the tips satisfy L_i G = B R_i. The errors of all samples are weighted by the covariance
that equal noise of all joints gives them (Strobl and Hirzinger 2006, "Optimal hand-eye
calibration"), and their sum of squares is minimised by Gauss and Newton's method.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from leadthrough import check, rotations
from leadthrough.arm.arm import Arm
from leadthrough.arm.rigid_transforms import Pose, Transforms, checked_grasps
from leadthrough.check import FitError, Float64Array, ShortRepr
from leadthrough.motion import Demonstration, JointTrajectory, PoseTrajectory, Trajectory

_HALF = 0.5 * np.eye(3)
_LEFT, _RIGHT = np.hstack([np.eye(3), -_HALF]), np.hstack([np.eye(3), _HALF])


@dataclass(frozen=True, eq=False)
class DualDemonstration(ShortRepr):
    """Motions of the left and the right tip on one clock, in one frame.

    Attributes:
        left: poses of the left tip.
        right: poses of the right tip. Of a motion with other times those of the left one that both
            cover count, and the right one is interpolated.
        joints: of both arms at the same times, or None.
        name: for messages and files.
    """

    left: PoseTrajectory
    right: PoseTrajectory
    joints: JointTrajectory | None = None
    name: str = ""

    def __post_init__(self) -> None:
        for side in ("left", "right"):
            check.instance(getattr(self, side), side, PoseTrajectory)
        left, right = self.left, self.right
        if not np.array_equal(left.times, right.times):
            covered = (left.times >= right.times[0]) & (left.times <= right.times[-1])
            if not covered.any():
                raise check.refused("right", "times that the left motion covers", repr(right))
            first, count = int(np.argmax(covered)), int(np.count_nonzero(covered))
            left = left[first : first + count]
            right = PoseTrajectory(left.times, *right.at(left.times), right.events)
            object.__setattr__(self, "left", left)
            object.__setattr__(self, "right", right)
        if self.joints is not None and not np.array_equal(self.joints.times, left.times):
            raise check.refused("joints", "the times of the tips", repr(self.joints))

    def object(self, grasps: tuple[Pose, Pose]) -> Demonstration[PoseTrajectory]:
        """The motion of an object that both hold, with the arms' joints.

        It is in the middle between the poses that either tip has it at.

        Args:
            grasps: poses of the left and of the right tip in the object's frame.
        """
        held = checked_grasps(grasps, Transforms.of)
        by_left, by_right = (
            Transforms(motion.positions, motion.orientations) @ grasp.inverse()
            for motion, grasp in zip((self.left, self.right), held, strict=True)
        )
        half = 0.5 * rotations.log((by_left.inverse() @ by_right).orientations)
        motion = PoseTrajectory(
            self.left.times,
            0.5 * (by_left.positions + by_right.positions),
            rotations.compose(by_left.orientations, rotations.exp(half)),
            self.left.events,
        )
        return Demonstration(motion, self.name, self.joints)

    @property
    def grasps(self) -> tuple[Pose, Pose]:
        """Grasps of an object whose frame is that of the left tip, for `object` and `follow`."""
        relative = self.relative
        mean = relative.positions.mean(axis=0), rotations.mean(relative.orientations)
        return Transforms.identity().single(), mean

    @property
    def relative(self) -> PoseTrajectory:
        """Poses of the right tip in the frame of the left one."""
        left, right = self.left, self.right
        to_left = Transforms(left.positions, left.orientations).inverse()
        found = to_left @ Transforms(right.positions, right.orientations)
        return PoseTrajectory(left.times, found.positions, found.orientations)

    @property
    def middle_and_difference(self) -> Trajectory:
        """Positions (n, 6) in m: the middle of both tips, then the right less the left one.

        A ProMP of these keeps what the arms do alike. `left_tip` and `right_tip` are the tasks for
        `condition_task`, and `tips_of` takes a motion apart.
        """
        left, right = self.left.positions, self.right.positions
        return Trajectory(self.left.times, np.hstack([0.5 * (left + right), right - left]))


def left_tip(both: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Position (3,) of the left tip in the columns (6,) of `middle_and_difference`; Jacobian."""
    return _LEFT @ both, _LEFT


def right_tip(both: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Position (3,) of the right tip in the columns (6,) of `middle_and_difference`; Jacobian."""
    return _RIGHT @ both, _RIGHT


def tips_of(motion: Trajectory) -> tuple[Trajectory, Trajectory]:
    """Motions of the left and the right tip, of one of `middle_and_difference`."""
    if not isinstance(motion, Trajectory) or motion.positions.shape[1] != _LEFT.shape[1]:
        raise check.refused("motion", "a Trajectory in 6-D", repr(motion))
    left, right = (
        Trajectory(motion.times, motion.positions @ matrix.T, motion.events)
        for matrix in (_LEFT, _RIGHT)
    )
    return left, right


_MAX_STEPS = 50
_CONVERGED = 1e-10  # m and rad, of a step
# No encoder and no hand is better, rad.
_MIN_NOISE = 1e-4
# Standard deviations, m and rad, beyond which a base counts as not known.
MAX_DEVIATIONS = (1e-3, np.radians(0.1))
# Noise of the samples looks like tilts of the object. More samples than these are averaged in
# blocks, so that it does not sum up to a base that the motion leaves open.
_MAX_SAMPLES = 200


@dataclass(frozen=True, eq=False)
class BaseLocation(ShortRepr):
    """The pose of the right base in the left base frame.

    Attributes:
        base: position (3,) in m and orientation (4,) w, x, y, z.
        covariance: (6, 6) of the position in m and of a rotation vector in rad, both along the
            axes of the left base. It counts the noise of samples, which differs from one to the
            next, and no error of the arms' models.
        noise: standard deviation of the joints that explains the residuals, rad, at least 1e-4.
    """

    base: tuple[Float64Array, Float64Array]
    covariance: Float64Array
    noise: float


@dataclass(frozen=True, eq=False)
class Carried:
    """Samples of one demonstration, with the Jacobians of either tip in its arm's base frame."""

    tips: tuple[Transforms, Transforms]
    jacobians: tuple[Float64Array, Float64Array]  # (n, 6, joints)
    averaged: int  # recorded samples in each of these

    @staticmethod
    def of(arms: tuple[Arm, Arm], q: tuple[Float64Array, Float64Array]) -> Carried:
        """The samples with these joints of the left and the right arm, (n, joints) each."""
        averaged = max(len(q[0]) // _MAX_SAMPLES, 1)
        left, right = (
            (Transforms(*arm.forward_kinematics(rows)), arm.jacobian(rows))
            for arm, rows in zip(arms, (_averaged(each, averaged) for each in q), strict=True)
        )
        return Carried((left[0], right[0]), (left[1], right[1]), averaged)

    def residuals(self, base: Transforms, grasp: Transforms) -> tuple[Float64Array, Float64Array]:
        """Errors (n, 6) of the right tip; slopes (n, 6, 12) by shifts and turns of both poses."""
        by_left, by_right = self.tips[0] @ grasp, base @ self.tips[1]
        turns = rotations.compose(by_right.orientations, rotations.inverse(by_left.orientations))
        errors = np.hstack([by_right.positions - by_left.positions, rotations.log(turns)])
        slopes = np.zeros((len(errors), 6, 12))
        slopes[:, :3, :3] = slopes[:, 3:, 3:6] = np.eye(3)
        slopes[:, :3, 3:6] = -_cross(by_right.positions - base.positions)
        slopes[:, :3, 6:9] = slopes[:, 3:, 9:] = -self.tips[0].matrices()
        return errors, slopes

    def weights(self, base: Transforms, grasp: Transforms) -> Float64Array:
        """Inverse square roots (n, 6, 6) of the errors' covariances for joints off by 1 rad."""
        lever = np.einsum("nij,j->ni", self.tips[0].matrices(), grasp.positions[0])
        left = self.jacobians[0].copy()
        left[:, :3] -= _cross(lever) @ left[:, 3:]
        right = np.kron(np.eye(2), base.matrices()[0]) @ self.jacobians[1]
        covariances = left @ left.transpose(0, 2, 1) + right @ right.transpose(0, 2, 1)
        values, vectors = np.linalg.eigh(covariances)
        values = np.maximum(values, np.finfo(np.float64).eps * values[:, -1:])
        return np.asarray(vectors.transpose(0, 2, 1) * np.sqrt(self.averaged / values)[..., None])


def located(samples: Sequence[Carried], base: Transforms) -> BaseLocation:
    """The base that explains demonstrations best, by steps from a first guess."""
    grasps = [_first_grasp(each, base) for each in samples]
    for _ in range(_MAX_STEPS):
        normal, gradient, square, count = _normal_equations(samples, base, grasps)
        scale = np.sqrt(np.diag(normal))
        step = -np.linalg.lstsq(normal / np.outer(scale, scale), gradient / scale, rcond=None)[0]
        step /= scale
        base = _moved(base, step[:6])
        grasps = [_moved(grasp, step[6 * k + 6 : 6 * k + 12]) for k, grasp in enumerate(grasps)]
        if np.abs(step).max() < _CONVERGED:
            break
    noise = max(np.sqrt(square / max(count - len(step), 1)), _MIN_NOISE)
    return BaseLocation(base.single(), _base_covariance(normal, noise), float(noise))


def _averaged(rows: Float64Array, size: int) -> Float64Array:
    count = len(rows) // size
    return np.ascontiguousarray(rows[: size * count].reshape(count, size, -1).mean(axis=1))


def _first_grasp(samples: Carried, base: Transforms) -> Transforms:
    found = samples.tips[0].inverse() @ (base @ samples.tips[1])
    return Transforms(found.positions.mean(axis=0)[None], rotations.mean(found.orientations)[None])


def _normal_equations(
    samples: Sequence[Carried], base: Transforms, grasps: Sequence[Transforms]
) -> tuple[Float64Array, Float64Array, float, int]:
    """Normal matrix, gradient, sum of squares and number of errors; the base first."""
    size = 6 * (1 + len(samples))
    normal, gradient, square, count = np.zeros((size, size)), np.zeros(size), 0.0, 0
    for k, (each, grasp) in enumerate(zip(samples, grasps, strict=True)):
        errors, slopes = each.residuals(base, grasp)
        roots = each.weights(base, grasp)
        slopes = (roots @ slopes).reshape(-1, 12)
        errors = np.einsum("nij,nj->ni", roots, errors).ravel()
        columns = np.r_[0:6, 6 * k + 6 : 6 * k + 12]
        normal[np.ix_(columns, columns)] += slopes.T @ slopes
        gradient[columns] += slopes.T @ errors
        square, count = square + float(errors @ errors), count + len(errors)
    return normal, gradient, square, count


def _base_covariance(normal: Float64Array, noise: float) -> Float64Array:
    """Covariance (6, 6) of the base alone; refused where it is too large."""
    rest = normal[6:, 6:]
    own = normal[:6, :6] - normal[:6, 6:] @ np.linalg.solve(rest, normal[6:, :6])
    values, vectors = np.linalg.eigh(0.5 * (own + own.T))
    values = np.maximum(values, np.finfo(np.float64).eps * np.abs(normal).max())
    covariance = noise**2 * (vectors / values) @ vectors.T
    parts = covariance[:3, :3], covariance[3:, 3:]
    away, turned = (float(np.sqrt(np.linalg.eigvalsh(part)[-1])) for part in parts)
    if away > MAX_DEVIATIONS[0] or turned > MAX_DEVIATIONS[1]:
        axis = np.linalg.eigh(parts[0])[1][:, -1]
        raise FitError(
            f"demonstrations: they leave the right base open by {1e3 * away:.3g} mm along "
            f"({', '.join(f'{x:.2f}' for x in axis)}) and {np.degrees(turned):.3g} degrees "
            "(standard deviations); tilt the object about two axes while both arms hold it"
        )
    return np.asarray(covariance)


def _moved(pose: Transforms, step: Float64Array) -> Transforms:
    turn = rotations.exp(step[None, 3:])
    return Transforms(pose.positions + step[:3], rotations.compose(turn, pose.orientations))


def _cross(vectors: Float64Array) -> Float64Array:
    """Matrices (n, 3, 3) of cross products with vectors (n, 3)."""
    return np.cross(vectors[:, None], np.eye(3)).transpose(0, 2, 1)
