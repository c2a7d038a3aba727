"""Short representations of objects, as the prompt shows them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from textwrap import wrap
from typing import Any

import numpy as np
from numpy.typing import NDArray

from leadthrough.check import Frozen

_WIDTH = 100  # characters of a line
_MAX_LINES = 5
_MAX_VALUE = 60  # characters of one value
_NUMBERS = 8  # of an array whose numbers are shown, not its shape


class ShortRepr(Frozen):
    """Classes that derive from this one show their fields in one to five lines.

    Arrays are shown by their shape, unless they are small; fields whose name begins with an
    underscore are not shown.
    """

    __slots__ = ()

    def __init_subclass__(cls, **options: Any) -> None:  # Any: those of classes further on
        super().__init_subclass__(**options)
        if "__repr__" not in vars(cls):
            # In the class itself, so that the decorator `dataclass` leaves it as it is.
            cls.__repr__ = _short_repr  # type: ignore[method-assign, assignment]

    def _repr_parts(self) -> Sequence[str]:
        """Texts between the parentheses."""
        if not is_dataclass(self):
            return ()
        shown = (each.name for each in fields(self) if each.repr and each.name[0] != "_")
        return [f"{name}={value_text(getattr(self, name))}" for name in shown]


def _short_repr(self: ShortRepr) -> str:
    return in_lines(one_line(self))


def in_lines(text: str) -> str:
    """The text in at most five lines, cut off with "..." where it is longer."""
    lines = wrap(text, _WIDTH, subsequent_indent="  ", max_lines=_MAX_LINES, placeholder=" ...")
    return "\n".join(lines)


def one_line(value: ShortRepr) -> str:
    """The text of an object inside that of another."""
    return f"{type(value).__name__}({', '.join(value._repr_parts())})"


def value_text(value: object) -> str:
    """One value of any type in a few words."""
    if isinstance(value, np.ndarray):
        return _array_text(value)
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, Mapping) and len(value) > 3:
        return f"{len(value)} entries"
    if isinstance(value, tuple | list) and len(value) > 3:
        return _several(value)
    text = one_line(value) if isinstance(value, ShortRepr) else repr(value)
    return text if len(text) <= _MAX_VALUE else f"{text[: _MAX_VALUE - 4]} ..."


def _array_text(values: NDArray[Any]) -> str:
    if values.ndim == 1 and values.size <= _NUMBERS and values.dtype.kind in "fiub":
        return numbers_text(values)
    return f"array ({', '.join(map(str, values.shape))})"


def numbers_text(values: Any) -> str:  # Any: an array of numbers (n,)
    """Numbers as (0.3, 0, 0.59)."""
    texts = (f"{0.0 if abs(value) < 1e-12 else value:.4g}" for value in values)
    return f"({', '.join(texts)})"


def _several(values: Sequence[object]) -> str:
    kinds = {type(value).__name__ for value in values}
    if kinds == {"str"}:
        return f"({values[0]!r} ... {values[-1]!r}, {len(values)} in all)"
    return f"{len(values)} of {' and '.join(sorted(kinds))}"
