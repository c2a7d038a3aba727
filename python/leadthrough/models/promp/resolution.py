"""Via points too close for the basis: few functions cannot bend from one to the next."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput

if TYPE_CHECKING:
    from leadthrough.models.promp.skill import ProMPSkill

# Elsewhere a motion may move this many times as far as its via points do, relative to its reach.
_MOST_GAIN = 5.0
# Via points farther apart than this many spacings of the basis functions are resolved.
_RESOLVED = 2.0
# Fraction of a via point's row, squared, that points fixed before may determine.
_MOST_DETERMINED = 0.5
_PHASES_PER_WEIGHT = 4
_ROUNDING = 1e-6  # fraction of the reach that counts as no move


def refuse_too_close(
    before: ProMPSkill,
    after: ProMPSkill,
    phases: Float64Array,
    values: Float64Array,
    columns: NDArray[np.int64],
) -> None:
    """Refuses exact via points that the basis can only pass by throwing the motion elsewhere."""
    size, count = before.chart.width, before.basis.count
    curves = before.free.mean.reshape(size, count)
    asked = np.abs(values - before.basis(phases) @ curves[columns].T) / before.scale[columns]
    rows = before.basis(np.linspace(0.0, 1.0, _PHASES_PER_WEIGHT * count + 1))
    change = rows @ (after.free.mean.reshape(size, count) - curves).T / before.scale
    if np.abs(change).max() <= _MOST_GAIN * float(asked.max()) + _ROUNDING:
        return
    spacing = float(np.diff(before.basis.centres).max())  # B-splines stand closer at the ends
    advice = (
        f"the {count} weights tell times apart from {_RESOLVED * spacing * before.duration:.3g} s "
        "on; move them apart, let their values lie on a smooth curve, give a covariance, or fit "
        "with more weights"
    )
    times = np.sort(phases) * before.duration
    gaps = np.diff(np.sort(phases))
    if len(gaps) > 0 and gaps.min() < _RESOLVED * spacing:
        first = int(gaps.argmin())
        raise InvalidInput(
            f"time: expected via points that the motion can pass one after the other, got ones at "
            f"{times[first]:.6g} s and {times[first + 1]:.6g} s; {advice}"
        )
    if _is_determined(before, phases, columns):
        raise InvalidInput(
            f"time: expected via points that the motion can pass one after the other, got one at "
            f"{times[0]:.6g} s right beside a point fixed before; {advice}"
        )


def _is_determined(skill: ProMPSkill, phases: Float64Array, columns: NDArray[np.int64]) -> bool:
    """Whether points fixed before, close by, leave a via point little freedom."""
    picked = np.eye(skill.chart.width)[columns]
    rows = np.concatenate([np.kron(picked, row) for row in skill.basis(phases)])
    known = ((rows @ skill.free.certain) ** 2).sum(axis=1)
    return bool((known > _MOST_DETERMINED * (rows**2).sum(axis=1)).any())
