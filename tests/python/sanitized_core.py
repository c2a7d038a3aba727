"""A pytest plugin that runs tests with another build of the core, named by LEADTHROUGH_CORE.

`./do sanitize` loads it, with a core built with AddressSanitizer.
"""

import importlib.util
import os
import sys

NAME = "leadthrough._core"


def load(path):
    """Makes the extension at `path` the package's core, before the package looks for its own."""
    spec = importlib.util.spec_from_file_location(NAME, path)
    sys.modules[NAME] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules[NAME])


load(os.environ["LEADTHROUGH_CORE"])
