"""Orientation primitives on agricultural tasks of a TIAGo (Lauretti et al. 2023)."""

from leadthrough_studies.agriculture.study import STUDY

__all__ = ["STUDY"]
