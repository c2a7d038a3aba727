"""Every method that the papers compare with, and all models of the package, by one protocol."""

from leadthrough_studies.comparison.study import STUDY

__all__ = ["STUDY"]
