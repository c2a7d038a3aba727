"""Skills of dynamical systems in files."""

from __future__ import annotations

from typing import Any

from leadthrough import check
from leadthrough.check import InvalidInput
from leadthrough.models.archive import Arrays
from leadthrough.models.coordinates import Coordinates
from leadthrough.models.dynamical.skill import DynamicalSkill
from leadthrough.models.registry import entry_of_class


# Any: settings are whatever JSON holds.
def from_archive(settings: dict[str, Any], arrays: Arrays) -> DynamicalSkill:
    """The skill from the settings and arrays that `DynamicalSkill.to_archive` returned."""
    coordinates = Coordinates.from_archive(settings, arrays)
    kind = entry_of_class(settings["name"]).load()
    own = {
        name.removeprefix("field_"): check.frozen(value, name, shape=value.shape)
        for name, value in arrays.items()
        if name.startswith("field_")
    }
    field = kind.system.from_arrays(own)
    if field.size != coordinates.width:
        raise InvalidInput(f"field: expected {coordinates.width} columns, got {field.size}")
    return DynamicalSkill(
        kind(**settings["model"]),
        coordinates,
        field,
        check.frozen(arrays["scale"], "scale", shape=(coordinates.width,)),
        check.frozen(arrays["ends"], "ends", shape=(2, coordinates.width)),
        check.number(settings["duration"], "duration", above=0.0),
        check.number(settings["pace"], "pace", above=0.0),
        check.frozen(arrays["positions"], "positions", shape=("n", coordinates.width)),
    )
