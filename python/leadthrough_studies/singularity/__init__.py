"""Paths past two singularities of a Panda (Yang et al.)."""

from leadthrough_studies.singularity.study import STUDY

__all__ = ["STUDY"]
