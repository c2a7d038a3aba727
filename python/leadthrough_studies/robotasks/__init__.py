"""Real kinesthetic pose demonstrations of tasks, each left out in turn (RoboTasks)."""

from leadthrough_studies.robotasks.study import STUDY

__all__ = ["STUDY"]
