"""ProMPs observed through a task space, such as the position of an arm's tool.

Source: Gomez-Gonzalez et al. 2020, "Adaptation and robust learning of probabilistic movement
primitives", section IV-D, iterated as by Bell and Cathey 1993, "The iterated Kalman filter update
as a Gauss-Newton method".
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.models.promp.gaussian import Gaussian

if TYPE_CHECKING:
    from leadthrough.models.promp.skill import ProMPSkill

# Takes the columns (d,) of a motion, returns their value (p,) in the task space and the Jacobian
# (p, d) of that value.
TaskMap: TypeAlias = Callable[[Float64Array], tuple[ArrayLike, ArrayLike]]

_MOST_STEPS = 50
# The iteration ends when no column moves by more than this fraction of its reach.
_REACHED = 1e-9
# A row of the Jacobian counts as at least this fraction of the largest.
_LEAST_ROW = 1e-6


def through(
    skill: ProMPSkill,
    rows: Float64Array,
    value: ArrayLike,
    task: TaskMap,
    noise: Float64Array | None,
) -> Gaussian:
    """The weights after observing a value in a task space, by Gauss-Newton steps."""
    wanted = check.array(value, "value", shape=("p",))
    if len(wanted) == 0:
        raise InvalidInput("value: expected at least one number, got none")
    q = rows @ skill.free.mean
    for _ in range(_MOST_STEPS):
        reached, jacobian = _evaluated(task, q, len(wanted))
        scale = np.linalg.norm(jacobian * skill.scale, axis=1)
        scale = np.maximum(scale, _LEAST_ROW * float(scale.max()))
        if not scale.max() > 0.0:
            raise InvalidInput("task: expected a Jacobian that is not zero")
        linear = wanted - reached + jacobian @ q
        weights = skill.free.observe(jacobian @ rows, linear, noise, scale=scale, name="value")
        step = rows @ weights.mean - q
        q = q + step
        if np.abs(step / skill.scale).max() < _REACHED:
            return weights
    raise InvalidInput(
        f"value: expected a value that the motion can reach, got {wanted}; "
        f"the last step reached {reached}"
    )


def _evaluated(task: TaskMap, q: Float64Array, size: int) -> tuple[Float64Array, Float64Array]:
    reached, jacobian = task(q)
    return (
        check.array(reached, "task's value", shape=(size,)),
        check.array(jacobian, "task's Jacobian", shape=(size, len(q))),
    )
