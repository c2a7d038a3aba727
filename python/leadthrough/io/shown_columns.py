"""The joints that go along with a motion of the tip, as columns named `<joint>_shown`, in rad (m).

They are what keeps an arm that follows the motion in the posture that it was shown in.
"""

from __future__ import annotations

import numpy as np

from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.io.joint_columns import checked_joint_names
from leadthrough.io.table import Table
from leadthrough.motion import JointTrajectory, Motion, joints_with

_SUFFIX = "_shown"


def shown_columns(motion: Motion) -> dict[str, Float64Array]:
    """A column (n,) for each of the joints; none where there are none, or none with names."""
    joints = joints_with(motion)
    if joints is None or not joints.joint_names:
        return {}
    names = checked_joint_names(joints)
    return {f"{name}{_SUFFIX}": joints.positions[:, i] for i, name in enumerate(names)}


def shown_joints(table: Table, times: Float64Array) -> JointTrajectory | None:
    """The joints in a table, None where there are none or not at every time."""
    names = [name for name in table.names if name.endswith(_SUFFIX) and name != _SUFFIX]
    if not names:
        return None
    try:
        rows = np.column_stack([table.numbers(name) for name in names])
        joints = tuple(name.removesuffix(_SUFFIX) for name in names)
        return JointTrajectory(times, rows, joint_names=joints)
    except (InvalidInput, ValueError):  # faulty, as times of a recording may be too
        return None
