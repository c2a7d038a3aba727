"""Calls of what computes in some cells of a map only."""

import numpy as np
from bindings.calls import call, make

from leadthrough import _core as core

CELLS = make(core.Cells, shape=[3, 4], spacing=[2.0, 1.0], first=[10.0, 20.0])
PATH = np.array([[10.0, 20.0], [10.0, 20.5]])
TUBE = make(core.tube_speeds, cells=CELLS, saturation=0.5, paths=[PATH], weights=[1.0], radius=1.0)
call(TUBE.at, [0.75, 0.5], cells=np.array([1, 4]))
call(TUBE.fastest, [1.0, 0.5], level=1, blocks=np.array([0, 3]))
WALLS = make(
    core.Walls,
    cells=CELLS,
    margin=0.5,
    shapes=[core.sphere_shape(0.1, np.array([10.0, 20.0, 0.0]))],
    middles=np.array([[10.0, 20.0, 0.0]]),
    half_extents=np.full((1, 3), 0.1),
)
call(WALLS.distances, [0.0, 1.0, 1.5], cells=np.array([0, 1, 2]), most=1.5)
SOME = {"cells": np.array([0, 1, 2])}
GIVEN = make(core.given_speeds, cells=CELLS, outside=0.0, speeds=np.arange(12.0).reshape(3, 4))
call(GIVEN.at, [0.0, 1.0, 2.0], **SOME)
call(GIVEN.fastest, [5.0, 7.0, 9.0, 11.0], level=1, blocks=np.arange(4))
call(GIVEN.quickest, "found", start=[10.0, 22.0], goal=[14.0, 23.0])
EXPERIENCE = make(core.experience_speeds, cells=CELLS, saturation=0.5, paths=[PATH], radius=1.0)
call(EXPERIENCE.at, [1.0, 0.5], cells=np.array([0, 3]))
HINDERED = make(core.hindered_speeds, free=GIVEN, walls=WALLS, reach=2.0)
call(HINDERED.at, [0.0, 0.5, 2.0], **SOME)
SATURATED = make(core.saturated_speeds, free=GIVEN, walls=WALLS, reach=2.0, saturation=0.6)
call(SATURATED.at, [0.0, 0.5, 2.0], **SOME)
PASSABLE = make(core.passable_speeds, free=TUBE, walls=WALLS, band=1.0, reach=3.0)
call(PASSABLE.at, [0.0, 1.0, 0.5], **SOME)
