"""Parts of every learned primitive, discrete or rhythmic: in queries and in files."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypedDict

from leadthrough.models.archive import Arrays, FittedSkill
from leadthrough.models.dmp.orientation import OrientationCoordinates
from leadthrough.models.dmp.transformation import RHYTHMIC, TransformationSystem
from leadthrough.models.posture import Posture, arrays_of, settings_of
from leadthrough.motion import Event, MotionT_co, events_of_plain, plain_events


class Parts(TypedDict):
    """Attributes that all primitives have."""

    system: TransformationSystem
    events: tuple[Event, ...]
    joint_names: tuple[str, ...] | None
    orientation: OrientationCoordinates | None
    posture: Posture | None


@dataclass(frozen=True, eq=False, kw_only=True)
class Primitive(FittedSkill[MotionT_co]):
    """A learned primitive; its attributes are documented where they are public."""

    system: TransformationSystem
    events: tuple[Event, ...] = ()
    joint_names: tuple[str, ...] | None = None
    orientation: OrientationCoordinates | None = None
    posture: Posture | None = None

    def to_archive(self) -> tuple[dict[str, Any], Arrays]:
        settings = {
            "events": plain_events(self.events),
            "joint_names": None if self.joint_names is None else list(self.joint_names),
            **settings_of(self.posture),
        }
        orientation = {} if self.orientation is None else self.orientation.arrays()
        return settings, {**self.system.arrays(), **arrays_of(self.posture), **orientation}


def take_parts(
    settings: dict[str, Any], arrays: Arrays, *, form: str, weights: int, representation: str
) -> Parts:
    """The parts in a file, taken out of its settings."""
    names = settings.pop("joint_names", None)
    orientation = None
    if "controls" in arrays:
        rhythmic = form == RHYTHMIC
        orientation = OrientationCoordinates.from_arrays(representation, arrays, rhythmic=rhythmic)
    return Parts(
        system=TransformationSystem.from_arrays(form, weights, arrays),
        events=events_of_plain(settings.pop("events", ())),
        joint_names=None if names is None else tuple(names),
        orientation=orientation,
        posture=Posture.from_archive(settings, arrays),
    )
