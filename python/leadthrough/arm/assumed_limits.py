"""A limits file with assumed accelerations and jerks where those of an arm are not known."""

from __future__ import annotations

import json

import numpy as np

from leadthrough.arm.arm import Arm
from leadthrough.check import Float64Array

_START = 0.5  # s from rest to the velocity limit
_ONSET = 0.05  # s from rest to full acceleration
_HIGHEST = 5.0  # rad/s^2
_HIGHEST_PRISMATIC = 1.0  # m/s^2
_HEAD = """\
# Limits of {robot} from {base} to {tip}, in rad/s^2 and rad/s^3
# (m/s^2 and m/s^3 for prismatic joints). The URDF states the others.
# Assumed values are cautious for most arms; replace them with the maker's where
# these are known.
robot = {name}

[sources]
acceleration = "{acceleration}"
jerk = "{jerk}"

[joints]
"""
_GIVEN = "as given"
_ASSUMED = {
    "acceleration": f"assumed: full speed after {_START} s, at most {_HIGHEST:g} rad/s^2 "
    f"({_HIGHEST_PRISMATIC:g} m/s^2); the URDF states none",
    "jerk": f"assumed: full acceleration after {_ONSET} s; the URDF states none",
}


def limits_file(arm: Arm) -> str:
    """The text of a limits file for the arm, whose comments state what is assumed."""
    limits = arm.limits
    acceleration = _acceleration(arm) if limits.acceleration is None else limits.acceleration
    jerk = acceleration / _ONSET if limits.jerk is None else limits.jerk
    head = _HEAD.format(
        robot=arm._robot.name,
        name=_quoted(arm._robot.name),
        base=arm.base,
        tip=arm.tip,
        acceleration=_source(limits.acceleration, "acceleration"),
        jerk=_source(limits.jerk, "jerk"),
    )
    rows = zip(arm.joint_names, acceleration.tolist(), jerk.tolist(), strict=True)
    return head + "".join(
        f"{_quoted(name)} = {{ acceleration = {most:.4g}, jerk = {onset:.4g} }}\n"
        for name, most, onset in rows
    )


def _acceleration(arm: Arm) -> Float64Array:
    prismatic = {
        joint.name for joint in arm._robot.path(arm.base, arm.tip) if joint.kind == "prismatic"
    }
    highest = np.array(
        [_HIGHEST_PRISMATIC if name in prismatic else _HIGHEST for name in arm.joint_names]
    )
    stated = np.where(arm.limits.velocity > 0.0, arm.limits.velocity, np.inf)
    return np.asarray(np.minimum(stated / _START, highest))


def _source(known: Float64Array | None, quantity: str) -> str:
    return _ASSUMED[quantity] if known is None else _GIVEN


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
