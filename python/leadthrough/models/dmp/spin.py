"""Whether a primitive with the continuous logarithm would spin: turn by far more than was shown.

Beside whole turns the logarithm of orientation="lifted" swings about, where the tool hardly turns.
"""

from __future__ import annotations

import numpy as np

from leadthrough import _core, rotations
from leadthrough.check import Float64Array
from leadthrough.errors import FitError, UnsupportedQuery
from leadthrough.models.dmp.springs import Springs
from leadthrough.models.dmp.turning import Turning

# What a motion may turn more or less than the demonstration and its offset, before it counts as
# spinning, or as having lost a turn.
_SPIN = np.radians(20.0)
_SAMPLES = 1000


def refuses_spins(springs: Springs, turning: Turning) -> bool:
    """Whether queries on whose way the tool would spin are refused."""
    # The form "ijspeert" scales the rotation itself.
    return turning.representation == "lifted" and springs.form != "ijspeert"


def refuse_spin(springs: Springs, turning: Turning, state: _core.PoseState) -> None:
    """Refuses a state from which the tool would spin on its way to the end."""
    if state.phase >= 1.0:
        return
    phases = np.linspace(state.phase, 1.0, _SAMPLES)
    ahead = _angle(_orientations(springs, turning, state, phases))
    least = turning.angle if state.phase == 0.0 else 0.0
    allowed = _SPIN + float(np.linalg.norm(state.offset.end))
    if not least - allowed <= ahead <= turning.angle + allowed:
        raise UnsupportedQuery(
            f'orientation="lifted": from here to this goal it would turn by '
            f"{np.degrees(ahead):.0f} degrees, but {np.degrees(turning.angle):.0f} were shown; "
            'use "anchored"'
        )


def replayed_angle(
    springs: Springs,
    turning: Turning,
    state: _core.PoseState,
    phases: Float64Array,
    orientations: Float64Array,
) -> float:
    """The angle turned in replay, rad."""
    made = _orientations(springs, turning, state, phases)
    worst = float(rotations.distance(made, orientations).max())
    if worst > _SPIN:
        raise FitError(
            f'demonstrations: orientation="lifted" would be off by {np.degrees(worst):.0f} degrees '
            'beside a whole number of turns; use "anchored"'
        )
    return _angle(made)


def _orientations(
    springs: Springs,
    turning: Turning,
    state: _core.PoseState,
    phases: Float64Array,
) -> Float64Array:
    values, _ = _core.dmp_rollout(springs.forces, state.course, state.value, state.slope, phases)
    return turning.orientations(phases, values, state.offset)


def _angle(orientations: Float64Array) -> float:
    """The angle turned over all of orientations (n, 4), rad."""
    return float(rotations.distance(orientations[:-1], orientations[1:]).sum())
