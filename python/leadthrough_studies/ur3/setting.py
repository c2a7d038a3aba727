"""Parameters of Fast Marching Learning in the workspace study."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from leadthrough.models import FastMarching
from leadthrough_studies.ur3.setups import WORKSPACE


@dataclass(frozen=True)
class Setting:
    """Parameters of Fast Marching Learning.

    Attributes:
        area_of_influence: area of influence, m.
        saturation: saturation, in (0, 1].
        resolution: size of a cell, m.
        obstacle_map: "product" or "minimum", the paper's eq. 7.
    """

    area_of_influence: float = 0.05
    saturation: float = 0.25
    resolution: float = 0.01
    obstacle_map: Literal["product", "minimum"] = "product"

    def model(self) -> FastMarching:
        """Algorithm 1 with these parameters, over the whole workspace."""
        last = WORKSPACE - self.resolution  # the centre of the last cell
        return FastMarching(**vars(self), method="map", workspace=((0.0,) * 3, (last,) * 3))
