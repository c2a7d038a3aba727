"""Every public name of the reference, with what it names."""

import importlib
import inspect
import re
from pathlib import Path

import leadthrough as lt

PAGES = Path(__file__).parents[3] / "docs" / "api"
NAME = re.compile(r"^::: leadthrough\.(\S+)$", re.MULTILINE)


def named(name):
    """A public object by its name without the package's."""
    found = lt
    for part in name.split("."):
        found = getattr(found, part, None) or importlib.import_module(f"{found.__name__}.{part}")
    return found


def public_callables():
    """Public names without the package's, and those of classes' members, each with its object."""
    for name in {n for page in PAGES.glob("*.md") for n in NAME.findall(page.read_text())}:
        value = named(name)
        yield name, value
        if inspect.isclass(value):
            members = [each for each in dir(value) if not each.startswith("_")]
            yield from ((f"{name}.{member}", getattr(value, member)) for member in members)
