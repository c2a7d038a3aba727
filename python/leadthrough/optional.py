"""Packages that only some functions need, loaded when one of these is called."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from leadthrough.errors import MissingDependency


def load(module: str, *, extra: str) -> Any:  # Any: few of these packages declare types
    """The module of an optional package."""
    package = module.partition(".")[0]
    try:
        import_module(package)
        return import_module(module)
    except ImportError:
        raise MissingDependency(package, extra=extra) from None
