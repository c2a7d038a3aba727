"""What of a pose an arm may leave: the axes that are free along a path of the tip.

An arm of fewer than six joints has no posture for most poses. It keeps the position, and of the
rotations about the tip's axes it leaves those by whose freedom it turns away least.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from leadthrough import _core, rotations
from leadthrough.arm.options import Axis, free_axes
from leadthrough.arm.tracks import TipPath, Track
from leadthrough.errors import InvalidInput

_TURNS: tuple[Axis, ...] = ("rx", "ry", "rz")


def axes_to_try(
    path: TipPath, free: Sequence[Axis] | None, *, joints: int, in_time: bool
) -> list[tuple[Axis, ...]]:
    """The choices of axes to leave free along a path, that of none first."""
    if free is not None:
        free_axes(free)
        if free and in_time:
            raise InvalidInput("free: not used with too_fast='deviate' or 'raise'; leave it out")
        if not len(path.orientations) and (set(free) & set(_TURNS) or set(free) >= set("xyz")):
            raise InvalidInput(
                f"free: expected one or two of 'x', 'y', 'z' along points, got {list(free)}"
            )
        return [tuple(free)]
    missing = min(6 - joints, len(_TURNS)) if len(path.orientations) else 0
    if missing <= 0 or in_time:
        return [()]
    return [(), *combinations(_TURNS, missing)]


def least_turned(chain: _core.Chain, path: TipPath, tracks: Sequence[Track]) -> Track:
    """Of tracks with different axes free, the one that gets furthest and turns away least."""
    if len(tracks) == 1:
        return tracks[0]
    return min(tracks, key=lambda track: (-track.reached, _turned_away(chain, path, track)))


def _turned_away(chain: _core.Chain, path: TipPath, track: Track) -> float:
    """The largest angle between the tip and a sample, rad."""
    _, orientations = chain.forward_kinematics(track.q)
    away = rotations.distance(orientations, path.orientations[: len(orientations)])
    return float(np.max(away))
