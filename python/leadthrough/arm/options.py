"""The options of inverse kinematics, checked."""

from __future__ import annotations

from leadthrough import _core, check


def ik_options(
    *,
    position_tolerance: float = 1e-6,
    orientation_tolerance: float = 1e-6,
    midrange: float = 0.0,
    max_iterations: int = 2000,
    max_restarts: int = 100,
    random_seed: int = 0,
) -> _core.IkOptions:
    """Options of `Arm.inverse_kinematics`.

    position_tolerance, orientation_tolerance: m and rad, > 0. midrange: how far a redundant arm
    moves itself towards the middle of its ranges once the tip is on the target, 0 (it stays next
    to the seed) to 1. max_iterations, max_restarts: the effort, the same on every machine.
    random_seed: of the restarts. Raises InvalidInput.
    """
    return _core.IkOptions(
        tolerance(position_tolerance, orientation_tolerance),
        check.number(midrange, "midrange", at_least=0.0, at_most=1.0),
        check.integer(max_iterations, "max_iterations", at_least=1, at_most=10**9),
        check.integer(max_restarts, "max_restarts", at_least=0, at_most=10**9),
        check.integer(random_seed, "random_seed", at_least=0, at_most=2**64 - 1),
    )


def tolerance(position: float, orientation: float) -> _core.IkTolerance:
    """Tolerances in m and rad. Raises InvalidInput."""
    return _core.IkTolerance(
        check.number(position, "position_tolerance", above=0.0),
        check.number(orientation, "orientation_tolerance", above=0.0),
    )
