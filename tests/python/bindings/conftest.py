"""Parametrizes tests over the calls of the compiled core's bindings."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from bindings.calls import CALLS, MADE, OPTIONAL, OTHERS

from leadthrough import _core as core


@pytest.fixture
def compiled() -> ModuleType:
    """The module under test."""
    return core


@pytest.fixture
def made() -> list[Any]:
    """At least one object of every class."""
    return [*MADE, *OTHERS]


@pytest.fixture
def called() -> set[str]:
    """The functions and methods that are called."""
    return {label(function) for function, _, _ in CALLS}


def label(function: Callable[..., Any]) -> str:
    owner = type(getattr(function, "__self__", None)).__name__
    return f"{owner}.{function.__name__}" if hasattr(core, owner) else function.__name__


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Parametrizes tests over the calls whose result is known, or over arguments of a type."""
    if "expected" in metafunc.fixturenames:
        known = [noted for noted in CALLS if noted[2] is not None]
        each = [pytest.param(*noted, id=label(noted[0])) for noted in known]
        metafunc.parametrize(("function", "arguments", "expected"), each)
    for kind, wanted in (("sized", is_array), ("needed", is_needed)):
        if kind in metafunc.fixturenames:
            each = [
                pytest.param(function, arguments, name, id=f"{label(function)}-{name}")
                for function, arguments, _ in CALLS
                for name, value in arguments.items()
                if wanted(function, name, value)
            ]
            metafunc.parametrize(("function", "arguments", kind), each)


def is_array(_function: Callable[..., Any], _name: str, value: object) -> bool:
    return isinstance(value, np.ndarray)


def is_needed(function: Callable[..., Any], name: str, value: object) -> bool:
    """Whether None cannot stand for the argument; to a flag None is False."""
    return not isinstance(value, bool) and name not in OPTIONAL.get(function.__name__, ())
