"""Inverse kinematics of single poses and of batches of them."""

from __future__ import annotations

from typing import Any

import numpy as np

from leadthrough import _core, check
from leadthrough.arm import yang
from leadthrough.arm.options import ik_options
from leadthrough.arm.results import STATUSES, Answer, Columns, IkBatch, IkResult
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

_FREE = np.empty(0)
_NO_ORIENTATIONS = np.empty((0, 4))
_DEFAULTS = ik_options()
_METHODS = ("search", "yang")
_NAMES_OF_POSITION = {"x", "y", "z"}


def solve(
    chain: _core.Chain,
    position: Any,
    orientation: Any = None,
    *,
    seed: Float64Array | None = None,
    method: str = "search",
    **options: Any,
) -> IkResult:
    """See `Arm.inverse_kinematics`."""
    target = check.array(position, "position", shape=(3,))
    turned = _orientation(orientation)
    if method != "search" and check.choice(method, "method", _METHODS) == "yang":
        rows = turned[None] if len(turned) else _NO_ORIENTATIONS
        seeds = (chain.middle if seed is None else seed)[None]
        return _first(chain, yang.solve(chain, target[None], rows, seeds, threads=1, **options))
    checked = _DEFAULTS
    if options:
        checked, seed = _options(chain, options, seed, oriented=len(turned) > 0)
    start = chain.middle if seed is None else seed
    return _result(chain, _core.solve_ik(chain, target, turned, start, checked))


def solve_batch(
    chain: _core.Chain,
    positions: Any,
    orientations: Any = None,
    *,
    seeds: Any = None,
    threads: int = 1,
    method: str = "search",
    **options: Any,
) -> IkBatch:
    """See `Arm.inverse_kinematics_batch`."""
    targets = check.array(positions, "positions", shape=("m", 3))
    count = len(targets)
    turned = _NO_ORIENTATIONS
    if orientations is not None:
        turned = check.quaternions(orientations, "orientations", shape=(count, 4))
    workers = check.integer(threads, "threads", at_least=1, at_most=256)
    if check.choice(method, "method", _METHODS) == "yang":
        starts = _seeds(chain, seeds, count)
        return _batch(yang.solve(chain, targets, turned, starts, threads=workers, **options))
    checked, one = _options(chain, options, None, oriented=orientations is not None)
    starts = _seeds(chain, one if seeds is None else seeds, count)
    return _batch(_core.solve_ik_batch(chain, targets, turned, starts, checked, workers))


def solve_all(
    chain: _core.Chain,
    position: Any,
    orientation: Any = None,
    *,
    count: int = 8,
    separation: float = 0.1,
    seed: Float64Array | None = None,
    **options: Any,
) -> IkBatch:
    """See `Arm.inverse_kinematics_all`."""
    target = check.array(position, "position", shape=(3,))
    turned = _orientation(orientation)
    effort = {"max_iterations": 20_000, "max_restarts": 1000, "mode": "closest", **options}
    checked, seed = _options(chain, effort, seed, oriented=len(turned) > 0)
    return _batch(
        _core.solve_ik_all(
            chain,
            target,
            turned,
            chain.middle if seed is None else seed,
            checked,
            check.integer(count, "count", at_least=1, at_most=64),
            check.number(separation, "separation", above=0.0),
        )
    )


def _orientation(value: Any) -> Float64Array:
    return _FREE if value is None else check.quaternions(value, "orientation", shape=(4,))


def _options(
    chain: _core.Chain, options: dict[str, Any], seed: Float64Array | None, *, oriented: bool
) -> tuple[_core.IkOptions, Float64Array | None]:
    """The options, and where the search starts: at what is to be near, unless there is a seed."""
    checked = dict(options)
    for name in ("reference", "posture"):
        if checked.get(name) is not None:
            checked[name] = check.array(checked[name], name, shape=(len(chain.joint_names),))
            seed = checked[name] if seed is None else seed
    core = ik_options(**checked)
    if not oriented and set(checked.get("free", ())) >= _NAMES_OF_POSITION:
        raise InvalidInput("free: expected an axis to be left, got all of the position's")
    return core, seed


def _seeds(chain: _core.Chain, seeds: Any, count: int) -> Float64Array:
    joints = len(chain.joint_names)
    if seeds is not None and np.ndim(seeds) == 2:
        return check.array(seeds, "seeds", shape=(count, joints))
    one = chain.middle if seeds is None else check.array(seeds, "seeds", shape=(joints,))
    return np.tile(one, (count, 1))


def _result(chain: _core.Chain, answer: Answer) -> IkResult:
    q, status, position_error, orientation_error, iterations, limiting = answer
    names = _names(chain, limiting) if limiting else ()
    return IkResult(
        q, status == 0, STATUSES[status], position_error, orientation_error, iterations, names
    )


def _names(chain: _core.Chain, bits: int) -> tuple[str, ...]:
    return tuple(name for i, name in enumerate(chain.joint_names) if bits >> i & 1)


def _batch(columns: Columns) -> IkBatch:
    q, status, position_errors, orientation_errors, iterations, limiting = columns
    verdicts = np.array(STATUSES)[status]
    return IkBatch(
        q, status == 0, verdicts, position_errors, orientation_errors, iterations, limiting
    )


def _first(chain: _core.Chain, columns: Columns) -> IkResult:
    q, status, position_errors, orientation_errors, iterations, limiting = columns
    bits = sum(1 << i for i, joint in enumerate(limiting[0]) if joint)
    answer = (
        q[0],
        int(status[0]),
        float(position_errors[0]),
        float(orientation_errors[0]),
        int(iterations[0]),
        bits,
    )
    return _result(chain, answer)
