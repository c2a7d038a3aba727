"""What a stack of tasks returns: motions of the joints, with a report on each task."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Float64Array
from leadthrough.drawing.drawn import Drawn
from leadthrough.drawing.panels import Panel, over
from leadthrough.motion import JointTrajectory
from leadthrough.repr import ShortRepr


@dataclass(frozen=True, eq=False, slots=True)
class TaskReport(ShortRepr):
    """How each task fared; every array is (tasks,).

    Attributes:
        error: in m and rad, rotations counting 0.3 m per rad; of tasks that keep a distance, by how
            much it is violated.
        miss: difference between the motion and what the task asks for, the same per s or s^2.
        activation: 1; of tasks that keep a distance, 0 to 1.
        limited: whether a joint limit, or a higher task that keeps a distance, stood in its way.
    """

    error: Float64Array
    miss: Float64Array
    activation: Float64Array
    limited: NDArray[np.bool_]


@dataclass(frozen=True, eq=False, slots=True)
class StackSolution(ShortRepr):
    """The motion for one interval.

    Attributes:
        motion: (joints,) in rad/s or rad/s^2 (m for prismatic joints), inside the limits.
        report: how each task fared.
    """

    motion: Float64Array
    report: TaskReport


@dataclass(frozen=True, eq=False, slots=True)
class StackRun(Drawn):
    """A closed-loop run; the arrays are (samples, tasks) and mean what those of TaskReport mean.

    Attributes:
        trajectory: the joints.
        error: in m and rad.
        miss: in m/s and rad/s.
        activation: 0 to 1.
        limited: whether something stood in the task's way.
    """

    trajectory: JointTrajectory
    error: Float64Array
    miss: Float64Array
    activation: Float64Array
    limited: NDArray[np.bool_]

    def _panels(self) -> list[Panel]:
        names = [f"task {i + 1}" for i in range(self.error.shape[1])]
        errors = over(self.trajectory.times, self.error, names, title="errors in m and rad")
        return [*self.trajectory._panels()[:1], errors]
