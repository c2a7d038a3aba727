"""Every binding called, and called with damaged arguments of a fixed seed: it answers or raises.

`./do sanitize` runs this with AddressSanitizer, which ends the run if a binding leaves its arrays.
"""

import contextlib
from collections.abc import Callable
from typing import Any

import numpy as np
from bindings.calls import CALLS, OPTIONAL

ROUNDS = 20
NUMBERS = (np.nan, np.inf, -np.inf, 0.0, -1.0, 1e-30, 1e30)


def damaged_array(value: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The array with one number replaced, of another shape or of another type."""
    kind = rng.integers(3)
    if kind == 0 and value.size and value.dtype.kind == "f":
        changed = value.copy()
        changed.flat[rng.integers(value.size)] = rng.choice(NUMBERS)
        return changed
    if kind == 1:
        return value.astype(rng.choice(["float32", "complex128", ">f8"]))
    return np.resize(value, rng.integers(0, 5, value.ndim))


def damaged_number(value: float, rng: np.random.Generator) -> float:
    """Another number of the same type."""
    if isinstance(value, bool):
        return not value
    return int(rng.integers(-2, 5)) if isinstance(value, int) else float(rng.choice(NUMBERS))


def damaged(value: Any, rng: np.random.Generator, made: list[Any]) -> Any:
    """Another value of the same type; for an object, another of those that were made."""
    if isinstance(value, np.ndarray):
        return damaged_array(value, rng)
    if isinstance(value, int | float):
        return damaged_number(value, rng)
    if isinstance(value, str):
        return value[: rng.integers(len(value) + 1)]
    if isinstance(value, list):
        kept = [each for each in value if rng.random() < 0.7]
        return [damaged(each, rng, made) if rng.random() < 0.3 else each for each in kept]
    alike = [each for each in made if type(each) is type(value)]
    return alike[rng.integers(len(alike))] if alike else value


def test_calls_and_their_optional_arguments_are_computed_with(made: list[Any]) -> None:
    for function, arguments, _ in CALLS:
        function(**arguments)
        for name in set(arguments) & set(OPTIONAL.get(function.__name__, ())):
            function(**arguments | {name: None})
    for thing in made:
        for name, value in vars(type(thing)).items():
            if isinstance(value, property):
                getattr(thing, name)


def test_damaged_arguments_raise_or_are_computed_with(made: list[Any]) -> None:
    for function, arguments, _ in CALLS:
        rng = np.random.default_rng(15)
        for _ in range(ROUNDS):
            names = [name for name in arguments if rng.random() < 1.5 / len(arguments)]
            changed = {name: damaged(arguments[name], rng, made) for name in names}
            answered(function, arguments | changed)


def test_none_of_something_raises_or_is_computed_with() -> None:
    """No joints, points or columns: every axis of one length has none of it."""
    for function, arguments, _ in CALLS:
        arrays = {name: value for name, value in arguments.items() if isinstance(value, np.ndarray)}
        for length in sorted({size for value in arrays.values() for size in value.shape}):
            without = {
                name: np.resize(value, [size * (size != length) for size in value.shape])
                for name, value in arrays.items()
            }
            answered(function, arguments | without)


def answered(function: Callable[..., Any], arguments: dict[str, Any]) -> None:
    """Calls a function, which may refuse its arguments."""
    print(function.__name__, arguments)  # seen where the call ends the process, by pytest -s
    with contextlib.suppress(TypeError, ValueError, IndexError):
        function(**arguments)
