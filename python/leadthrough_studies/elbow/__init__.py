"""Obstacles in the way of the elbow, not of the tip."""

from leadthrough_studies.elbow.study import STUDY

__all__ = ["STUDY"]
