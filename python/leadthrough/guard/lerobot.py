"""A guard in a LeRobot pipeline: processor steps for actions by motor names."""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Mapping
from typing import Any, Literal

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.guard.admission import Admission
from leadthrough.guard.chunks import Chunks
from leadthrough.guard.guard import Guard

_UNITS = {"degrees": np.pi / 180.0, "radians": 1.0}
_ENDING = ".pos"


class GuardStep:
    """A processor step that passes the commands that its guard admits, one action at a time.

        pipeline.steps.append(GuardStep(lt.Guard(arm, rate=30.0)))

    It has the methods of LeRobot's `ProcessorStep`, and counts as one where LeRobot is installed.
    Actions are mappings with a number for each joint, such as "shoulder_pan.pos"; other entries,
    such as a gripper's, stay as they are. The first action of an episode is led to from the
    observation in the same transition, at which the arm has to rest. An action that is not finite
    makes the arm brake.

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
        return self._sent(transition, self.guard.next().q)

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

    def _sent(self, transition: dict[str, Any], q: Float64Array) -> dict[str, Any]:
        """The transition with joints (joints,), rad, as its action."""
        admitted = dict(zip(self._keys, (q / _UNITS[self.unit]).tolist(), strict=True))
        return {**transition, "action": {**(transition.get("action") or {}), **admitted}}

    def _joints(self, values: object, name: str) -> Float64Array:
        """The arm's joints of an action or observation, rad."""
        if not isinstance(values, Mapping):
            raise InvalidInput(
                f"{name}: expected a mapping with {self._keys[0]!r} and the arm's other joints, "
                f"got {type(values).__name__}"
            )
        missing = [key for key in self._keys if key not in values]
        if missing:
            raise check.refused(name, repr(missing[0]), ", ".join(map(str, values)))
        columns = np.broadcast_arrays(*(np.asarray(values[key], np.float64) for key in self._keys))
        return np.stack(columns, axis=-1) * _UNITS[self.unit]


class ChunkStep(GuardStep):
    """A processor step that follows chunks of actions, one transition a period of the guard.

        pipeline.steps.append(ChunkStep(lt.guard.Chunks(lt.Guard(arm, rate=200.0), rate=30.0)))

    An action is a chunk, a mapping with n numbers for each joint, or None while the policy has no
    new one; other entries stay as they are. A chunk was observed at the number of seconds at
    "observed_at" in the transition's "complementary_data", on the clock; by default now. The first
    transition of an episode has an observation, at which the arm has to rest.

    Attributes:
        chunks: of the guard's arm; its joints are named as the motors, with or without ".pos".
    """

    def __init__(
        self,
        chunks: Chunks,
        *,
        unit: Literal["degrees", "radians"] = "degrees",
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__(chunks.guard, unit=unit)
        self.chunks = chunks
        self._clock = clock

    def __call__(self, transition: dict[str, Any]) -> dict[str, Any]:
        """The transition with the action that is to be executed now."""
        now = self._clock()
        if self.answer is None:
            self.chunks.start(self._joints(transition.get("observation"), "observation"), now)
        if (action := transition.get("action")) is not None:
            observed = (transition.get("complementary_data") or {}).get("observed_at", now)
            self.chunks.put(np.atleast_2d(self._joints(action, "action")), observed)
        q = self.chunks.next(now).q
        self.answer = self.chunks.answer
        return self._sent(transition, q)


def _register() -> None:
    """Makes the steps count as LeRobot's own: its pipelines take no others."""
    try:
        pipeline = importlib.import_module("lerobot.processor.pipeline")
    except ImportError:
        return  # not installed
    pipeline.ProcessorStep.register(GuardStep)


_register()
