"""A policy from three demonstrations, and a thousand episodes made of them in three ways."""

from leadthrough_studies.augmentation.study import STUDY

__all__ = ["STUDY"]
