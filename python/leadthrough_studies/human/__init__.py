"""Velocities of human and of damped-least-squares demonstrations in ProMPs (Yang et al.)."""

from leadthrough_studies.human.study import STUDY

__all__ = ["STUDY"]
