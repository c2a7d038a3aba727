"""Paths of the tip that a skill makes of a query, and others where the arm has no room."""

from __future__ import annotations

from collections.abc import Iterator

from leadthrough.errors import IkFailure, NoPath
from leadthrough.models.protocol import Mapped, Skill
from leadthrough.motion import JointTrajectory, Motion, PoseTrajectory, Trajectory
from leadthrough.shapes import Shape
from leadthrough.whole_arm.closing import closed_around
from leadthrough.whole_arm.detour import paths_beside
from leadthrough.whole_arm.query import Query
from leadthrough.whole_arm.room import Narrows, Room, narrows_at

TipMotion = Trajectory | PoseTrajectory
# Places beyond a part without room at which the arm is past it.
_PAST = 2


class TipPaths:
    """The paths for one query."""

    def __init__(self, skill: Skill[Motion], query: Query, room: Room) -> None:
        self._skill = skill
        self._query = query
        self._room = room
        self._closed: tuple[Shape, ...] = ()
        self._changes = 0
        self._beside: Iterator[TipMotion] = iter(())
        self._past = -1  # the sample at which the arm is past the part

    def first(self) -> TipMotion:
        """The path that the skill makes for the tip alone."""
        return self._generated(())

    def another(self, path: TipMotion, failure: IkFailure) -> TipMotion:
        """Another path, for one that the arm could not follow."""
        found: TipMotion | None
        if isinstance(self._skill, Mapped):
            found = self._closing(path, failure)
        else:
            found = self._aside(path, failure)
        if found is None:
            raise with_reason(failure, "no other path of the tip was found")
        return found

    def _closing(self, path: TipMotion, failure: IkFailure) -> TipMotion | None:
        narrows = self._narrows(path, failure)
        self._closed += closed_around(self._room, path, narrows, failure.q, self._changes)
        self._changes += 1
        try:
            return self._generated(self._closed)
        except NoPath:
            return None

    def _aside(self, path: TipMotion, failure: IkFailure) -> TipMotion | None:
        if failure.index > self._past:
            narrows = self._narrows(path, failure)
            self._beside = paths_beside(self._room, path, narrows, failure.q)
            self._past = int(narrows.widened(_PAST).samples[-1])
        return next(self._beside, None)

    def _narrows(self, path: TipMotion, failure: IkFailure) -> Narrows:
        narrows = narrows_at(self._room, path, failure.index, failure.q)
        if narrows.end:
            raise with_reason(failure, f"the arm cannot stand clear at the {narrows.end}")
        return narrows

    def _generated(self, closed: tuple[Shape, ...]) -> TipMotion:
        query = self._query.arguments()
        shapes = self._room.scene.shapes + closed
        if shapes and "obstacles" in self._skill.supports:
            query["obstacles"] = shapes
        motion = self._skill.generate(**query)
        if isinstance(motion, JointTrajectory):
            return self._room.arm.poses(motion)
        return motion


def with_reason(failure: IkFailure, reason: str) -> IkFailure:
    """The failure with a reason added to its message."""
    return IkFailure(
        f"{failure}; {reason}",
        index=failure.index,
        status=failure.status,
        residual=failure.residual,
        q=failure.q,
    )
