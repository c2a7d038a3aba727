"""A package of somebody else that adds a model to leadthrough."""

from leadthrough.models import ModelEntry

STRAIGHT = ModelEntry(
    "straight", "theirs_package.straight:Straight", ("straight",), motions=("points",)
)
