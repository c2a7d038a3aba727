"""What a plan for the whole arm consists of."""

from __future__ import annotations

from dataclasses import dataclass

from leadthrough.motion import JointTrajectory, PoseTrajectory, Trajectory
from leadthrough.repr import ShortRepr


@dataclass(frozen=True, eq=False)
class PlannedMotion(ShortRepr):
    """A motion that the whole arm can run.

    Attributes:
        joints: along the path, certified clear between samples.
        tip: the motion that the tip goes through.
        deviation: the most that the tip is away from the path that the skill makes of the same
            query for the tip alone, m; 0 where the arm could follow it.
        clearance: the least distance of the arm from the obstacles between samples too, m; infinite
            without obstacles.
        reasons: why the tip had to leave that path, one line for each time that it was changed.
        connected: when the arm goes through joint space, with its tip anywhere, from and to, s;
            None where it does not.
    """

    joints: JointTrajectory
    tip: Trajectory | PoseTrajectory
    deviation: float
    clearance: float
    reasons: tuple[str, ...]
    connected: tuple[float, float] | None = None

    @property
    def rounds(self) -> int:
        """How often the tip's path was planned."""
        return len(self.reasons) + 1
