"""Calls of what computes in some cells of a map only."""

import numpy as np
from bindings.calls import call, make

from leadthrough import _core as core

# All cells of 3 x 4 and, for what takes any number of cells, the first.
CELLS = make(core.CellSet, shape=[3, 4], spacing=[1.0, 1.0], cells=np.arange(12))
FIRST_ROW = np.array([0.0, 1.0, 2.0, 3.0, *np.full(8, np.inf)])
SOURCE = {"cells": np.array([0]), "times": np.zeros(1), "source_radius": 0.0, "stop": -1}
MAP = {"shape": [3, 4], "spacing": [1.0, 1.0], "cells": np.array([0])}

call(CELLS.find, [0, 5, -1], cells=np.array([0, 5, 20]))
call(CELLS.march, FIRST_ROW, speed=np.where(np.arange(12) < 4, 1.0, 0.0), **SOURCE)
call(CELLS.is_open, False, times=FIRST_ROW)
ALONG_ROW = {"cells": [np.array([0]), np.array([3])], "times": [np.zeros(1), np.zeros(1)]}
call(
    CELLS.waves,
    np.where(np.arange(12) < 4, 1.0, np.inf),
    speed=np.where(np.arange(12) < 4, 1.0, 0.0),
    **ALONG_ROW,
    are_outside=[False, False],
    reach=1.0,
)
call(
    CELLS.distances,
    np.hypot(*np.divmod(np.arange(12), 4)),
    mask=np.arange(12) == 0,
)
call(CELLS.depths, np.full(12, np.inf))
call(CELLS.descend, "ok", arrival=FIRST_ROW, start=[0.0, 3.0], goal=[0.0, 0.0], step=0.5)
call(core.cells_within, [0, 1, 4], **MAP, radius=1.0)
call(core.finer_cells, [0, 1, 4, 5], coarse_shape=[2, 2], fine_shape=[4, 4], cells=np.array([0]))
BLOCKS = make(core.Blocks, shape=[3, 4], spacing=[2.0, 1.0], first=[10.0, 20.0], reach=0.0)
call(BLOCKS.centres, [[10.0, 23.0], [12.0, 20.0]], numbers=np.array([3, 4]))
call(
    core.tube_speeds,
    [0.75, 0.5],
    blocks=BLOCKS,
    numbers=np.array([1, 4]),
    paths=[np.array([[10.0, 20.0], [10.0, 20.5]])],
    weights=[1.0],
    radius=1.0,
    saturation=0.5,
)
WALLS = make(
    core.Walls,
    cells=BLOCKS,
    margin=0.5,
    shapes=[core.sphere_shape(0.1, np.array([10.0, 20.0, 0.0]))],
    middles=np.array([[10.0, 20.0, 0.0]]),
    half_extents=np.full((1, 3), 0.1),
)
call(WALLS.hold, [True, False], numbers=np.array([0, 1]))
call(WALLS.distances, [0.0, 1.0, 1.5], numbers=np.array([0, 1, 2]), most=1.5)
call(WALLS.farthest, [0.0, 1.4], blocks=BLOCKS, numbers=np.array([0, 1]), most=3.0)
call(WALLS.nearest, [-0.6, 0.4], blocks=BLOCKS, numbers=np.array([0, 1]), most=3.0)
