"""A guard in a LeRobot pipeline: a processor step for actions by motor names."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.guard.admission import Admission
from leadthrough.guard.guard import Guard

_UNITS = {"degrees": np.pi / 180.0, "radians": 1.0}
_ENDING = ".pos"


class GuardStep:
    """A processor step that passes the commands that its guard admits, one action at a time.

        pipeline.steps.append(GuardStep(lt.Guard(arm, rate=30.0)))

    It has the methods of LeRobot's `ProcessorStep`, and needs no LeRobot to be imported. Actions
    are mappings with a number for each joint, such as "shoulder_pan.pos"; other entries, such as a
    gripper's, stay as they are. The first action of an episode is led to from the observation in
    the same transition, at which the arm has to rest. An action that is not finite makes the arm
    brake.

    Attributes:
        guard: of the arm; its joints are named as the motors, with or without ".pos".
        unit: of the actions and observations.
        answer: of the guard to the last action; None before the first.
    """

    def __init__(self, guard: Guard, *, unit: Literal["degrees", "radians"] = "degrees") -> None:
        self.guard = guard
        self.unit = check.choice(unit, "unit", _UNITS)
        self.answer: Admission | None = None
        names = guard.arm.joint_names
        self._keys = tuple(name if name.endswith(_ENDING) else name + _ENDING for name in names)

    # Any: what else a transition holds is LeRobot's.
    def __call__(self, transition: dict[str, Any]) -> dict[str, Any]:
        """The transition with the action that may be executed."""
        wanted = self._joints(transition.get("action"), "action")
        state = None
        if self.answer is None:
            state = self._joints(transition.get("observation"), "observation")
        self.answer = self.guard.admit(wanted[None], state)
        q = self.guard.next().q / _UNITS[self.unit]
        admitted = dict(zip(self._keys, q.tolist(), strict=True))
        return {**transition, "action": {**transition["action"], **admitted}}

    def reset(self) -> None:
        """Begins a new episode, whose first action comes with an observation."""
        self.answer = None

    def transform_features(self, features: dict[Any, Any]) -> dict[Any, Any]:
        """The features as they are: the step changes numbers only."""
        return features

    def get_config(self) -> dict[str, Any]:
        """Settings of the step in a pipeline's file; its user makes the guard anew."""
        return {"unit": self.unit, "rate": self.guard.rate}

    def state_dict(self) -> dict[str, Any]:
        """No tensors."""
        return {}

    def load_state_dict(self, state: dict[str, Any]) -> None:
        """Takes no tensors."""

    def _joints(self, values: object, name: str) -> Float64Array:
        """The arm's joints of an action or observation, rad."""
        if not isinstance(values, Mapping):
            raise InvalidInput(
                f"{name}: expected a mapping with {self._keys[0]!r} and the arm's other joints, "
                f"got {type(values).__name__}"
            )
        missing = [key for key in self._keys if key not in values]
        if missing:
            raise InvalidInput(
                f"{name}: expected {missing[0]!r}, got {', '.join(map(str, values))}"
            )
        return np.array([float(values[key]) for key in self._keys]) * _UNITS[self.unit]
