"""The lengths of the speed maps, from a model's settings and the size of its demonstrations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from leadthrough.models.marching.model import FastMarching

# Radii in fractions of the demonstrations' mean length, so that the unit of the data does not
# matter. The map of all demonstrations wants tubes that overlap, a tube around one path a thin one.
MAP_RADIUS = 0.02
TUBE_RADIUS = 0.01
# In three dimensions thin tubes need more cells than they are worth.
_GROWTH = 3.0


@dataclass(frozen=True)
class Scales:
    """Lengths and speeds of a map; lengths in the demonstrations' unit."""

    radius: float  # of the tubes
    clearance: float  # distance from obstacles below which they slow the wave down
    saturation: float  # speed outside the tubes, in (0, 1]
    resolution: float | None
    growth: float = 1.0  # how much wider than the radius the tubes may become there
    workspace: tuple[tuple[float, ...], tuple[float, ...]] | None = None
    obstacle_map: str = "product"  # how obstacles enter the map, "product" or "minimum"


def scales_of(model: FastMarching, lengths: Sequence[float], fraction: float) -> Scales:
    """The scales of a model's map."""
    given = model.area_of_influence
    length = float(np.mean(lengths))
    return Scales(
        radius=given or fraction * length,
        clearance=given or MAP_RADIUS * length,
        saturation=model.saturation,
        resolution=model.resolution,
        growth=1.0 if given else _GROWTH,
        workspace=model.workspace,
        obstacle_map=model.obstacle_map,
    )
