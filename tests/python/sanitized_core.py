"""A pytest plugin: runs tests with another build of the core, and sees that they call all of it.

`./do sanitize` loads it, with a core built with AddressSanitizer that LEADTHROUGH_CORE names. The
session fails if a function of the core was never called.
"""

import functools
import importlib.util
import os
import sys

import pytest

NAME = "leadthrough._core"
uncalled = set()


def counted(name, function):
    @functools.wraps(function)
    def call(*args, **kwargs):
        uncalled.discard(name)
        return function(*args, **kwargs)

    return call


def load(path):
    spec = importlib.util.spec_from_file_location(NAME, path)
    core = importlib.util.module_from_spec(spec)
    sys.modules[NAME] = core  # before the package looks for its own
    spec.loader.exec_module(core)
    for name, value in list(vars(core).items()):
        if type(value).__name__ == "builtin_function_or_method":
            uncalled.add(name)
            setattr(core, name, counted(name, value))


def pytest_sessionfinish(session, exitstatus):
    if exitstatus == 0 and uncalled:
        print(f"\nnever called: {', '.join(sorted(uncalled))}")
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


load(os.environ["LEADTHROUGH_CORE"])
