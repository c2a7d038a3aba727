"""Parametrizes tests over the calls of the compiled core's bindings."""

from collections.abc import Callable
from types import ModuleType
from typing import Any

import bindings.calls_of_cells
import bindings.calls_of_curves
import bindings.calls_of_guard
import bindings.calls_of_learning  # noqa: F401, all note their calls
import pytest
from bindings.calls import CALLS, MADE, OTHERS

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
    """Parametrizes tests over the calls, and over their arguments where a test asks for `name`."""
    if "expected" in metafunc.fixturenames:
        each = [pytest.param(*noted, id=label(noted[0])) for noted in CALLS]
        metafunc.parametrize(("function", "arguments", "expected"), each)
    if "name" in metafunc.fixturenames:
        each = [
            pytest.param(function, arguments, name, id=f"{label(function)}-{name}")
            for function, arguments, _ in CALLS
            for name in arguments
        ]
        metafunc.parametrize(("function", "arguments", "name"), each)
