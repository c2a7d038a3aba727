"""Refusals of `planning`: the argument of each call that cannot be meant."""

import numpy as np
import pytest

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.planning import (
    ArrivalField,
    arrival_times_batch,
    descend,
    direction,
    distance_transform,
    fm2_speed,
    nearest_sources,
    occupied,
    occupied_by_points,
    plan,
)

ONES, FREE = np.ones((5, 6)), np.zeros((5, 6), bool)
WALLED = np.where(np.indices((5, 6)).sum(axis=0) == 2, 0.0, 1.0)  # (1, 1) among others
GRID = lt.Grid((0.0, 0.0), 1.0, (5, 6))
TIMES = lt.arrival_times(ONES, (2, 2))
SPOILED = np.where(np.indices((5, 6)).sum(axis=0) == 2, np.nan, TIMES)
CORNERS = [(0.0, 0.0), (1.0, 1.0)]
FINEST = [(0.0, 0.0, 0.0), (1.0, 1.0, 1.0)]


def with_speed(value):
    return np.where(np.indices((5, 6)).sum(axis=0) == 5, value, 1.0)


def update_part(part, speed):
    ArrivalField(ONES, GRID, (2.0, 2.0)).update_part(part, speed)


CALLS = {
    "arrival_times": lambda speed=ONES, sources=(0, 0), **kw: lt.arrival_times(
        speed, sources, **kw
    ),
    "batch": lambda speeds=(ONES,), sources=((0, 0),), **kw: arrival_times_batch(
        speeds, sources, **kw
    ),
    "nearest_sources": lambda arrival=TIMES, sources=(2, 2), **kw: nearest_sources(
        arrival, sources, **kw
    ),
    "field": lambda speed=ONES, points=(2.0, 2.0), **kw: ArrivalField(speed, GRID, points, **kw),
    "update": lambda speed: ArrivalField(ONES, GRID, (2.0, 2.0)).update(speed),
    "update_part": lambda part=(slice(0, 1), slice(0, 1)), speed=0.5: update_part(part, speed),
    "distance_transform": lambda mask=FREE, **kw: distance_transform(mask, **kw),
    "descend": lambda arrival=TIMES, start=(0.0, 0.0), goal=(2.0, 2.0), **kw: descend(
        arrival, GRID, start, goal, **kw
    ),
    "direction": lambda arrival=TIMES, positions=((1.2, 1.0),): direction(arrival, GRID, positions),
    "occupied": lambda obstacles=(), **kw: occupied(GRID, obstacles, **kw),
    "occupied_by_points": lambda points=((0.0, 0.0),), radius=0.1: occupied_by_points(
        GRID, points, radius=radius
    ),
    "fm2_speed": lambda walls=FREE, **kw: fm2_speed(GRID, walls, **kw),
    "plan": lambda speed=ONES, start=(0.1, 0.1), goal=(0.2, 0.2): plan(speed, GRID, start, goal),
    "grid": lambda origin=(0.0, 0.0), spacing=1.0, shape=(3, 3): lt.Grid(origin, spacing, shape),
    "covering": lambda points=CORNERS, margin=0.0, spacing=1.0: lt.Grid.covering(
        points, margin=margin, spacing=spacing
    ),
}

ARRIVAL = [
    *(("speed", with_speed(bad)) for bad in (np.nan, np.inf, -1.0, 1e-300)),
    *(("speed", bad) for bad in (np.ones(5), np.ones((2,) * 4), np.ones((0, 3)), [["a"]], None)),
    ("speed", np.ones((3, 3), complex)),
    *(("sources", bad) for bad in [(5, 0), (-1, 0), (0.0, 0.0), (0,), (0, 0, 0), []]),
    ("sources", np.empty((0, 2), int)),
    ("sources", {"speed": WALLED, "sources": [(0, 0), (1, 1)]}),
    *(("order", 3), ("dtype", np.int32), ("stop", (9, 9)), ("source_radius", -1.0)),
    *(("spacing", bad) for bad in (0.0, (1.0, 1.0, 1.0))),
]
BATCH = [
    *(("sources", bad) for bad in ([(9, 9)], None)),
    *(("speeds", bad) for bad in ([], [ONES, np.ones((6, 5))])),
    *(
        ("speed", {"speeds": [ONES, -ONES]}),
        ("sources", {"speeds": [ONES] * 3, "sources": [(0, 0)] * 2}),
    ),
    *((name, -1) for name in ("threads", "order", "source_radius")),
]
UPDATES = [("speed", bad) for bad in (np.full((5, 6), np.nan), -ONES, np.ones((4, 6)), "speed")]
PARTS = [
    *(("part", bad) for bad in (slice(0, 2), (slice(0, 2),), (1, 2), ("a", "b"))),
    ("part", (slice(0, 4, 2), slice(None))),
    *(("part", (bad, slice(None))) for bad in (slice(3, 3), slice("a", None))),
    *(("speed", bad) for bad in (1e-20, 1e20)),
]
DESCENTS = [
    *(("arrival", bad) for bad in (TIMES[1:], np.full((5, 6), np.nan), -TIMES)),
    *(("start", bad) for bad in ((0.0, np.nan), (0.0, 0.0, 0.0))),
    *(("goal", bad) for bad in ((9.0, 9.0), (3.0, 3.0))),
    *(("step", bad) for bad in (1.0, np.nan)),
]
DIRECTIONS = [
    ("positions", [(np.nan, 0.0)]),
    *(("arrival", bad) for bad in (TIMES[1:], SPOILED, -TIMES - 1.0)),
]
FM2 = [
    ("walls", {"walls": FREE[1:], "saturation": 0.5}),
    *(("saturation", bad) for bad in ({"saturation": 1.5}, {})),
    ("area_of_influence", 0.0),
    ("saturation", {"saturation": 0.5, "area_of_influence": 1.0}),
]
GRIDS = [
    *(("origin", bad) for bad in ((0.0,), (0.0, np.nan))),
    *(("spacing", bad) for bad in (0.0, (1.0, 1.0, 1.0), (1.0, -1.0), "fine")),
    *(("shape", bad) for bad in ((3,), (3, 0), (3, 2.5), 3, (10**6, 10**6))),
]
COVERINGS = [
    *(("points", bad) for bad in (np.empty((0, 2)), [(1.0,)], [(0.0, np.inf)])),
    ("margin", -1.0),
    ("spacing", {"points": FINEST, "margin": 0.1, "spacing": 1e-9}),
    ("spacing", {"margin": 1e300, "spacing": 1e-300}),
]
TABLE = {
    "arrival_times": ARRIVAL,
    "batch": BATCH,
    "nearest_sources": [
        *(("arrival", bad) for bad in (np.full((5, 6), np.nan), TIMES > 0)),
        *(("sources", (9, 9)), ("spacing", -1.0)),
    ],
    "field": [
        ("speed", np.ones((9, 8))),
        *(("points", (20.0, 2.0)), ("sources", {"points": [(2.0, 2.0), (1.0,)]})),
        *(("sources", {"speed": np.zeros((5, 6))}), ("dtype", int)),
    ],
    "update": [("speed", WALLED * 0.0), *UPDATES],
    "update_part": PARTS,
    "distance_transform": [
        *(("mask", bad) for bad in (ONES, np.ones(3, bool), np.ones((0, 3), bool), None)),
        *(("spacing", bad) for bad in (-1.0, np.nan, (1.0, 2.0, 3.0), "1")),
    ],
    "descend": DESCENTS,
    "direction": DIRECTIONS,
    "occupied": [("obstacles", ["box"]), ("margin", np.nan)],
    "occupied_by_points": [("points", [(0.0, np.inf)]), ("radius", 0.0)],
    "fm2_speed": FM2,
    "plan": [("speed", ONES[1:]), ("start", (0.1, np.nan)), ("goal", (0.2, 0.2, 0.2))],
    "grid": GRIDS,
    "covering": COVERINGS,
}


@pytest.mark.parametrize(
    ("call", "argument", "given"),
    [
        pytest.param(call, argument, given, id=f"{call}-{argument}-{i}")
        for call, rows in TABLE.items()
        for i, (argument, given) in enumerate(rows)
    ],
)
def test_refusal_names_the_argument(call, argument, given):
    arguments = given if isinstance(given, dict) else {argument: given}
    with pytest.raises(InvalidInput) as error:
        CALLS[call](**arguments)
    assert error.value.argument == argument


def test_refused_change_leaves_the_field_as_it_is():
    field = ArrivalField(ONES, GRID, (2.0, 2.0))
    before = field.times
    for _, speed in UPDATES:
        with pytest.raises(InvalidInput):
            field.update(speed)
    for name, given in PARTS:
        with pytest.raises(InvalidInput):
            field.update_part(**{"part": (slice(0, 1), slice(0, 1)), "speed": 0.5, name: given})
    assert field.times is before
