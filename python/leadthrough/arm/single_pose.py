"""Inverse kinematics of single poses and of batches of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.arm.options import ik_options
from leadthrough.arm.results import STATUSES, IkBatch, IkResult
from leadthrough.check import Float64Array

_FREE = np.empty(0)
_NO_ORIENTATIONS = np.empty((0, 4))
_DEFAULTS = ik_options()


def solve(
    chain: _core.Chain,
    position: Any,
    orientation: Any = None,
    *,
    seed: Float64Array | None = None,
    **options: Any,
) -> IkResult:
    """See `Arm.inverse_kinematics`."""
    q, status, position_error, orientation_error, iterations = _core.solve_ik(
        chain,
        check.array(position, "position", shape=(3,)),
        _FREE if orientation is None else check.quaternions(orientation, "orientation", shape=(4,)),
        chain.middle if seed is None else seed,
        ik_options(**options) if options else _DEFAULTS,
    )
    return IkResult(q, status == 0, STATUSES[status], position_error, orientation_error, iterations)


def solve_batch(
    chain: _core.Chain,
    positions: Any,
    orientations: Any = None,
    *,
    seeds: Any = None,
    threads: int = 1,
    **options: Any,
) -> IkBatch:
    """See `Arm.inverse_kinematics_batch`."""
    targets = check.array(positions, "positions", shape=("m", 3))
    count = len(targets)
    turned = _NO_ORIENTATIONS
    if orientations is not None:
        turned = check.quaternions(orientations, "orientations", shape=(count, 4))
    q, status, position_errors, orientation_errors, iterations = _core.solve_ik_batch(
        chain,
        targets,
        turned,
        _seeds(chain, seeds, count),
        ik_options(**options),
        check.integer(threads, "threads", at_least=1, at_most=256),
    )
    return IkBatch(
        q,
        status == 0,
        np.array(STATUSES)[status],
        position_errors,
        orientation_errors,
        iterations,
    )


def _seeds(chain: _core.Chain, seeds: Any, count: int) -> Float64Array:
    joints = len(chain.joint_names)
    if seeds is not None and np.ndim(seeds) == 2:
        return check.array(seeds, "seeds", shape=(count, joints))
    one = chain.middle if seeds is None else check.array(seeds, "seeds", shape=(joints,))
    return np.tile(one, (count, 1))
