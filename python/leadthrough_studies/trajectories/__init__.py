"""What notes on trajectory generation say of curves (Grioli 2023)."""

from leadthrough_studies.trajectories.study import STUDY

__all__ = ["STUDY"]
