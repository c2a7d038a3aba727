"""Inverse kinematics as in Yang et al.: damped steps alone, without restarts, see `yang`."""

from __future__ import annotations

from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.arm.definition import ArmDefinition
from leadthrough.arm.options import tolerance
from leadthrough.arm.results import IkBatch, IkResult, batch_of_results, first_of
from leadthrough.arm.targets import many_poses, many_seeds, one_pose
from leadthrough.arm.yang import DampedLeastSquares, checked_settings
from leadthrough.check import Float64Array


class ArmDampedInverseKinematics(ArmDefinition):
    """The methods of an `Arm` that solve poses by plain damped least squares."""

    def damped_inverse_kinematics(
        self,
        position: ArrayLike,
        orientation: ArrayLike | None = None,
        *,
        seed: ArrayLike | None = None,
        settings: DampedLeastSquares | None = None,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        max_iterations: int = 2000,
    ) -> IkResult:
        """The configuration that damped least-squares steps from a seed end in.

        This is a reference for studies of singularities; `inverse_kinematics` reaches more poses
        and is faster. Each iteration is a step of one second.

        Args:
            position: (3,) in m, base frame.
            orientation: (4,) w, x, y, z; None leaves it free.
            seed: configuration (joints,) where the steps start; by default the middle of the
                joints' ranges.
            settings: those of the method; by default `DampedLeastSquares()`.
            position_tolerance: error in m that counts as reached, > 0.
            orientation_tolerance: error in rad that counts as reached, > 0.
            max_iterations: budget of steps.

        Raises:
            InvalidInput: if an argument has another type or shape, or is out of its range.

        Source: Yang, Liu and Pears, equations 3 to 7.
        """
        target, turned = one_pose(position, orientation)
        batch = self._damped_steps(
            (target[None], turned.reshape(-1, 4)),
            (self._chain.middle if seed is None else self._joints(seed, "seed"))[None],
            settings=settings,
            position_tolerance=position_tolerance,
            orientation_tolerance=orientation_tolerance,
            max_iterations=max_iterations,
            threads=1,
        )
        return first_of(self.joint_names, batch)

    def damped_inverse_kinematics_batch(
        self,
        positions: ArrayLike,
        orientations: ArrayLike | None = None,
        *,
        seeds: ArrayLike | None = None,
        threads: int = 1,
        settings: DampedLeastSquares | None = None,
        position_tolerance: float = 1e-6,
        orientation_tolerance: float = 1e-6,
        max_iterations: int = 2000,
    ) -> IkBatch:
        """Configurations for many poses at once, each as by `damped_inverse_kinematics`.

        Args:
            positions: (m, 3) in m, base frame.
            orientations: (m, 4) w, x, y, z; None leaves them free.
            seeds: configurations (m, joints) where the steps start, or (joints,) for all of them;
                by default the middle of the joints' ranges.
            threads: number of threads, 1 to 256; does not change the answer.
            settings: those of the method; by default `DampedLeastSquares()`.
            position_tolerance: error in m that counts as reached, > 0.
            orientation_tolerance: error in rad that counts as reached, > 0.
            max_iterations: budget of steps for each pose.

        Returns:
            One row per pose.

        Raises:
            InvalidInput: if an argument has another type or shape, or is out of its range.
        """
        targets = many_poses(positions, orientations)
        return self._damped_steps(
            targets,
            many_seeds(seeds, len(targets[0]), default=self._chain.middle),
            settings=settings,
            position_tolerance=position_tolerance,
            orientation_tolerance=orientation_tolerance,
            max_iterations=max_iterations,
            threads=threads,
        )

    def _damped_steps(
        self,
        targets: tuple[Float64Array, Float64Array],
        starts: Float64Array,
        *,
        settings: DampedLeastSquares | None,
        position_tolerance: float,
        orientation_tolerance: float,
        max_iterations: int,
        threads: int,
    ) -> IkBatch:
        columns = _core.solve_yang(
            self._chain,
            *targets,
            starts,
            tolerance(position_tolerance, orientation_tolerance),
            check.integer(max_iterations, "max_iterations", at_least=1, at_most=10**9),
            checked_settings(settings).compiled(),
            check.integer(threads, "threads", at_least=1, at_most=256),
        )
        return batch_of_results(columns)
