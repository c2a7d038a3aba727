"""The unit of joints: stated by the user, the format or a column's name, or the only one that fits.

LeRobot's data sets name their joints and not the unit, which is degrees or percent: of the joint's
range, from -100 at its lower limit to 100 at its upper one, or from 0 to 100 for a gripper. Only
degrees go beyond 100; only percent stop at it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io import headers
from leadthrough.io.headers import AngleUnit, Columns
from leadthrough.io.request import Request
from leadthrough.io.table import Table

# No arm stays more than two turns from zero for half of a recording; degrees do.
_FARTHEST_ANGLE = 4.0 * math.pi
_DEGREE = math.pi / 180.0
# Joints come this much beyond their limits by the slack of a calibration, rad; percent by rounding.
_SLACK = 0.1
_MOST_PERCENT, _END = 100.01, 1e-4


def unit_of(table: Table, columns: Columns, request: Request) -> AngleUnit | None:
    """The unit of a table's joints; None for radians, or where each column states its own."""
    stated = request.angles or table.angles
    if stated == "percent" and not {headers.joint(name) for name in columns} <= set(request.joints):
        raise InvalidInput(
            "angles: percent refer to the limits of an arm's joints, which are not known; name the "
            "arm (--robot); in Python, set joints"
        )
    if stated is not None or all(headers.unit(name, "joints")[1] is not None for name in columns):
        return stated
    extents = {name: table.extents[name] for name in columns if name in table.extents}
    arm = {name: extent for name, extent in extents.items() if not is_gripper(name)}
    if any(np.abs(extent).max() > _FARTHEST_ANGLE for extent in arm.values()):
        return _only_fitting(arm, request)
    return None


def in_radians(
    name: str, numbers: Float64Array, unit: AngleUnit | None, request: Request
) -> Float64Array:
    """A joint's numbers in rad; where the column's name states a unit, that one counts."""
    stated = headers.unit(name, "joints")[1]
    if stated is not None:
        return numbers * stated
    if unit == "percent":
        lower, upper = request.joints[headers.joint(name)]
        least = 0.0 if is_gripper(name) else -100.0
        return np.asarray(lower + (numbers - least) / (100.0 - least) * (upper - lower))
    return numbers * (_DEGREE if unit == "degrees" else 1.0)


def is_gripper(name: str) -> bool:
    """Whether a column is that of a gripper."""
    return "gripper" in name.lower()


def refuse_far(columns: Columns, positions: Float64Array, unit: AngleUnit | None) -> None:
    """Refuses joints that stay more than two turns from zero, while no unit is stated."""
    stated = [headers.unit(name, "joints")[1] is not None for name in columns]
    if unit is not None or all(stated) or len(positions) == 0:
        return
    # NaN is greater than nothing: a joint counts where half of its samples are far away.
    far = np.count_nonzero(np.abs(positions) > _FARTHEST_ANGLE, axis=0) > 0.5 * len(positions)
    if far.any():
        seen = float(np.nanmax(np.abs(positions[:, far])))
        raise InvalidInput(
            f"angles: joints reach {seen:.6g}, more than two turns in radians; set "
            "angles='degrees' or angles='radians'"
        )


def _only_fitting(extents: Mapping[str, tuple[float, float]], request: Request) -> AngleUnit:
    """Degrees or percent, whichever the extents of joints can be, if not both."""
    largest = max(float(np.abs(extent).max()) for extent in extents.values())
    if largest > _MOST_PERCENT:
        return "degrees"
    if abs(largest - 100.0) < _END:
        return "percent"
    for name, extent in extents.items():
        lower, upper = request.joints.get(headers.joint(name), (-math.inf, math.inf))
        if _DEGREE * extent[0] < lower - _SLACK or _DEGREE * extent[1] > upper + _SLACK:
            return "percent"
    raise InvalidInput(
        f"angles: the data set does not say whether its joints, which reach {largest:.6g}, are in "
        "degrees or in percent of their range, and both fit; set angles='degrees' or "
        "angles='percent'"
    )
