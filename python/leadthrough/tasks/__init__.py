"""Many tasks at once, on this machine or a Dask cluster; what is finished is never done again."""

from leadthrough.tasks.engine import (
    Execution as Execution,
    Outcome as Outcome,
    Progress as Progress,
    pickled as pickled,
    run as run,
    with_manifest as with_manifest,
    with_progress as with_progress,
)
from leadthrough.tasks.task import Row as Row, Store as Store, Task as Task
