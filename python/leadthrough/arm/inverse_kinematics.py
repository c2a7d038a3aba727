"""Inverse kinematics of single poses and of batches of them."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from leadthrough import _core, check
from leadthrough.arm.definition import ArmDefinition
from leadthrough.arm.options import Axis, IkMode, ik_options
from leadthrough.arm.results import IkBatch, IkResult, batch_of_results, one_result
from leadthrough.arm.targets import many_poses, many_seeds, one_pose, require_position_axis
from leadthrough.check import Float64Array


class ArmInverseKinematics(ArmDefinition):
    """The methods of an `Arm` that find configurations for poses of its tip."""

    def inverse_kinematics(
        self,
        position: ArrayLike,
        orientation: ArrayLike | None = None,
        *,
        seed: ArrayLike | None = None,
        position_tolerance: ArrayLike = 1e-6,
        orientation_tolerance: ArrayLike = 1e-6,
        free: Sequence[Axis] = (),
        weights: ArrayLike | None = None,
        mode: IkMode = "fastest",
        reference: ArrayLike | None = None,
        midrange: float = 0.0,
        posture: ArrayLike | None = None,
        max_iterations: int = 2000,
        max_restarts: int = 100,
        max_cpu_seconds: float | None = None,
        random_seed: int = 0,
    ) -> IkResult:
        """A configuration inside the limits that brings the tip to a pose.

        A target that cannot be reached gives `success` False and the closest configuration found.
        The same input gives the same answer. Self-motion is in the exact null space: it moves the
        tip by less than 1e-6 m.

        Args:
            position: (3,) in m, base frame.
            orientation: (4,) w, x, y, z; None leaves it free.
            seed: configuration (joints,) where the search starts, moved inside the limits; by
                default `reference` or `posture`, else the middle of the joints' ranges.
            position_tolerance: in m, > 0, of the length of the error; or (3,), of its component
                along each axis of the target's frame (of the base frame without orientation).
            orientation_tolerance: in rad, > 0, of the angle; or (3,), about each of these axes.
            free: axes left free, out of "x", "y", "z" and the rotations about them "rx", "ry",
                "rz", in the same frame as the tolerances. With one free rotation the tool may spin
                about that axis of its own, and only the tilt of the axis is an error; with two,
                only the twist about the third is.
            weights: (6,), > 0, cost of an error along and about each axis while the arm moves and
                where a target cannot be reached. With weights of 1, 1 m costs as much as
                1 / 0.3 rad.
            mode: "fastest" returns the first solution found; "closest", of all that the budget
                finds, the one nearest to `reference`, moved nearer still in the null space.
            reference: configuration (joints,) for mode "closest", the seed by default. Distances
                are Euclidean, rad and m alike.
            midrange: fraction, 0 to 1, of the way towards the middle of its ranges that a
                redundant arm moves in its null space once the tip is on the target; at 0 it stays
                next to the seed.
            posture: configuration (joints,) towards which a redundant arm moves in its null space
                instead, for example with its elbow up.
            max_iterations: budget of iterations, the same on every machine.
            max_restarts: budget of restarts from random configurations.
            max_cpu_seconds: CPU time of the calling thread, > 0, that ends the search as well; the
                answer then depends on the machine.
            random_seed: seed of the random number generator of the restarts.

        Raises:
            InvalidInput: if an argument is out of its range, or two contradict each other.
        """
        target = one_pose(position, orientation)
        near, wished = self._wishes(reference, posture)
        options = ik_options(
            position_tolerance=position_tolerance,
            orientation_tolerance=orientation_tolerance,
            free=free,
            weights=weights,
            mode=mode,
            reference=near,
            midrange=midrange,
            posture=wished,
            max_iterations=max_iterations,
            max_restarts=max_restarts,
            max_cpu_seconds=max_cpu_seconds,
            random_seed=random_seed,
        )
        require_position_axis(free, orientation)
        start = self._start(seed, near, wished)
        answer = _core.solve_ik(self._chain, *target, start, options)
        return one_result(self.joint_names, answer)

    def inverse_kinematics_batch(
        self,
        positions: ArrayLike,
        orientations: ArrayLike | None = None,
        *,
        seeds: ArrayLike | None = None,
        threads: int = 1,
        position_tolerance: ArrayLike = 1e-6,
        orientation_tolerance: ArrayLike = 1e-6,
        free: Sequence[Axis] = (),
        weights: ArrayLike | None = None,
        mode: IkMode = "fastest",
        reference: ArrayLike | None = None,
        midrange: float = 0.0,
        posture: ArrayLike | None = None,
        max_iterations: int = 2000,
        max_restarts: int = 100,
        max_cpu_seconds: float | None = None,
        random_seed: int = 0,
    ) -> IkBatch:
        """Configurations for many poses at once, each as by `inverse_kinematics`.

        Args:
            positions: (m, 3) in m, base frame.
            orientations: (m, 4) w, x, y, z; None leaves them free.
            seeds: configurations (m, joints) where the searches start, or (joints,) for all of
                them; by default `reference` or `posture`, else the middle of the joints' ranges.
            threads: number of threads, 1 to 256; does not change the answer.
            position_tolerance: in m, or (3,), as in `inverse_kinematics`.
            orientation_tolerance: in rad, or (3,), as there.
            free: axes left free, as there.
            weights: (6,) of the axes, as there.
            mode: "fastest" or "closest", as there.
            reference: (joints,) for mode "closest" and all poses; the seeds by default.
            midrange: fraction of the way towards the middle of the ranges, as there.
            posture: (joints,) towards which a redundant arm moves at all poses.
            max_iterations: budget of iterations for each pose.
            max_restarts: budget of restarts for each pose.
            max_cpu_seconds: CPU time for each pose.
            random_seed: seed of the random number generator of the restarts.

        Returns:
            One row per pose.

        Raises:
            InvalidInput: if an argument is out of its range, or two contradict each other.
        """
        targets = many_poses(positions, orientations)
        near, wished = self._wishes(reference, posture)
        options = ik_options(
            position_tolerance=position_tolerance,
            orientation_tolerance=orientation_tolerance,
            free=free,
            weights=weights,
            mode=mode,
            reference=near,
            midrange=midrange,
            posture=wished,
            max_iterations=max_iterations,
            max_restarts=max_restarts,
            max_cpu_seconds=max_cpu_seconds,
            random_seed=random_seed,
        )
        require_position_axis(free, orientations)
        workers = check.integer(threads, "threads", at_least=1, at_most=256)
        starts = many_seeds(seeds, len(targets[0]), default=self._start(None, near, wished))
        columns = _core.solve_ik_batch(self._chain, *targets, starts, options, workers)
        return batch_of_results(columns)

    def inverse_kinematics_all(
        self,
        position: ArrayLike,
        orientation: ArrayLike | None = None,
        *,
        count: int = 8,
        separation: float = 0.1,
        reference: ArrayLike | None = None,
        seed: ArrayLike | None = None,
        position_tolerance: ArrayLike = 1e-6,
        orientation_tolerance: ArrayLike = 1e-6,
        free: Sequence[Axis] = (),
        weights: ArrayLike | None = None,
        max_iterations: int = 20_000,
        max_restarts: int = 1000,
        max_cpu_seconds: float | None = None,
        random_seed: int = 0,
    ) -> IkBatch:
        """Distinct configurations that reach a pose, the one nearest to `reference` first.

        Those of a redundant arm are first moved in the null space as near to `reference` as the
        task lets them. The search uses its whole budget.

        Args:
            position: (3,) in m, base frame.
            orientation: (4,) w, x, y, z; None leaves it free.
            count: number of configurations to return at most, 1 to 64.
            separation: two configurations are distinct if a joint differs by more than this, in
                rad (whole turns left out) or m, > 0.
            reference: configuration (joints,) by whose distance they are sorted; the seed by
                default.
            seed: configuration (joints,) where the search starts; by default `reference`, else the
                middle of the joints' ranges.
            position_tolerance: in m, or (3,), as in `inverse_kinematics`.
            orientation_tolerance: in rad, or (3,), as there.
            free: axes left free, as there.
            weights: (6,) of the axes, as there.
            max_iterations: budget of iterations of the whole search.
            max_restarts: budget of restarts of the whole search.
            max_cpu_seconds: CPU time of the whole search, as there.
            random_seed: seed of the random number generator of the restarts.

        Returns:
            One row per configuration; none where no solution was found.

        Raises:
            InvalidInput: if an argument is out of its range.
        """
        target = one_pose(position, orientation)
        near, _ = self._wishes(reference, None)
        options = ik_options(
            position_tolerance=position_tolerance,
            orientation_tolerance=orientation_tolerance,
            free=free,
            weights=weights,
            mode="closest",
            reference=near,
            max_iterations=max_iterations,
            max_restarts=max_restarts,
            max_cpu_seconds=max_cpu_seconds,
            random_seed=random_seed,
        )
        require_position_axis(free, orientation)
        return batch_of_results(
            _core.solve_ik_all(
                self._chain,
                *target,
                self._start(seed, near, None),
                options,
                check.integer(count, "count", at_least=1, at_most=64),
                check.number(separation, "separation", above=0.0),
            )
        )

    def _wishes(
        self, reference: ArrayLike | None, posture: ArrayLike | None
    ) -> tuple[Float64Array | None, Float64Array | None]:
        near = None if reference is None else self._joints(reference, "reference")
        return near, None if posture is None else self._joints(posture, "posture")

    def _start(
        self, seed: ArrayLike | None, reference: Float64Array | None, posture: Float64Array | None
    ) -> Float64Array:
        """Where the search starts: at what the answer should be near to, unless a seed is given."""
        if seed is not None:
            return self._joints(seed, "seed")
        if reference is not None:
            return reference
        return self._chain.middle if posture is None else posture
