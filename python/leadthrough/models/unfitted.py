"""What the settings of a model answer when they are taken for a fitted skill."""

from __future__ import annotations

from typing import TYPE_CHECKING, NoReturn

from leadthrough.errors import NotFitted

_OF_SKILLS = frozenset(
    {
        "begin", "condition", "distribution", "duration", "generate", "plan", "plot", "policy",
        "preview", "sample", "save", "step", "supports",
    }
)  # fmt: skip


class Unfitted:
    """Models derive from this: `generate` says that `fit` comes first, and how it is called."""

    if not TYPE_CHECKING:  # type checkers shall refuse it

        def __getattr__(self, name: str) -> NoReturn:
            kind = type(self).__name__
            if name in _OF_SKILLS:
                raise NotFitted(
                    f"{name}: {kind} holds the settings of a model; fit it first: "
                    f"skill = {kind}().fit(demonstrations), then skill.{name}"
                )
            raise AttributeError(f"{kind!r} object has no attribute {name!r}")
