"""Many tasks at once, on this machine or a Dask cluster; what is finished is never done again."""

from leadthrough.tasks.engine import (
    Execution,
    Outcome,
    Progress,
    pickled,
    run,
    with_manifest,
    with_progress,
)
from leadthrough.tasks.task import Row, Store, Task

__all__ = [
    "Execution",
    "Outcome",
    "Progress",
    "Row",
    "Store",
    "Task",
    "pickled",
    "run",
    "with_manifest",
    "with_progress",
]
