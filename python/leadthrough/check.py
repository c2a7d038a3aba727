"""Checks of users' arguments, where they enter the package; exceptions; bases of frozen values.

Functions return the checked value in the form that the rest of the package works with, and raise
InvalidInput, with the argument's name, what is right and what came. Values come in as `object`:
checking the type is what these functions are for.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import fields, is_dataclass
from importlib import import_module
from textwrap import wrap
from typing import Any, SupportsIndex, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

import leadthrough._core as core

Float64Array = NDArray[np.float64]
Text = TypeVar("Text", bound=str)
Kind = TypeVar("Kind")

# Rounding in a file format moves a recorded quaternion off length 1; more is not a rotation.
UNIT_LENGTH_TOLERANCE = 1e-2
MIN_STEP = 1e-60  # s; rates over shorter steps overflow in the third derivative
MAX_NUMBERS = 10**8  # that one call makes, 0.75 GiB
MAX_NUMBER = 1e100  # of a recording or query; products of larger ones overflow

# Texts of values at the prompt.
_WIDTH = 100  # characters of a line
_MAX_LINES = 5
_MAX_VALUE = 60  # characters of one value
_NUMBERS = 8  # of an array whose numbers are shown, not its shape

_FLOAT64 = np.dtype(np.float64)
# How messages begin: "rate: ...", "frames[2]: ...", perhaps behind a file: "day.csv: rate: ...".
_ARGUMENT = re.compile(r"(?:^|: )(?P<name>[a-z_]\w*(?:\[[^\]]*\])?): ")


class LeadthroughError(Exception):
    """Root of the package's errors; each can be pickled, so a worker process may raise it."""

    @property
    def argument(self) -> str | None:
        """Name of the argument at fault, such as "rate"; None if the message names none."""
        found = _ARGUMENT.search(str(self))
        return found["name"] if found else None

    def __reduce__(self) -> tuple[Any, ...]:  # Any: the type that Exception declares
        # Exception's own version calls the class with the message alone; some need more.
        return _restored, (type(self), self.args, self.__dict__)


class InvalidInput(LeadthroughError, ValueError):
    """An argument is wrong; the message names it, the expected and the given value.

    Every function raises it for an argument that is not as documented: another type or shape, out
    of the stated range, not finite. Under "Raises" stand only further causes.

    Attributes:
        argument: name of the argument, such as "rate"; None if no single one is at fault.
        value: the given value, if it is a number or a text; else None.
    """

    def __init__(self, message: str, *, argument: str | None = None, value: object = None) -> None:
        super().__init__(message)
        self._argument = argument
        self.value = value if isinstance(value, str | int | float) else None

    @property
    def argument(self) -> str | None:
        return super().argument if self._argument is None else self._argument


class UnsupportedQuery(InvalidInput):
    """The fitted skill cannot honour this part of a query."""


class FitError(LeadthroughError):
    """No model can be fitted to these demonstrations."""


class NotFitted(LeadthroughError, AttributeError):
    """A model was used like a fitted skill."""


class NoPath(LeadthroughError):
    """No path exists between start and goal.

    Attributes:
        reason: short code such as "start_in_wall" or "goal_enclosed".
    """

    def __init__(self, message: str, *, reason: str) -> None:
        super().__init__(message)
        self.reason = reason


class NoContinuousLogarithm(LeadthroughError):
    """A motion's rotation vectors cannot be continued without a jump.

    Attributes:
        index: sample at which the continuation breaks.
    """

    def __init__(self, message: str, *, index: int) -> None:
        super().__init__(message)
        self.index = index


class SchedulerUnreachable(LeadthroughError):
    """The scheduler of a Dask cluster does not answer any more; what was finished is stored."""


class CodeMismatch(InvalidInput):
    """A worker of a Dask cluster has other code than the machine that sends the tasks."""


class IkFailure(LeadthroughError):
    """No joint configuration reaches a sample of a motion.

    Attributes:
        index: sample that is not reached.
        status: why the solver stopped.
        residual: remaining errors (position in m, orientation in rad).
        q: closest joint configuration found, (n,) rad (m for prismatic joints).
        limiting_joints: the joints whose limits bar the way.
    """

    def __init__(
        self,
        message: str,
        *,
        index: int,
        status: str,
        residual: tuple[float, float],
        q: Float64Array,
        limiting_joints: tuple[str, ...] = (),
    ) -> None:
        super().__init__(message)
        self.index = index
        self.status = status
        self.residual = residual
        self.q = q
        self.limiting_joints = limiting_joints


class LimitsInfeasible(LeadthroughError):
    """No slower execution brings this motion inside the limits.

    Attributes:
        joint: name of the joint whose limits cannot be met.
    """

    def __init__(self, message: str, *, joint: str) -> None:
        super().__init__(message)
        self.joint = joint


class InvalidRobot(LeadthroughError, ValueError):
    """A robot description is malformed or contradicts itself.

    Attributes:
        where: element at fault.
        why: the fault.
    """

    def __init__(self, where: str, why: str) -> None:
        super().__init__(f"{where}: {why}")
        self.where = where
        self.why = why


class MissingDependency(LeadthroughError, ImportError):
    """An optional package is not installed.

    Attributes:
        package: name of the package.
        extra: extra of leadthrough that installs it.
    """

    def __init__(self, package: str, *, extra: str) -> None:
        super().__init__(
            f"{package} is not installed; install it with: pip install 'leadthrough[{extra}]'"
        )
        self.package = package
        self.extra = extra


def package(module: str, *, extra: str) -> Any:  # Any: few of these packages declare types
    """The module of a package that only some functions need, loaded when one of these is called."""
    name = module.partition(".")[0]
    try:
        import_module(name)
        return import_module(module)
    except ImportError:
        raise MissingDependency(name, extra=extra) from None


class Frozen:
    """Frozen dataclasses whose copies and pickles are checked again and as read-only."""

    __slots__ = ()

    def __reduce_ex__(self, protocol: SupportsIndex) -> str | tuple[Any, ...]:
        kind: Any = type(self)
        if not getattr(kind, "__dataclass_params__", None) or kind.__reduce__ != object.__reduce__:
            return super().__reduce_ex__(protocol)
        # All else is cached, and computed again.
        return _checked_again, (
            kind,
            {each.name: getattr(self, each.name) for each in fields(kind)},
        )


class ShortRepr(Frozen):
    """Classes that show their fields in one to five lines, without those that begin with "_"."""

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
    """The text of an object in at most five lines, cut off with "..." where it is longer."""
    layout: Any = {"subsequent_indent": "  ", "max_lines": _MAX_LINES, "placeholder": " ..."}
    return "\n".join(wrap(one_line(self), _WIDTH, **layout))


def one_line(value: ShortRepr) -> str:
    return f"{type(value).__name__}({', '.join(value._repr_parts())})"


def value_text(value: object) -> str:
    """One value of any type in a few words."""
    if isinstance(value, np.ndarray):
        few = value.ndim == 1 and value.size <= _NUMBERS and value.dtype.kind in "fiub"
        return numbers_text(value) if few else f"array ({', '.join(map(str, value.shape))})"
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, Mapping) and len(value) > 3:
        return f"{len(value)} entries"
    if isinstance(value, tuple | list) and len(value) > 3:
        return _several(value)
    text = one_line(value) if isinstance(value, ShortRepr) else repr(value)
    return text if len(text) <= _MAX_VALUE else f"{text[: _MAX_VALUE - 4]} ..."


def numbers_text(values: Any) -> str:  # Any: an array of numbers (n,)
    texts = (f"{0.0 if abs(value) < 1e-12 else value:.4g}" for value in values)
    return f"({', '.join(texts)})"


def _several(values: Sequence[object]) -> str:
    kinds = {type(value).__name__ for value in values}
    if kinds == {"str"}:
        return f"({values[0]!r} ... {values[-1]!r}, {len(values)} in all)"
    return f"{len(values)} of {' and '.join(sorted(kinds))}"


def _checked_again(kind: Any, state: dict[str, Any]) -> Any:  # Any: a type of frozen dataclasses
    """A value of a type by its fields, to the bit."""
    value = kind(**{each.name: state[each.name] for each in fields(kind) if each.init})
    for name, part in state.items():
        object.__setattr__(value, name, freeze(part))
    return value


def computed(kind: type[Kind], **parts: Any) -> Kind:  # Any: the fields of `kind`
    """A frozen dataclass of parts just computed, without another check of them."""
    value = object.__new__(kind)
    for part in parts.values():
        if isinstance(part, np.ndarray):
            part.setflags(write=False)
    vars(value).update(parts)
    return value


def freeze(part: Kind) -> Kind:
    """`part`, whose arrays become read-only, those in containers and dataclasses too."""
    if isinstance(part, np.ndarray):
        part.setflags(write=False)
    elif isinstance(part, tuple | list):
        for each in part:
            freeze(each)
    elif isinstance(part, Mapping):
        freeze(list(part.values()))
    elif is_dataclass(part) and not isinstance(part, type):
        freeze([getattr(part, each.name) for each in fields(part)])
    return part


def array(value: object, name: str, *, shape: Sequence[int | str]) -> Float64Array:
    """`value` as a finite, C-contiguous float64 array, which may share memory with `value`."""
    if len(shape) == 1 and core.is_finite_vector(value, shape[0]):
        return cast(Float64Array, value)  # the quick way: single poses come in a control loop
    return _checked(_numeric(value, name), name, shape)


def rank(value: object) -> int:
    """Number of axes of an array; 1 of what is none, which its check refuses by name."""
    try:
        axes = np.ndim(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, RuntimeError):
        return 1
    return axes if isinstance(axes, int) else 1  # a class of arrays has none yet


def regular(value: object, name: str) -> NDArray[Any]:
    """`value` as an array of its own type; raises InvalidInput where it has none."""
    if np.ma.is_masked(value):
        raise refused(name, "numbers", "masked ones, which are missing")
    try:
        return np.asarray(value)
    except (InvalidInput, TypeError, RuntimeError, OverflowError) as error:  # of the object itself
        raise refused(name, "numbers", f"a {type(value).__name__} ({error})") from None
    except ValueError:
        raise refused(name, "a regular array of numbers", "ragged rows") from None


def with_gaps(value: object, name: str, *, shape: Sequence[int | str]) -> Float64Array:
    """`value` checked as by `array`, but NaN and infinity may stand for missing numbers."""
    return _of_shape(_numeric(value, name), name, shape)


def array_of_rank(
    value: object, name: str, *, shapes: Sequence[Sequence[int | str]]
) -> Float64Array:
    """`value` checked as by `array` against the one of several shapes that has as many axes."""
    result = _numeric(value, name)
    for shape in shapes:
        if len(shape) == result.ndim:
            return _checked(result, name, shape)
    wanted = " or ".join(_shape_text(shape) for shape in shapes)
    raise refused(name, f"shape {wanted}", result.shape)


def frozen(value: object, name: str, *, shape: Sequence[int | str]) -> Float64Array:
    """A read-only copy of `value`, checked as by `array`."""
    with enough_memory(f"{name}: an array"):
        return freeze(array(value, name, shape=shape).copy())


def times(value: object, name: str) -> Float64Array:
    """`value` as at least one strictly increasing time, (n,) s; a read-only copy."""
    result = frozen(value, name, shape=("n",))
    if len(result) == 0:
        raise refused(name, "at least one sample", "none")
    with np.errstate(over="ignore"):  # an infinite duration is refused below
        steps = np.diff(result)
    if (steps <= 0).any():
        i = int(np.argmax(steps <= 0))
        raise refused(
            name,
            "strictly increasing times",
            f"{result[i]} s then {result[i + 1]} s at samples {i} and {i + 1}",
        )
    if steps.size and steps.min() < MIN_STEP:
        raise refused(name, f"steps of at least {MIN_STEP} s", f"one of {steps.min()} s")
    if not math.isfinite(float(result[-1]) - float(result[0])):
        raise refused(name, "a finite duration", f"{result[0]} to {result[-1]} s")
    return result


def quaternions(value: object, name: str, *, shape: Sequence[int | str]) -> Float64Array:
    """`value` as unit quaternions w, x, y, z, normalised; a copy."""
    result = array(value, name, shape=shape)
    unit = core.unit_quaternion(result, UNIT_LENGTH_TOLERANCE)
    if unit is not None:
        return unit
    length = np.sqrt(np.einsum("...i,...i", result, result))[..., None]
    worst = max(length.min(initial=1.0), length.max(initial=1.0), key=lambda x: abs(x - 1.0))
    if abs(worst - 1.0) > UNIT_LENGTH_TOLERANCE:
        raise refused(name, "unit quaternions w, x, y, z", f"one of length {worst:.6g}")
    return np.asarray(result / length)


def row(value: object, name: str, *, width: int) -> Float64Array:
    """`value` as numbers (width,), read-only; a single number stands for all of them."""
    given = frozen(value, name, shape=() if rank(value) == 0 else (width,))
    return np.broadcast_to(given, (width,))


def unit_quaternions(value: object, name: str, *, shape: Sequence[int | str]) -> Float64Array:
    """`value` as unit quaternions w, x, y, z, to the bit as they were; a read-only copy."""
    quaternions(value, name, shape=shape)
    return frozen(value, name, shape=shape)


def number(
    value: object,
    name: str,
    *,
    above: float | None = None,
    at_least: float | None = None,
    below: float | None = None,
    at_most: float | None = None,
) -> float:
    """`value` as a finite float within bounds."""
    if isinstance(value, (bool, np.bool_, str, bytes)):
        raise refused(name, "a number", _short(value), value)
    try:
        result = float(value)  # type: ignore[arg-type]  # whether it can be one is the question
    except (TypeError, ValueError, OverflowError):
        raise refused(name, "a number", _short(value), value) from None
    if not (
        math.isfinite(result)
        and (above is None or result > above)
        and (at_least is None or result >= at_least)
        and (below is None or result < below)
        and (at_most is None or result <= at_most)
    ):
        bounds = (("> ", above), (">= ", at_least), ("< ", below), ("<= ", at_most))
        wanted = " and ".join(f"{sign}{bound}" for sign, bound in bounds if bound is not None)
        raise refused(name, f"a finite number {wanted}".rstrip(), _short(value), value)
    return result


def integer(value: object, name: str, *, at_least: int, at_most: int | None = None) -> int:
    """`value` as an int within bounds; a float is refused, even a whole one."""
    if isinstance(value, (bool, np.bool_)) or not isinstance(value, (int, np.integer)):
        raise refused(name, "an integer", _short(value), value)
    result = int(value)
    if result < at_least or (at_most is not None and result > at_most):
        upper = "" if at_most is None else f" and <= {at_most}"
        raise refused(name, f"an integer >= {at_least}{upper}", result, result)
    return result


def affordable_count(value: object, name: str, *, each: int) -> int:
    """`value` as a count >= 1 of things that together take no more than `MAX_NUMBERS` numbers."""
    count = integer(value, name, at_least=1)
    if count * each > MAX_NUMBERS:
        raise refused(
            name,
            f"at most {MAX_NUMBERS // each:,}",
            f"{count:,}, which would take {count * each * 8 >> 30:,} GiB",
            count,
        )
    return count


@contextmanager
def enough_memory(what: str) -> Iterator[None]:
    """Names what is too large for the memory of the machine."""
    try:
        yield
    except MemoryError:
        raise InvalidInput(f"{what} is too large for this machine's memory") from None


@contextmanager
def prefixed(words: object) -> Iterator[None]:
    """Puts words before the message of an InvalidInput, such as the file or option at fault."""
    try:
        yield
    except InvalidInput as error:
        raise InvalidInput(f"{words}: {error}") from None


def choice(value: object, name: str, options: Collection[Text]) -> Text:
    if isinstance(value, str):
        for option in options:
            if option == value:
                return option
    names = ", ".join(repr(option) for option in options)
    raise refused(name, f"one of {names}", _short(value), value)


def names(value: Sequence[str], name: str, *, count: int) -> tuple[str, ...]:
    """The names of columns, one for each, or none at all."""
    if isinstance(value, str) or not isinstance(value, Sequence):
        raise refused(name, "a sequence of names", _short(value), value)
    if not all(isinstance(each, str) for each in value):
        raise refused(name, "names as text", _short(value))
    if value and len(value) != count:
        raise refused(name, f"{count} names, one per column", len(value))
    return tuple(value)


def column_order(given: Sequence[str], wanted: Sequence[str], name: str) -> list[int]:
    """Indices of the columns `wanted` among those `given`: the same names, in any order."""
    # LeRobot's names of motors end in ".pos".
    own = [each.removesuffix(".pos") for each in given]
    if not set(wanted) <= set(given) and sorted(own) == sorted(wanted):
        return [own.index(each) for each in wanted]
    if sorted(given) != sorted(wanted):
        wanted_text, given_text = (", ".join(each) or "without names" for each in (wanted, given))
        raise refused(name, f"the joints {wanted_text}", given_text)
    return [given.index(each) for each in wanted]


def instance(value: object, name: str, kind: Any, wanted: str = "") -> None:
    """Refuses a value that is not of a class, or of one of a union, whose name is `wanted`."""
    if not isinstance(value, kind):
        raise refused(name, wanted or f"a {kind.__name__}", type(value).__name__)


def refused(name: str, expected: str, got: object, value: object = None) -> InvalidInput:
    """The error of an argument: the expected value and the given one."""
    message = f"{name}: expected {expected}, got {got}"
    return InvalidInput(message, argument=name, value=value)


def _of_shape(result: Float64Array, name: str, shape: Sequence[int | str]) -> Float64Array:
    if result.shape != shape and not _fits(result.shape, shape):
        raise refused(name, f"shape {_shape_text(shape)}", result.shape)
    return result


def _checked(result: Float64Array, name: str, shape: Sequence[int | str]) -> Float64Array:
    _of_shape(result, name, shape)
    if not core.all_finite(result):
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(result))[0])
        position = f" at index {where if len(where) > 1 else where[0]}" if where else ""
        raise refused(name, "finite numbers", f"{result[where]}{position}")
    return result


def _numeric(value: object, name: str) -> Float64Array:
    if type(value) is np.ndarray and value.dtype is _FLOAT64 and value.flags.c_contiguous:
        return value
    with suppress(ValueError):  # of ragged rows, which are named below
        value = _without_mask(value)
    raw = regular(value, name)
    if raw.dtype.kind not in "fiu":
        # Booleans, complex numbers, strings and objects would be turned into something plausible.
        got = f"{_short(value)} of dtype {raw.dtype}{part_to_give(value)}"
        raise refused(name, "numbers", got, value)
    with enough_memory(f"{name}: an array of shape {raw.shape}"):
        return np.ascontiguousarray(raw, dtype=np.float64).reshape(raw.shape)


def _without_mask(value: object) -> object:
    """Masked numbers with NaN where they are missing; all else as it is."""
    parts = value if isinstance(value, list | tuple) else [value]
    if not any(isinstance(each, np.ma.MaskedArray) for each in parts):
        return value
    given: Any = np.ma.asarray(value)
    return given.astype(np.float64).filled(np.nan) if given.dtype.kind in "fiu" else given.data


def part_to_give(value: object) -> str:
    """The end of a message about an object of which a part was meant; empty if there is none."""
    parts = (part for part in ("motion", "joints") if hasattr(value, part))
    return next((f"; give its {part}" for part in parts), "")


def _fits(actual: tuple[int, ...], shape: Sequence[int | str]) -> bool:
    if len(actual) != len(shape):
        return False
    if len(shape) == 1:  # the quick way: most are vectors
        return isinstance(shape[0], str) or actual[0] == shape[0]
    named: dict[str, int] = {}
    for size, wanted in zip(actual, shape, strict=True):
        expected = named.setdefault(wanted, size) if isinstance(wanted, str) else wanted
        if size != expected:
            return False
    return True


def _shape_text(shape: Sequence[int | str]) -> str:
    comma = "," if len(shape) == 1 else ""
    return f"({', '.join(str(size) for size in shape)}{comma})"


def _short(value: object) -> str:
    """A value as a message shows it: a number of NumPy like any other, at most 60 characters."""
    text = " ".join(repr(value.item() if isinstance(value, np.generic) else value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."


def _restored(
    kind: type[LeadthroughError], args: tuple[Any, ...], attributes: dict[str, Any]
) -> LeadthroughError:
    error = kind.__new__(kind, *args)
    error.__dict__.update(attributes)
    return error
