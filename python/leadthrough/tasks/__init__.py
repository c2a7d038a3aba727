"""Many tasks at once, on this machine or a Dask cluster; what is finished is never done again."""

from leadthrough.tasks.engine import Outcome, run
from leadthrough.tasks.manifest import listed
from leadthrough.tasks.progress import Shown, shown
from leadthrough.tasks.store import Store
from leadthrough.tasks.task import Row, Task

__all__ = ["Outcome", "Row", "Shown", "Store", "Task", "listed", "run", "shown"]
