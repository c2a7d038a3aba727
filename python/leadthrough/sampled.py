"""What all motions have: samples at times, of which there are pieces and places between."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from leadthrough import check
from leadthrough.brief import numbers_text
from leadthrough.check import Float64Array
from leadthrough.drawing.drawn import Drawn
from leadthrough.errors import InvalidInput
from leadthrough.events import Events, within

_FIELDS = ("positions", "orientations", "velocities", "accelerations")


def rows_of(recorded: object) -> dict[str, Any]:
    """The arrays (n, k) of a motion or recording that there are, by their fields, but the times."""
    found = {name: getattr(recorded, name, None) for name in _FIELDS}
    if (joints := getattr(recorded, "joints", None)) is not None:
        found["joints"] = joints.positions
    return {name: rows for name, rows in found.items() if rows is not None}


def fields_of(recorded: object, rows: Mapping[str, Any]) -> dict[str, Any]:
    """The arrays as `rows_of` returns them, as the fields of a motion or recording."""
    joints, own = rows.get("joints"), getattr(recorded, "joints", None)
    if joints is None or own is None:
        return dict(rows)
    # The motion puts them on its own clock.
    counted = type(own)(range(len(joints)), joints, joint_names=own.joint_names)
    return {**rows, "joints": counted}


class Sampled(Drawn):
    """Samples at times; the motions derive from it."""

    times: Float64Array
    positions: Float64Array
    events: Events

    def __len__(self) -> int:
        return len(self.times)

    def __getitem__(self, samples: slice) -> Self:
        """The motion of some samples, at their own times, with the events between them."""
        if not isinstance(samples, slice):
            raise InvalidInput(
                f"samples: expected a slice such as motion[10:20], got {samples!r}; `positions` "
                "has single samples, and `at` tells where a motion is at a time"
            )
        times = self.times[samples]
        if len(times) == 0:
            raise InvalidInput(
                f"samples: expected some of the {len(self.times)} samples, got none in {samples}"
            )
        between = within(self.events, float(times[0]), float(times[-1]))
        rows = {name: rows[samples] for name, rows in rows_of(self).items()}
        motion: Any = self  # a dataclass, of whichever type
        piece: Self = replace(motion, times=times, events=between, **fields_of(self, rows))
        return piece

    def _places(self, times: ArrayLike) -> tuple[bool, Float64Array, Float64Array]:
        """Whether there are several times, these (m,), and the positions (m, d) then."""
        several = np.ndim(times) > 0
        at = check.array(times if several else [times], "time", shape=("m",))
        first, last = self.times[0], self.times[-1]
        outside = (at < first) | (at > last)
        if outside.any():
            raise InvalidInput(
                f"time: expected {first:.6g} to {last:.6g} s, got {at[outside][0]:.6g} s"
            )
        columns = [np.interp(at, self.times, column) for column in self.positions.T]
        return several, at, np.column_stack(columns)

    def _brief_parts(self) -> list[str]:
        span = f"{len(self.times)} samples over {self.duration:.4g} s"
        names = [event.name for event in self.events]
        return [span, *self._way(), *([f"events {', '.join(names)}"] if names else [])]

    def _way(self) -> list[str]:
        """What is told of the columns."""
        first, last = (numbers_text(row) for row in self.positions[[0, -1]])
        return [f"{first} to {last}"]

    @property
    def duration(self) -> float:
        """Time from the first sample to the last, s."""
        return float(self.times[-1] - self.times[0])
