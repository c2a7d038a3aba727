"""Curves of notes on trajectory generation (Grioli 2023)."""

from leadthrough_studies.trajectories.study import STUDY

__all__ = ["STUDY"]
